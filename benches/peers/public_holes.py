#!/usr/bin/env python3
"""A black hole in public rooms, two integrators against each other: benches/peers/public_holes.py BHS FOLDER [SCENE...]

FOLDER is a copy of https://github.com/gonsolo/bitterli. The files stay as they are: the hole is a file of one line, given by `--include`, halfway to what the
middle of the picture shows and a fortieth of that distance in radius. Each room is rendered with `adaptive` and with `exact`, with the same seed, so that most of the
noise is the same. Means of 8 x 6 blocks are compared: of each room the script prints the ratio of the whole means, the greatest deviation of a block, and the same
of `adaptive` with another seed, which is what noise alone does."""

import json
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR

BLOCKS = (6, 8)
SIZE = (128, 96)


def blocks(path):
    """Mean luminances of the blocks; the few brightest pixels are limited, which single paths make."""
    channels = OpenEXR.File(path).channels()
    rgb = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], -1)
    y = np.nan_to_num(rgb.astype(float)) @ [0.2126, 0.7152, 0.0722]
    y = np.minimum(y, np.quantile(y, 0.995))
    return np.array([[b.mean() for b in np.array_split(row, BLOCKS[1], 1)] for row in np.array_split(y, BLOCKS[0], 0)])


def ask(command):
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(run.stderr.strip()[:300])
    return run.stdout


def hole(bhs, scene):
    """The line that puts a hole into the room."""
    size = "x".join(map(str, SIZE))
    seen = json.loads(ask([bhs, "trace", scene, "--resolution", size, "--pixel", f"{SIZE[0] // 2},{SIZE[1] // 2}"]).splitlines()[0])
    eye, point = np.array(seen["ray"]["origin"]), np.array(seen["point"])
    center = " ".join(f"{x:.6g}" for x in (eye + point) / 2)
    return f'BlackHole "schwarzschild" "point3 center" [{center}] "float rs" {np.linalg.norm(point - eye) / 40:.6g}\n'


def main():
    bhs, folder, wanted = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3:]
    for name in wanted or sorted(os.listdir(folder)):
        scene = os.path.join(folder, name, "pbrt", "scene-v4.pbrt")
        if not os.path.exists(scene):
            continue
        with tempfile.TemporaryDirectory() as out:
            line, pictures = os.path.join(out, "hole.bhs"), []
            try:
                with open(line, "w") as file:
                    file.write(hole(bhs, scene))
                for i, (integrator, seed) in enumerate([("adaptive", 1), ("exact", 1), ("adaptive", 2)]):
                    picture = os.path.join(out, f"{i}.exr")
                    ask([bhs, "render", scene, "--include", line, "--integrator", integrator, "--seed", str(seed), "--spp", "32", "--quiet",
                         "--resolution", "x".join(map(str, SIZE)), "-o", picture])
                    pictures.append(blocks(picture))
            except (RuntimeError, KeyError, TypeError) as error:
                print(f"{name}: {error}")
                continue
        adaptive, exact, other = pictures
        # Of what is next to black, a share says nothing.
        scale = np.maximum(adaptive, 0.05 * adaptive.mean())
        off, noise = np.abs((exact - adaptive) / scale).max(), np.abs((other - adaptive) / scale).max()
        print(f"{name:20} ratio {exact.mean() / adaptive.mean():.4f}  greatest {off:.4f}  with another seed {other.mean() / adaptive.mean():.4f}  {noise:.4f}",
              flush=True)


if __name__ == "__main__":
    main()
