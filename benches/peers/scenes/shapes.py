"""A disk, a cylinder that is a lamp, and an OBJ file that stands in three places, once mirrored."""

import math

from stage import ASPECT, CAMERA, grey, stage


def build(peer, mi, folder, spectra):
    t = mi.ScalarTransform4f()
    unit = lambda axis: [x / math.hypot(*axis) for x in axis]  # what Mitsuba does not do
    diffuse = lambda reflectance: {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
    pyramid = {
        "type": "obj", "filename": str(peer.ROOT / "grammar/examples/pyramid.obj"), "face_normals": True,
        "to_world": t.translate([0, 0.01, 0]), "bsdf": diffuse(peer.spectrum(spectra / "cornell_red.spd")),
    }
    place = lambda to_world: {"type": "instance", "to_world": to_world, "shapes": {"type": "ref", "id": "pyramid"}}
    shapes = {
        **stage(mi, diffuse(grey(0.5)), diffuse(grey(0.7))),
        "disk": {
            "type": "disk", "bsdf": diffuse(grey(0.8)),
            "to_world": t.translate([-1.1, 1.5, -0.6]).rotate([1, 0, 0], 30).rotate([0, 1, 0], 25).scale(0.6),
        },
        "cylinder": {
            "type": "cylinder", "p0": [0, 0, -0.4], "p1": [0, 0, 0.4], "radius": 0.15,
            "to_world": t.translate([1.2, 1.3, 0]).rotate(unit([1, 0, 1]), 60),
            "bsdf": {"type": "diffuse", "reflectance": 0.0}, "emitter": {"type": "area", "radiance": grey(4)},
        },
        "pyramid": {"type": "shapegroup", "shape": pyramid},
        "first": place(t.translate([-1, 0, 0.8]).rotate([0, 1, 0], 20).scale([0.4, 0.8, 0.4])),
        "second": place(t.translate([0.1, 0.5, 0.2]).rotate(unit([1, 2, 3]), 35).scale([-0.4, 0.4, 0.3])),
        "third": place(t.translate([1.2, 0, 0.9]).scale([0.3, 0.3, 0.5])),
    }
    return shapes, CAMERA, 6
