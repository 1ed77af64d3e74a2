"""Rays are those of the program, to the bit; and they bend as theory says."""

import json
import math

import bhs
import numpy as np
import pytest
from conftest import HOLE, ROOM

NUMBERS = ["phi", "steps", "queries", "time", "redshift", "b", "L", "Q", "winding"]


def some_rays(count):
    random = np.random.default_rng(1)
    origins = random.normal(size=(count, 3)) * 2 + [0, 1, -4]
    return origins, random.normal(size=(count, 3))


def is_same(found, right):
    """A number of the program, or none."""
    return math.isnan(found) if right is None else float(found) == right


def test_rays_are_those_of_the_program(room, traced):
    scene = bhs.load(room)
    origins, directions = some_rays(500)
    rays = scene.trace(origins, directions)
    assert rays.shape == (500,)
    right = traced(room, "--rays", np.hstack([origins, directions]))
    assert {said["outcome"] for said in right} == {"hit", "escaped", "captured"}
    for ray, said in zip(rays, right, strict=True):
        assert ray["outcome"] == said["outcome"]
        for name in ["point", "direction"]:
            assert all(is_same(x, y) for x, y in zip(ray[name], said.get(name, [None] * 3), strict=True))
        assert ray["shape"] == said.get("shape", -1)
        assert ray["shape_name"] == said.get("shape_name", "")
        assert ray["shape_place"] == said.get("shape_place", "")
        assert all(is_same(ray[name], said[name]) for name in NUMBERS)
    assert scene.shapes[1].name == "sphere" and scene.shapes[1].place.endswith("room.bhs:13:9")


def test_what_becomes_of_a_ray_does_not_depend_on_the_others():
    scene = bhs.loads(ROOM)
    origins, directions = some_rays(300)
    together = scene.trace(origins, directions, threads=2)
    order = np.random.default_rng(2).permutation(300)
    mixed = scene.trace(origins[order], directions[order], threads=1)
    assert together[order].tobytes() == mixed.tobytes()
    alone = np.array([scene.trace(*ray) for ray in zip(origins[:20], directions[:20], strict=True)])
    assert alone.tobytes() == together[:20].tobytes()


def test_shapes_are_those_of_arrays():
    scene = bhs.loads(HOLE)
    assert scene.trace([0, 0, 9], [0, 0, 1]).shape == ()
    assert scene.trace(np.zeros((4, 1, 3)) + [0, 0, 9], np.ones((5, 3))).shape == (4, 5)
    assert scene.trace(np.zeros((0, 3)), [0, 0, 1]).shape == (0,)
    assert scene.connect(np.zeros((0, 3)), [0, 0, 1]).shape == (0,)
    for bad in [([0, 0], [0, 0, 1]), ([0, 0, 9], 1.0), (np.ones((2, 3)), np.ones((3, 3)))]:
        with pytest.raises(ValueError, match=r"shape|broadcast"):
            scene.trace(*bad)


def test_rays_that_are_none_are_named():
    scene = bhs.loads(HOLE)
    starts = np.full((3, 3), 9.0)
    for directions, why in [([[1, 0, 0], [0, 0, 0], [1, 0, 0]], "ray 1: the direction is zero"), ([[1, 0, 0]] * 2 + [[1, np.nan, 0]], "ray 2: .*finite")]:
        with pytest.raises(bhs.Error, match=why):
            scene.trace(starts, directions)
    with pytest.raises(bhs.Error, match="ray 0: its footprint"):
        scene.trace(starts, [1, 0, 0], footprint=-1)
    with pytest.raises(ValueError, match="`near` or `far`"):
        scene.trace(starts, [1, 0, 0], side="left")
    with pytest.raises(bhs.Error, match="pair 0: the two points are the same"):
        scene.connect([1, 2, 9], [1, 2, 9])


def deflection(closest):
    """Angle by which light is bent that comes as near as `closest` to a mass of 1: 2 int_0^1 du / sqrt(1 - u^2 - (2/r0)(1 - u^3)) - pi, u = r0/r = 1 - s^2."""
    s, weights = np.polynomial.legendre.leggauss(400)
    s, weights = (s + 1) / 2, weights / 2
    u = 1 - s * s
    # (1 - u^2 - (2/r0)(1 - u^3)) / (1 - u), without the difference of like numbers.
    rest = (1 + u) - 2 / closest * (1 + u + u * u)
    return 2 * float(weights @ (2 / np.sqrt(rest))) - math.pi


