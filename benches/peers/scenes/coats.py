"""Plastic, smooth and rough, and blends of two materials."""

from stage import ASPECT, CAMERA, ball, grey, stage


def build(peer, mi, folder, spectra):
    # As a number, Mitsuba 3.9.1's checkerboard has its two values the other way round than as a colour.
    board = {"type": "checkerboard", "color0": 0.9, "color1": 0.2, "to_uv": mi.ScalarTransform4f().scale([3, 3, 1])}
    half, dark = ({"type": "diffuse", "reflectance": grey(v)} for v in (0.5, 0.05))
    mirror = {"type": "conductor", "material": "none", "specular_reflectance": grey(0.8)}
    two_sided = lambda bsdf: {"type": "twosided", "bsdf": bsdf}
    plastic = {"nonlinear": True, "int_ior": 1.5, "ext_ior": 1.0}
    shapes = {
        **stage(
            mi,
            two_sided({"type": "blendbsdf", "weight": 0.4, "first": half, "second": mirror}),
            two_sided({"type": "blendbsdf", "weight": board, "first": dark, "second": half}),
        ),
        "smooth": ball(-0.85, {"type": "plastic", "diffuse_reflectance": peer.spectrum(spectra / "cornell_red.spd"), **plastic}),
        "rough": ball(0.85, {
            "type": "roughplastic", "distribution": "ggx", "alpha": 0.1,
            "diffuse_reflectance": peer.spectrum(spectra / "cornell_green.spd"), **plastic,
        }),
    }
    return shapes, CAMERA, 8
