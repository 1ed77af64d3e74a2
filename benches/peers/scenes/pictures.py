"""A picture on the wall, a repeated one on the floor, and a matt ball."""

from stage import ASPECT, CAMERA, ball, grey, stage


def build(peer, mi, folder, spectra):
    # Mitsuba's pictures have their first row at v = 0; both repeat.
    turned = lambda u, v: mi.ScalarTransform4f().scale([u, -v, 1])
    file = {"type": "bitmap", "filename": str(peer.ROOT / "grammar/examples/tiles.png")}
    picture = {**file, "to_uv": turned(1, 1)}
    many = {**file, "filter_type": "nearest", "to_uv": turned(3, 2)}
    return {**stage(mi, peer.diffuse(many), peer.diffuse(picture)), "ball": ball(0, peer.diffuse(grey(0.3)))}, CAMERA, 8
