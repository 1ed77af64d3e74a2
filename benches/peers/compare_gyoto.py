#!/usr/bin/env python3
"""A thin disc around a spinning hole by bhs and by GYOTO (Vincent et al. 2011), block by block, and the time of both. See README.md beside this file.

Both programs follow one ray through the middle of each pixel. GYOTO gives bolometric radiance; bhs a spectral film with a bucket so narrow that it holds one
wavelength. As the disc is a black body in its own frame, each of its pixels is one too, whose temperature gives the bolometric radiance.
"""

import argparse
import json
import math
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TEMPERATURE = 1e4
WAVELENGTH_NM = 500.0
# Planck's and Boltzmann's constants, the speed of light, Stefan and Boltzmann's constant (SI).
H, C, K, SIGMA = 6.62607015e-34, 299792458.0, 1.380649e-23, 5.670374419e-8

GYOTO = """<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<Scenery>
  <Metric kind="KerrBL"><Spin>{spin}</Spin></Metric>
  <Screen>
    <Distance unit="geometrical">{distance}</Distance>
    <Inclination unit="degree">{inclination}</Inclination>
    <PALN>0</PALN>
    <Argument>0</Argument>
    <Time unit="geometrical_time">{distance}</Time>
    <FieldOfView unit="degree">{fov}</FieldOfView>
    <Resolution>{size}</Resolution>
  </Screen>
  <Astrobj kind="PageThorneDisk"><OuterRadius>{radius}</OuterRadius></Astrobj>
  <MinimumTime>{earliest}</MinimumTime>
  <Quantities>User4</Quantities>
  <NThreads>1</NThreads>
</Scenery>
"""

BHS = """
Film "spectral" "integer nbuckets" 1 "float lambdamin" {low} "float lambdamax" {high} "integer xresolution" {size} "integer yresolution" {size}
PixelFilter "box" "float xradius" 0.001 "float yradius" 0.001
LightTransport "path" "integer maxdepth" 0
LookAt {eye}  {target}  0 1 0
Camera "perspective" "float fov" {fov}
WorldBegin
BlackHole "kerr" "float rs" 2 "float spin" {spin}
AreaLightSource "thindisc" "float temperature" {temperature}
Rotate -90 1 0 0
Shape "disk" "float radius" {chart_radius} "string motion" "keplerian"
"""


def scenes(o):
    """The two scenes: the same distance, inclination and disc in Boyer and Lindquist's coordinates."""
    distance, a = o.distance, o.spin
    gyoto = GYOTO.format(spin=a, distance=distance, inclination=o.inclination, fov=o.fov, size=o.size, radius=o.radius, earliest=-1.5 * o.radius - 50.0)
    theta = math.radians(o.inclination)
    across, sigma = math.hypot(distance, a), math.sqrt(distance**2 + (a * math.cos(theta)) ** 2)
    eye = np.array([0.0, distance * math.cos(theta), -across * math.sin(theta)])
    # Along Boyer and Lindquist's radius, which is not quite towards the centre.
    inwards = -np.array([0.0, across * math.cos(theta), -distance * math.sin(theta)]) / sigma
    numbers = lambda v: " ".join(map(repr, map(float, v)))
    bhs = BHS.format(low=WAVELENGTH_NM - 0.005, high=WAVELENGTH_NM + 0.005, size=o.size, eye=numbers(eye), target=numbers(eye + inwards), fov=o.fov,
                     spin=a, temperature=TEMPERATURE, chart_radius=math.hypot(o.radius, a))
    return gyoto, bhs


