#!/usr/bin/env python3
"""Times flat-space path tracing by bhs and by Mitsuba 3: the same scenes, depth, roulette, pixels, samples and threads. See README.md.

The programs render in turn, so that what else the machine does falls on all alike; medians count. Loading a scene and compiling
kernels (a first render, with another seed) are not timed. From the renders of all seeds comes the variance of one sample,
and from that the efficiency, 1 / (variance x time): samples a second at equal variance per sample.
"""

import argparse
import gzip
import json
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import compare_mitsuba as peers

ROOT = peers.ROOT
# Linear sRGB to luminance (IEC 61966-2-1).
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
# Bounces before roulette: bhs counts the bounces before the first one that may end a path, Mitsuba segments.
ROULETTE = 3
# Dr.Jit's kernels use instructions of intermediate code that older versions cannot translate for x86.
OLDEST_LLVM = 17


# ------------------------------------------------------------------------------------------------------------------- LLVM

def find_llvm():
    """The newest usable LLVM library of this machine, or None."""
    patterns = ["/usr/lib/*-linux-gnu/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib64/libLLVM*.so*",
                "/usr/lib64/llvm*/lib/libLLVM*.so*", "/opt/homebrew/opt/llvm*/lib/libLLVM*.dylib"]
    found = []
    for pattern in patterns:
        for path in Path("/").glob(pattern[1:]):
            # libLLVM-19.so, libLLVM.so.19.1 and the like.
            version = re.search(r"libLLVM[.-](?:so[.-])?(\d+)", path.name)
            if version:
                found.append((int(version[1]), str(path)))
    found = [f for f in found if f[0] >= OLDEST_LLVM]
    return max(found)[1] if found else None


# ----------------------------------------------------------------------------------------------------------------- scenes

def table_of_metal(path):
    """Wavelengths (nm), eta and k of a table of `plugins/spectra/data`."""
    rows = [line.split(",") for line in path.read_text().splitlines() if line[:1].isdigit()]
    return tuple(np.array([float(row[i]) for row in rows]) for i in range(3))


def irregular(wavelengths, values):
    wavelengths, values = [359.0, *wavelengths, 831.0], [values[0], *values, values[-1]]
    order = [i for i in range(len(wavelengths)) if 359.0 <= wavelengths[i] <= 831.0]
    return {"type": "irregular", "wavelengths": ", ".join(repr(float(wavelengths[i])) for i in order),
            "values": ", ".join(repr(float(values[i])) for i in order)}


def gold_dragon(folder, spectra):
    """The room of `spheres` with the dragon in it, as in scenes/gold_dragon.bhs, without the hole."""
    import mitsuba as mi
    scene, camera, _ = peers.spheres(folder, spectra)
    del scene["glass"], scene["mirror"]
    unpacked = Path(folder) / "dragon.ply"
    unpacked.write_bytes(gzip.decompress((ROOT / "scenes/meshes/dragon_vrip.ply.gz").read_bytes()))
    wavelengths, eta, k = table_of_metal(spectra / "Au_JohnsonChristy1972.csv")
    place = mi.ScalarTransform4f
    scene["dragon"] = {
        "type": "ply", "filename": str(unpacked), "face_normals": True,
        "to_world": place().translate([-0.22, 0, 0]) @ place().translate([0.037469, -0.252894, 0.007025])
        @ place().rotate([0, 1, 0], 30.5904) @ place().scale([4.87914, 4.84278, 5.45441]),
        "bsdf": {"type": "twosided", "bsdf": {"type": "roughconductor", "distribution": "ggx", "alpha": 0.15,
                                              "eta": irregular(wavelengths, eta), "k": irregular(wavelengths, k)}},
    }
    return scene, camera, 6


# Scene and shape of its picture (width over height).
SCENES = {"cornell_box": (peers.cornell_box, 1.0), "gold_dragon": (gold_dragon, 4.0 / 3.0)}


def bhs_scene(name, sampler, guiding=False):
    """The scene's own text without its hole, with the sampler, the roulette and the guiding that are compared."""
    text = (ROOT / f"scenes/{name}.bhs").read_text()
    text = re.sub(r"(?m)^BlackHole .*$", "", text)
    text = re.sub(r"(?m)^LightTransport .*$", lambda line: f'{line[0]} "integer rrdepth" {ROULETTE} "bool guiding" {str(guiding).lower()}', text)
    return re.sub(r'(?m)^Sampler "\w+"', f'Sampler "{sampler}"', text)


