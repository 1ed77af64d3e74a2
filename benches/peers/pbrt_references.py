#!/usr/bin/env python3
"""Public pbrt scenes by bhs beside the pictures that come with them, by block means: benches/peers/pbrt_references.py BHS FOLDER [SCENE...]

FOLDER is a copy of https://github.com/gonsolo/bitterli; each scene there has a `TungstenRender.exr`, made by the renderer that the scenes were written for.
The means of 8 x 6 blocks are compared; of each scene the script prints the ratio of the whole means, the median and the greatest deviation of a
block from that ratio, and how many blocks lie within a tenth of the reference. Needs numpy and OpenEXR (`pip install OpenEXR`)."""

import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR

BLOCKS = (6, 8)
WIDTH = 160


def read(path):
    channels = OpenEXR.File(path).channels()
    names = {name: channels[name].pixels for name in channels}
    if "RGB" in names:
        return np.nan_to_num(names["RGB"].astype(float))
    if "RGBA" in names:
        return np.nan_to_num(names["RGBA"].astype(float)[..., :3])
    return np.nan_to_num(np.stack([names[c].astype(float) for c in "RGB"], -1))


def blocks(picture):
    """Mean luminances of the blocks; the few brightest pixels are limited, since two programs have other fireflies."""
    y = picture @ [0.2126, 0.7152, 0.0722]
    y = np.minimum(y, np.quantile(y, 0.999))
    rows = [a for a in np.array_split(y, BLOCKS[0], 0)]
    return np.array([[b.mean() for b in np.array_split(row, BLOCKS[1], 1)] for row in rows])


def main():
    bhs, folder, wanted = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3:]
    for name in wanted or sorted(os.listdir(folder)):
        scene = os.path.join(folder, name, "pbrt", "scene-v4.pbrt")
        found = [os.path.join(folder, name, k, "TungstenRender.exr") for k in ("pbrt", "mitsuba", "tungsten", ".")]
        found = [path for path in found if os.path.exists(path)]
        if not os.path.exists(scene) or not found:
            continue
        reference = read(found[0])
        height = round(WIDTH * reference.shape[0] / reference.shape[1])
        with tempfile.TemporaryDirectory() as out:
            picture = os.path.join(out, "picture.exr")
            command = [bhs, "render", scene, "--resolution", f"{WIDTH}x{height}", "--spp", "64", "--quiet", "-o", picture]
            run = subprocess.run(command, capture_output=True, text=True)
            if run.returncode:
                print(f"{name}: {re.sub(chr(10), ' ', run.stderr)[:200]}")
                continue
            ours = read(picture)
        a, b = blocks(ours), blocks(reference)
        whole = a.mean() / b.mean()
        off = np.abs(a / np.maximum(b, 1e-6) / whole - 1)
        near = np.mean(np.abs(a / np.maximum(b, 1e-6) - 1) < 0.1)
        print(f"{name:20} ratio {whole:.3f}  median {np.median(off):.3f}  greatest {off.max():.3f}  within a tenth {near:.0%}", flush=True)


main()
