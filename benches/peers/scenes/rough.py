"""Rough glass and rough gold on a checkerboard."""

from stage import ASPECT, CAMERA, ball, grey, stage


def index(spectra, name, column):
    """A column of a table of n and k, joined by straight lines as in bhs."""
    rows = [line.replace(",", " ").split() for line in (spectra / name).read_text().splitlines()]
    rows = [[float(x) for x in r] for r in rows if r and r[0][0].isdigit()]
    points = sorted((r[0], r[column]) for r in rows)
    return {"type": "irregular", "wavelengths": ", ".join(repr(p[0]) for p in points), "values": ", ".join(repr(p[1]) for p in points)}


def build(peer, mi, folder, spectra):
    board = {"type": "checkerboard", "color0": grey(0.2), "color1": grey(0.7), "to_uv": mi.ScalarTransform4f().scale([3, 3, 1])}
    gold = {
        "type": "roughconductor", "distribution": "ggx", "alpha": 0.15,
        "eta": index(spectra, "Au_JohnsonChristy1972.csv", 1), "k": index(spectra, "Au_JohnsonChristy1972.csv", 2),
    }
    shapes = {
        **stage(mi, peer.diffuse(board), peer.diffuse(grey(0.5))),
        "glass": ball(-0.85, {"type": "roughdielectric", "distribution": "ggx", "alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0}),
        "gold": ball(0.85, gold),
    }
    return shapes, CAMERA, 8