# -------------------------------------------------------------------------------------------------------------- rendering

class Bhs:
    """The program as people start it; it says itself how long the rendering took, which is what counts."""

    def __init__(self, options, name, size, sampler, guiding, folder):
        self.name = f"bhs straight, {sampler}{', guiding' if guiding else ''}"
        self.text = bhs_scene(name, sampler, guiding)
        self.out, self.stats = Path(folder) / "bhs.exr", Path(folder) / "bhs.json"
        self.command = [str(options.bhs), "render", "-", "-o", str(self.out), "--stats", str(self.stats), "--quiet", "--integrator",
                        "straight", "--resolution", f"{size[0]}x{size[1]}", "--threads", str(options.threads)]

    def render(self, spp, seed):
        import mitsuba as mi
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([*self.command, "--spp", str(spp), "--seed", str(seed)], cwd=ROOT / "scenes", input=self.text,
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(self.command)}\nfailed with {done.returncode}:\n{done.stdout}{done.stderr}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        stats = json.loads(self.stats.read_text())
        seconds = stats["seconds"]["render"]
        processor = stats.get("processor_seconds", {}).get("render", after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        bitmap = mi.Bitmap(str(self.out)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
        return np.array(bitmap, dtype=np.float64), seconds, processor

    def close(self):
        pass


class Mitsuba:
    """A process of its own for each variant: this script again, which is asked for renders line by line."""

    def __init__(self, options, name, size, variant, folder):
        self.name = f"Mitsuba {variant}"
        self.out = Path(folder) / f"{variant}.npy"
        command = [sys.executable, __file__, "--worker", variant, "--scene", name, "--threads", str(options.threads), "--spectra",
                   str(options.spectra), "--size", f"{size[0]}x{size[1]}", "--out", str(self.out)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def render(self, spp, seed):
        self.process.stdin.write(f"{spp} {seed}\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit(f"{self.name} ended with {self.process.wait()}")
        seconds, processor = map(float, answer.split())
        return np.load(self.out), seconds, processor

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def work(options):
    """What the process of a Mitsuba variant does."""
    # Lines on standard output are answers: what Mitsuba says goes to the error stream.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    import mitsuba as mi
    mi.set_variant(options.worker)
    import drjit as dr
    dr.set_thread_count(options.threads)
    width, height = map(int, options.size.split("x"))
    observer = peers.MitsubaObserver(mi, options.spectra)
    build, _ = SCENES[options.scene[0]]
    with tempfile.TemporaryDirectory() as folder:
        scene = peers.mitsuba_scene(mi, *build(folder, options.spectra), observer.film(width, height), rr_depth=ROULETTE + 1)
        for line in sys.stdin:
            spp, seed = map(int, line.split())
            clocks = time.perf_counter(), time.process_time()
            image = mi.render(scene, spp=spp, seed=seed)
            if "llvm" in options.worker:
                dr.eval(image)
                dr.sync_thread()
            seconds, processor = time.perf_counter() - clocks[0], time.process_time() - clocks[1]
            np.save(options.out, observer.rgb(image))
            answers.write(f"{seconds} {processor}\n")
            answers.flush()


# ------------------------------------------------------------------------------------------------------------ measurement

def variance_per_sample(images, spp, reference):
    """Variance of one sample: mean over the pixels of that of luminance, absolute and relative to the square of its mean."""
    variance = (np.stack(images) @ LUMINANCE).var(axis=0, ddof=1) * spp
    mean = reference @ LUMINANCE
    # Next to nothing beside the picture's mean: a relative variance means nothing there.
    bright = mean > 1e-3 * mean.mean()
    return float(variance.mean()), float((variance[bright] / mean[bright] ** 2).mean())


def measure(options, name):
    _, aspect = SCENES[name]
    size = (round(options.height * aspect), options.height)
    with tempfile.TemporaryDirectory() as folder:
        programs = [Bhs(options, name, size, sampler, guiding, folder)
                    for sampler, guiding in (("sobol", False), ("sobol", True), ("independent", False))]
        programs += [Mitsuba(options, name, size, variant, folder) for variant in options.variant]
        for program in programs:
            # Compiles what there is to compile, for just this size.
            program.render(options.spp, 0)
        images, seconds, processor = ([[] for _ in programs] for _ in range(3))
        for seed in range(1, options.rounds + 1):
            for i, program in enumerate(programs):
                image, wall, cpu = program.render(options.spp, seed)
                images[i].append(image)
                seconds[i].append(wall)
                processor[i].append(cpu)
        for program in programs:
            program.close()
    reference = np.mean([np.mean(found, axis=0) for found in images], axis=0)
    samples = size[0] * size[1] * options.spp
    rows = []
    for i, program in enumerate(programs):
        absolute, relative = variance_per_sample(images[i], options.spp, reference)
        wall, cpu = statistics.median(seconds[i]), statistics.median(processor[i])
        rows.append({"program": program.name, "seconds": wall, "processor_seconds": cpu, "samples_per_second": samples / wall,
                     "samples_per_processor_second": samples / cpu, "mean": float((np.mean(images[i], axis=0) @ LUMINANCE).mean()),
                     "variance": absolute, "relative_variance": relative})
    return {"scene": name, "width": size[0], "height": size[1], "spp": options.spp, "rounds": options.rounds, "threads": options.threads,
            "programs": rows}


def report(result, clock):
    key = {"wall": "samples_per_second", "processor": "samples_per_processor_second"}[clock]
    print(f"\n{result['scene']}: {result['width']} x {result['height']}, {result['spp']} samples a pixel, {result['threads']} threads, "
          f"medians of {result['rounds']} rounds\n")
    print("| program | seconds | processor s | Msamples/s | per processor s | mean Y | variance a sample | relative | "
          f"efficiency ({clock}), over the last but one | over the last |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    rows = result["programs"]
    for row in rows:
        # 1 / (variance x time), by relative variance: that by absolute variance is a matter of the brightest pixels.
        ratios = [row[key] / row["relative_variance"] / (other[key] / other["relative_variance"]) for other in rows[-2:]]
        print(f"| {row['program']} | {row['seconds']:.3f} | {row['processor_seconds']:.3f} | {row['samples_per_second'] / 1e6:.3f} | "
              f"{row['samples_per_processor_second'] / 1e6:.3f} | {row['mean']:.4f} | {row['variance']:.4g} | {row['relative_variance']:.4g} | "
              f"{ratios[0]:.2f} | {ratios[-1]:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", choices=list(SCENES), action="append", help="default: both")
    parser.add_argument("--variant", action="append", help="Mitsuba's variant (default: llvm_ad_spectral and scalar_spectral)")
    parser.add_argument("--bhs", type=Path, default=ROOT / "target/release/bhs", help="the program (default: %(default)s)")
    parser.add_argument("--spectra", type=Path, default=ROOT / "plugins/spectra/data", help="folder of the spectra (default: %(default)s)")
    parser.add_argument("--height", type=int, default=384, help="of the picture [pixels] (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=7, help="timed renders by each program, each with its seed (default: %(default)s)")
    parser.add_argument("--spp", type=int, default=64, help="samples a pixel in each render (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=2, help="threads for each program (default: %(default)s)")
    parser.add_argument("--clock", choices=["wall", "processor"], default="wall", help="what efficiency is reckoned by; `processor` "
                        "where the machine has other things to do (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    for internal in ("--worker", "--size", "--out"):
        parser.add_argument(internal, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        work(options)
        return
    options.variant = options.variant or ["llvm_ad_spectral", "scalar_spectral"]
    if any("llvm" in v for v in options.variant) and "DRJIT_LIBLLVM_PATH" not in os.environ:
        library = find_llvm()
        if library is None:
            sys.exit(f"Mitsuba's llvm variants need the shared library of LLVM {OLDEST_LLVM} or newer, and none was found. Install it (on "
                     "Debian and Ubuntu: apt-get install libllvm19), or set DRJIT_LIBLLVM_PATH to its file, or pass --variant scalar_spectral.")
        os.environ["DRJIT_LIBLLVM_PATH"] = library
    if not options.bhs.exists():
        sys.exit(f"{options.bhs} is not there: build it with `./bhs plugins`")
    import mitsuba as mi
    # For reading pictures.
    mi.set_variant("scalar_rgb")
    results = []
    for name in options.scene or list(SCENES):
        result = measure(options, name)
        report(result, options.clock)
        results.append(result)
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