@pytest.mark.parametrize("integrator", ["exact", "adaptive"])
def test_light_is_bent_as_by_the_closed_form(integrator):
    scene = bhs.loads(f'Integrator "{integrator}" "float tolerance" 1e-9 {HOLE}')
    closest = np.array([3.2, 4.0, 6.0, 20.0, 1e3, 1e5])
    # From where the light is nearest, across: half of the way, and half of the angle.
    rays = scene.trace(np.outer(closest, [1, 0, 0]), [0, 0, 1])
    assert (rays["outcome"] == "escaped").all()
    bent = np.arctan2(-rays["direction"][:, 0], rays["direction"][:, 2])
    right = np.array([deflection(r) / 2 for r in closest])
    assert np.abs(bent % (2 * math.pi) - right).max() < (1e-9 if integrator == "exact" else 1e-6)


def test_light_within_the_critical_impact_parameter_is_captured():
    scene = bhs.loads(f'Integrator "exact" {HOLE}')
    low, high = np.array([4.0]), np.array([7.0])
    for _ in range(40):
        middle = (low + high) / 2
        rays = scene.trace([[float(middle[0]), 0, -2000]], [0, 0, 1])
        captured = rays["outcome"] == "captured"
        low, high, b = np.where(captured, middle, low), np.where(captured, high, middle), rays["b"]
    assert abs(b[0] - math.sqrt(27)) < 1e-6


def test_rays_of_pixels_are_those_of_the_program(room, program):
    pixels = np.stack(np.meshgrid(np.arange(0, 40, 5), np.arange(0, 30, 5)), axis=-1)
    scene = bhs.load(room)
    rays = scene.trace_pixels(pixels)
    assert rays.shape == (6, 8)
    flags = [word for x, y in pixels.reshape(-1, 2) for word in ("--pixel", f"{x},{y}")]
    right = [json.loads(line) for line in program("trace", room, *flags).splitlines()]
    for ray, said in zip(rays.ravel(), right, strict=True):
        assert ray["outcome"] == said["outcome"] and all(is_same(ray[name], said[name]) for name in NUMBERS)
        assert ray["ray_origin"].tolist() == said["ray"]["origin"] and ray["ray_direction"].tolist() == said["ray"]["direction"]
    assert len({said["outcome"] for said in right}) == 3
    with pytest.raises(bhs.Error, match="40 columns and 30 rows"):
        scene.trace_pixels([40, 0])
    for bad in [[1.5, 2], [-1, 2], [1, 2, 3]]:
        with pytest.raises(ValueError, match="expected"):
            scene.trace_pixels(bad)


def test_the_way_of_a_ray_leads_to_its_end(room):
    scene = bhs.load(room)
    origin, direction = [1.8, 1, -6], [0, 0, 1]
    way, end = scene.path(origin, direction), scene.trace(origin, direction)
    assert len(way) > 3 and np.allclose(way["point"][0], origin) and way["time"][0] == 0
    assert end["outcome"] == "hit" and np.allclose(way["point"][-1], end["point"], atol=1e-5)
    assert way["phi"][-1] == end["phi"] and (np.diff(way["time"]) > 0).all() and (way["side"] == "near").all()


def test_connections_are_those_of_the_program(room, traced):
    random = np.random.default_rng(3)
    p, q = random.uniform(-1, 1, (50, 3)) + [0, 1, -3], random.uniform(-1, 1, (50, 3)) + [0, 1, 2.5]
    rows = bhs.load(room).connect(p, q)
    right = [dict(c, pair=k) for k, said in enumerate(traced(room, "--connect", np.hstack([p, q]))) for c in said["connections"]]
    assert len(rows) == len(right) > 60
    for row, said in zip(rows, right, strict=True):
        assert {name: row[name].tolist() for name in row.dtype.names} == said


def test_in_flat_space_one_straight_line_joins_two_points():
    scene = bhs.loads('WorldBegin LightSource "infinite" Shape "sphere" "float radius" 0.5')
    rows = scene.connect([[0, 0, -2], [0, 3, -2]], [[0, 0, 2], [0, 3, 2]])
    assert rows["pair"].tolist() == [0, 1] and rows["blocked"].tolist() == [True, False]
    assert np.allclose(rows["spread"], 16) and np.allclose(rows["launch"], [0, 0, 1]) and (rows["phi"] == 0).all()


def test_far_sides_are_named():
    scene = bhs.loads('WorldBegin Wormhole "ellis" "float throat" 1 LightSource "infinite"')
    rays = scene.trace([[0, 0, -5], [0, 0, -5]], [[0, 0, 1], [0, 1, 0]])
    assert rays["side"].tolist() == ["far", "near"]
    back = scene.trace([0, 0, -5], [0, 0, 1], side="far")
    assert back["side"] == "near"


def test_progress_of_rays():
    told = []
    bhs.loads(HOLE).trace(np.full((20000, 3), 5.0), [0, 0, 1], progress=lambda done, total: told.append((done, total)))
    assert told == sorted(told) and told[-1] == (20000, 20000)
