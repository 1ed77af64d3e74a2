"""A picture on the wall, a repeated one on the floor, and a matt ball."""

from stage import ASPECT, CAMERA, ball, grey, stage


def build(peer, mi, folder, spectra):
    picture = {"type": "bitmap", "filename": str(peer.ROOT / "grammar/examples/tiles.png")}
    many = {**picture, "filter_type": "nearest", "to_uv": mi.ScalarTransform4f().scale([3, 2, 1])}
    return {**stage(mi, peer.diffuse(many), peer.diffuse(picture)), "ball": ball(0, peer.diffuse(grey(0.3)))}, CAMERA, 8
