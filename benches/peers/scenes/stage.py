"""The stage of the small scenes: a floor, a wall behind it, a lamp above, a camera in front. In each NAME.bhs it is `Include`d as stage.bhs."""

CAMERA = dict(origin=[0, 1.5, 5], target=[0, 0.9, 0], fov=40)
ASPECT = 4.0 / 3.0


def grey(value):
    """The same at all wavelengths: no illuminant in it."""
    return {"type": "irregular", "wavelengths": "359, 831", "values": f"{value}, {value}"}


def stage(mi, floor, wall):
    """The shapes of the stage; texture coordinates go from (0, 0) at the left front or bottom to (1, 1)."""
    t = mi.ScalarTransform4f()
    return {
        "floor": {"type": "rectangle", "to_world": t.rotate([1, 0, 0], -90).scale(2), "bsdf": floor},
        "wall": {"type": "rectangle", "to_world": t.translate([0, 1.5, -2]).scale([2, 1.5, 1]), "bsdf": wall},
        "lamp": {
            "type": "rectangle",
            "to_world": t.translate([0, 3.5, 0.5]).rotate([1, 0, 0], 90).scale(0.7),
            "bsdf": {"type": "diffuse", "reflectance": 0.0},
            "emitter": {"type": "area", "radiance": grey(20)},
        },
    }


def ball(x, bsdf):
    return {"type": "sphere", "center": [x, 0.7, 0], "radius": 0.7, "bsdf": bsdf}
