#!/usr/bin/env python3
"""Two programs side by side: relative mean square error at equal processor time.

    benches/against.py OLD NEW [--scene spheres_hole ...] [--size 120x90] [--spp 64] [--seeds 8] [--keep FOLDER] [--also "--noise 0.05 --noise-over picture"]

OLD and NEW are bhs programs (of two commits, say). Both render the same files of scenes/ on one thread, in turn, each round with a seed of its own. The
reference is NEW's, with a hundred times the samples and a seed of its own; `--keep` keeps references for the next call. `--also` renders a third picture, by NEW
with these arguments in place of `--spp`, such as adaptive sampling.

Relative MSE: mean over the pixels of (Y - R)^2 / (R^2 + (0.02 mean R)^2), the reference's own variance taken off, which is a hundredth of NEW's. Error times
time counts: a program that is twice as fast at equal error is as good as one with half of the error at equal time. Fireflies: pixels brighter than 5 times the
median of their 5x5 neighbourhood, leaving out those whose reference is itself above 2 times its own; the mean of them over the seeds. Needs numpy and OpenEXR.
"""
import argparse, pathlib, resource, statistics, subprocess, tempfile
import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent
LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750])
TIMES = 100  # samples of a reference over those of a picture


def render(program, scene, seed, out, size, arguments):
    """Processor seconds of a render."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "render", f"scenes/{scene}.bhs", "-o", out, "--resolution", size, "--seed", str(seed), "--threads", "1", "--quiet"]
    subprocess.run([str(word) for word in command] + arguments, check=True, cwd=ROOT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def luminance(path):
    channels = OpenEXR.File(str(path)).parts[0].channels
    rgb = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], -1)
    return rgb.astype(np.float64) @ LUMINANCE


def medians(picture):
    padded = np.pad(picture, 2, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (5, 5))
    return np.median(windows.reshape(*picture.shape, 25), axis=-1)


def relative_mse(picture, reference):
    return np.mean((picture - reference) ** 2 / (reference**2 + (0.02 * reference.mean()) ** 2))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("--scene", nargs="+", default=["spheres_hole", "spheres", "cornell_hole", "gold_dragon", "bunny_hole"])
    parser.add_argument("--size", default="120x90")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--also", action="append", default=[])
    given = parser.parse_args()
    programs = [("old", given.old.resolve(), ["--spp", str(given.spp)]), ("new", given.new.resolve(), ["--spp", str(given.spp)])]
    programs += [(words, given.new.resolve(), words.split()) for words in given.also]
    print("| scene | program | processor s | relative MSE | MSE x time, old over this | fireflies |\n|---|---|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as folder:
        keep = given.keep or pathlib.Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        for scene in given.scene:
            reference = keep.resolve() / f"{scene}_{given.size}_{given.spp * TIMES}.exr"
            if not reference.exists():
                render(given.new.resolve(), scene, 1_000_000, reference, given.size, ["--spp", str(given.spp * TIMES)])
            expected = luminance(reference)
            seldom_bright = expected <= 2 * medians(expected)
            found = {name: ([], [], []) for name, _, _ in programs}
            for seed in range(1, given.seeds + 1):
                for name, program, arguments in programs:
                    out = pathlib.Path(folder) / "picture.exr"
                    seconds, errors, flies = found[name]
                    seconds.append(render(program, scene, seed, out, given.size, arguments))
                    picture = luminance(out)
                    errors.append(relative_mse(picture, expected))
                    flies.append(np.sum((picture > 5 * medians(picture)) & seldom_bright))
            of_reference = np.mean(found["new"][1]) / (TIMES + 1)
            cost = {name: (np.mean(errors) - of_reference) * statistics.median(seconds) for name, (seconds, errors, _) in found.items()}
            for name, (seconds, errors, flies) in found.items():
                error = np.mean(errors) - of_reference
                ratio = f"{cost['old'] / cost[name]:.2f}"
                print(f"| `{scene}` | {name} | {statistics.median(seconds):.2f} | {error:.5f} | {ratio} | {np.mean(flies):.1f} |", flush=True)


main()
