#!/usr/bin/env python3
"""Lights and cameras of bhs beside those of Mitsuba 3: six small scenes, each stated for both in this file, compared block by block as in
compare_mitsuba.py. See README.md beside this file."""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import numpy as np

from compare_mitsuba import ROOT, SameObserver, blocks, compare, render_bhs, render_mitsuba, report

SIZE = 96

# A floor and a ball, the same numbers in both programs: right-handed, +y up, seen from +z.
WORLD_BHS = """
WorldBegin
{light}
Material "diffuse" "float reflectance" 0.6
Shape "trianglemesh" "point3 P" [-4 0 4  4 0 4  4 0 -4  -4 0 -4] "integer indices" [0 1 2  0 2 3]
Translate 0.3 0.8 0
Shape "sphere" "float radius" 0.7
"""
OPTIONS_BHS = """
Scale -1 1 1
LookAt 0.5 2.5 5  0 0.7 0  0 1 0
LightTransport "path" "integer maxdepth" 4
Film "rgb"
{camera}
"""
EYE = dict(origin=[0.5, 2.5, 5], target=[0, 0.7, 0], up=[0, 1, 0])


def uniform(value):
    """A spectrum that is the same at all wavelengths."""
    return {"type": "irregular", "wavelengths": "359, 831", "values": f"{value}, {value}"}


def sky_file(mi, folder):
    """A smooth equirectangular sky: greys, with a soft sun."""
    width, height = 512, 256
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    up = np.cos(math.pi * v)
    d = np.stack([np.sin(math.pi * v) * np.sin(2 * math.pi * u), up, -np.sin(math.pi * v) * np.cos(2 * math.pi * u)], -1)
    sun = np.array([0.5, 0.6, 0.4]) / np.linalg.norm([0.5, 0.6, 0.4])
    grey = 0.5 + 0.3 * up + 30.0 * np.exp(-(1.0 - d @ sun) / 0.02)
    path = Path(folder) / "sky.exr"
    mi.Bitmap(np.repeat(grey[..., None], 3, -1).astype(np.float32)).write(str(path))
    return path


def scenes(mi, folder):
    """Name: light of bhs, light of Mitsuba, camera of bhs, sensor of Mitsuba."""
    t = mi.ScalarTransform4f
    eye = t().look_at(**EYE)
    pinhole = {"type": "perspective", "fov": 40, "fov_axis": "smaller", "to_world": eye}
    pinhole_bhs = 'Camera "perspective" "float fov" 40'
    point = {"type": "point", "position": [1.5, 3, 2], "intensity": uniform(9)}
    point_bhs = 'LightSource "point" "spectrum I" 9 "point3 from" [1.5 3 2]'
    sky = sky_file(mi, folder)
    # Mitsuba's picture of the sky has +y up, its left edge -z, and goes on towards +x.
    sky_bhs = f'AttributeBegin Transform [0 0 -1 0  1 0 0 0  0 1 0 0  0 0 0 1] LightSource "infinite" "string filename" "{sky}" AttributeEnd'
    return {
        "envmap": (sky_bhs, {"type": "envmap", "filename": str(sky)}, pinhole_bhs, pinhole),
        "point": (point_bhs, point, pinhole_bhs, pinhole),
        "spot": (
            'LightSource "spot" "spectrum I" 20 "point3 from" [1.5 3 2] "point3 to" [0 0.5 0] "float coneangle" 20 "float conedeltaangle" 0.001',
            {"type": "spot", "intensity": uniform(20), "cutoff_angle": 20.0, "beam_width": 19.999,
             "to_world": t().look_at(origin=[1.5, 3, 2], target=[0, 0.5, 0], up=[0, 1, 0])},
            pinhole_bhs, pinhole),
        "distant": (
            'LightSource "distant" "spectrum L" 3 "point3 from" [1 2 1.5] "point3 to" [0 0 0]',
            {"type": "directional", "irradiance": uniform(3), "direction": [-1, -2, -1.5]}, pinhole_bhs, pinhole),
        "orthographic": (
            point_bhs, point, 'Camera "orthographic" "float screenwindow" [-2 2 -2 2]',
            {"type": "orthographic", "to_world": eye @ t().scale([2, 2, 1]), "near_clip": 1e-3}),
        "thinlens": (
            point_bhs, point, 'Camera "perspective" "float fov" 40 "float lensradius" 0.25 "float focaldistance" 4',
            {"type": "thinlens", "fov": 40, "fov_axis": "smaller", "aperture_radius": 0.25, "focus_distance": 4.0, "to_world": eye}),
    }


def mitsuba_scene(mi, light, sensor, film):
    grey = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": uniform(0.6)}}
    t = mi.ScalarTransform4f
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 5, "rr_depth": 100_000},
        "sensor": {**sensor, "film": film, "sampler": {"type": "independent"}},
        "light": light,
        "floor": {"type": "rectangle", "to_world": t().rotate([1, 0, 0], -90) @ t().scale([4, 4, 1]), "bsdf": grey},
        "ball": {"type": "sphere", "center": [0.3, 0.8, 0], "radius": 0.7, "bsdf": grey},
    })


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", action="append", help="default: all")
    parser.add_argument("--variant", default="scalar_spectral", help="Mitsuba's variant (default: %(default)s)")
    parser.add_argument("--bhs", type=Path, default=ROOT / "bhs", help="the program (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=6, help="independent renders by each program (default: %(default)s)")
    parser.add_argument("--spp", type=int, default=256, help="samples a pixel in each render (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=0, help="threads for each program (default: all)")
    options = parser.parse_args()

    import mitsuba as mi
    mi.set_variant(options.variant)
    observer = SameObserver(mi, ROOT / "plugins/spectra/data")
    passed = True
    with tempfile.TemporaryDirectory() as folder:
        for name, (light_bhs, light, camera_bhs, sensor) in scenes(mi, folder).items():
            if options.scene and name not in options.scene:
                continue
            file = Path(folder) / f"{name}.bhs"
            file.write_text(OPTIONS_BHS.format(camera=camera_bhs) + WORLD_BHS.format(light=light_bhs))
            scene = mitsuba_scene(mi, light, sensor, observer.film(SIZE, SIZE))
            theirs = [render_mitsuba(mi, scene, observer, options.spp, 1 + i) for i in range(options.seeds)]
            ours = [render_bhs(mi, options.bhs, file, (SIZE, SIZE), options.spp, 1 + i, options.threads, folder) for i in range(options.seeds)]
            result, _, _ = compare(name, [blocks(im) for im in ours], [blocks(im) for im in theirs], 0.01, 0.01)
            result.update(width=SIZE, height=SIZE, seeds=options.seeds, spp_bhs=options.spp, spp_mitsuba=options.spp, tolerance=0.01)
            report(result)
            sys.stdout.flush()
            passed &= result["pass"]
    sys.exit(0 if passed else 1)


if __name__ == "__main__":
    main()