def fits(path):
    """The pictures of a FITS file, one row after the other."""
    data, at, found = path.read_bytes(), 0, []
    while at < len(data):
        header, ended = {}, False
        while not ended:
            for card in (data[at + i:at + i + 80].decode("ascii", "replace") for i in range(0, 2880, 80)):
                if card.startswith("END     "):
                    ended = True
                    break
                if card[8:10] == "= ":
                    header[card[:8].strip()] = card[10:].split("/")[0].strip()
            at += 2880
        shape = [int(header[f"NAXIS{i + 1}"]) for i in range(int(header["NAXIS"]))][::-1]
        if shape:
            count, bits = math.prod(shape), int(header["BITPIX"])
            values = np.frombuffer(data[at:at + count * abs(bits) // 8], {-64: ">f8", -32: ">f4"}[bits])
            found.append(values.reshape(shape).astype(float))
            at += -(-count * abs(bits) // 8 // 2880) * 2880
    return found


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(command, folder):
    before, start = processor_seconds(), time.perf_counter()
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nfailed with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr}")
    return processor_seconds() - before, time.perf_counter() - start


def by_gyoto(o, text, folder):
    (folder / "disc.xml").write_text(text)
    times = run([o.gyoto, "disc.xml", "!disc.fits"], folder)
    picture = fits(folder / "disc.fits")[0]
    # Rows go up, columns to the right as in bhs.
    return picture.reshape(picture.shape[-2:])[::-1], times


def by_bhs(o, text, folder, samples=1):
    import OpenEXR
    (folder / "disc.bhs").write_text(text)
    times = run([str(o.bhs), "render", "disc.bhs", "-o", "disc.exr", "--spp", str(samples), "--threads", "1", "--quiet"], folder)
    with OpenEXR.File(str(folder / "disc.exr"), separate_channels=True) as file:
        channels = file.channels()
        radiance = next(np.array(c.pixels, dtype=float) for name, c in channels.items() if name.startswith("S0."))
    # What the temperature of a black body of this radiance at this wavelength is, and what it radiates in all.
    length = WAVELENGTH_NM * 1e-9
    with np.errstate(divide="ignore"):
        temperature = np.where(radiance > 0.0, H * C / (length * K) / np.log1p(2.0 * H * C**2 / (length**5 * radiance * 1e9)), 0.0)
    return SIGMA * temperature**4 / math.pi, times


def blocks(image, block):
    h, w = image.shape
    return image.reshape(h // block, block, w // block, block).mean(axis=(1, 3))


def blocks_of_edges(image, block):
    """For each block, what the brightest pixel at an edge of the lit part is worth in the block's mean: 0 where there is no edge."""
    around = np.pad(image, 1)
    near = np.stack([around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:]])
    edge = ((near > 0) != (image > 0)).any(axis=0)
    h, w = image.shape
    value = np.where(edge, np.maximum(image, near.max(axis=0)), 0.0)
    return value.reshape(h // block, block, w // block, block).max(axis=(1, 3)) / block**2


def greatest_flux(a):
    """The greatest value of Page and Thorne's flux (their eq. 15n; M = 1, Mdot / 4 pi taken out)."""
    z1 = 1 + (1 - a * a) ** (1 / 3) * ((1 + a) ** (1 / 3) + (1 - a) ** (1 / 3))
    z2 = math.sqrt(3 * a * a + z1 * z1)
    isco = 3 + z2 - math.copysign(math.sqrt((3 - z1) * (3 + z1 + 2 * z2)), a)
    x, x0 = np.sqrt(np.linspace(isco, 4 * isco, 1_000_001)[1:]), math.sqrt(isco)
    roots = [2 * math.cos((math.acos(a) - math.pi) / 3), 2 * math.cos((math.acos(a) + math.pi) / 3), -2 * math.cos(math.acos(a) / 3)]
    bracket = x - x0 - 1.5 * a * np.log(x / x0)
    for i, r in enumerate(roots):
        s, t = roots[i - 1], roots[i - 2]
        if r != 0.0:
            bracket -= 3 * (r - a) ** 2 / (r * (r - s) * (r - t)) * np.log((x - r) / (x0 - r))
    return float((1.5 / (x**4 * (x**3 - 3 * x + 2 * a)) * bracket).max())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spin", type=float, default=0.9, help="a/M (default: %(default)s)")
    parser.add_argument("--inclination", type=float, default=80.0, help="of the eye against the axis [degrees] (default: %(default)s)")
    parser.add_argument("--distance", type=float, default=1000.0, help="of the eye, in units of M (default: %(default)s)")
    parser.add_argument("--radius", type=float, default=20.0, help="of the disc, in units of M (default: %(default)s)")
    parser.add_argument("--fov", type=float, default=2.5, help="of the whole picture [degrees] (default: %(default)s)")
    parser.add_argument("--size", type=int, default=128, help="of the picture [pixels] (default: %(default)s)")
    parser.add_argument("--block", type=int, default=8, help="of what is compared [pixels] (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=1024, help="rays a pixel of the picture by which bhs is timed (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="timed runs of each (default: %(default)s)")
    parser.add_argument("--bhs", type=Path, default=ROOT / "target/release/bhs", help="the program (default: %(default)s)")
    parser.add_argument("--gyoto", default="gyoto", help="the program (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--keep", type=Path, help="write both pictures here (numpy)")
    o = parser.parse_args()
    if shutil.which(o.gyoto) is None:
        sys.exit("GYOTO is not there: install it (on Debian and Ubuntu: apt-get install gyoto-bin), or say where it is with --gyoto")
    if not o.bhs.exists():
        sys.exit(f"{o.bhs} is not there: build it with `./bhs plugins`")
    gyoto, bhs = scenes(o)
    clocks = {"gyoto": [], "bhs": []}
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        ours, start_up = by_bhs(o, bhs, folder)
        for _ in range(o.rounds):
            theirs, times = by_gyoto(o, gyoto, folder)
            clocks["gyoto"].append(times[0])
            clocks["bhs"].append(by_bhs(o, bhs, folder, o.samples)[1][0])
    if o.keep:
        np.savez(o.keep, bhs=ours, gyoto=theirs)
    # GYOTO's unit of radiance: one factor for the whole picture, which is known (GYOTO's flux is f / 4 pi, its radiance that over pi).
    factor = ours.sum() / theirs.sum()
    expected = SIGMA * TEMPERATURE**4 / math.pi / greatest_flux(o.spin) * (2.0 * math.pi) ** 2
    a, b = blocks(ours, o.block), blocks(theirs * factor, o.block)
    # A block is resolved where both halves of its pixels, as on a chess board, say the same within 1 %, and where no pixel at an edge of the disc, lit or not,
    # has a share of 1 % in it.
    odd = np.indices(ours.shape).sum(axis=0) % 2
    halves = [blocks(theirs * factor * (odd == k), o.block) * 2 for k in (0, 1)]
    lit = b > 1e-3 * b.mean()
    edges = blocks_of_edges(theirs * factor, o.block)
    resolved = lit & (np.abs(halves[0] - halves[1]) < 0.01 * b) & (edges < 0.01 * b)
    deviation = np.abs(a / np.where(lit, b, 1.0) - 1.0)
    pixels = (theirs > 0) & (ours > 0)
    pixel = np.abs(ours[pixels] / (theirs[pixels] * factor) - 1.0)
    rays = o.size**2
    seconds = {"gyoto": statistics.median(clocks["gyoto"]) / rays,
               "bhs": (statistics.median(clocks["bhs"]) - start_up[0]) / (rays * (o.samples - 1))}
    result = {"spin": o.spin, "inclination": o.inclination, "size": o.size, "block": o.block, "blocks": int(lit.sum()), "resolved": int(resolved.sum()),
              "largest_resolved": float(deviation[resolved].max()), "largest": float(deviation[lit].max()),
              "median_pixel": float(np.median(pixel)), "pixel_90": float(np.quantile(pixel, 0.9)),
              "lit_by_one_only": int(((theirs > 0) != (ours > 0)).sum()), "lit_pixels": int(pixels.sum()),
              "factor_over_expected": float(factor / expected), "processor_seconds_a_ray": seconds, "ratio": seconds["gyoto"] / seconds["bhs"],
              "pass": bool(resolved.any() and deviation[resolved].max() < 0.01)}
    print(json.dumps(result, indent=2))
    if o.json:
        o.json.write_text(json.dumps(result, indent=2) + "\n")
    sys.exit(0 if result["pass"] else 1)


if __name__ == "__main__":
    main()
