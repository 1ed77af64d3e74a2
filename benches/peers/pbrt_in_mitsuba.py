#!/usr/bin/env python3
"""Public pbrt-v4 scenes by bhs and by Mitsuba 3, of the same file, by block means: benches/peers/pbrt_in_mitsuba.py --folder FOLDER [SCENE...]

FOLDER holds copies of https://github.com/gonsolo/bitterli (as `bitterli`) and https://github.com/w3ntao/pbrt-minus-scenes (as `w3ntao`). Each
scene is read into directives, given the same small options (size, box filter, depth, `path`), and written again; bhs reads that file, and pbrt_mitsuba.py
states it for Mitsuba. What Mitsuba cannot state is other than in the scene for both programs, and the table says what. See README.md beside this file.

Written into FOLDER: stand-ins for files that the copies lack, as public_pbrt.py makes them, and beside each scene the file that is compared, while it is."""

import argparse
import json
import math
import os
import re
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import compare_mitsuba as peer
from pbrt_meaning import Spectra
from pbrt_mitsuba import Reader
from pbrt_text import Directive, NotStated, directives, picture_size, prepared, written
from public_pbrt import stand_in


def with_stand_ins(found, folder):
    """Puts stand-ins in the places of files that the copy lacks; how many."""
    names = set()
    for d in found:
        for name, (kind, values) in d.params.items():
            is_file = name in ("filename", "mapname") and d.keyword in ("Shape", "Texture", "LightSource", "AreaLightSource")
            if is_file or (kind == "spectrum" and isinstance(values[0], str) and re.search("[./]", values[0])):
                names.add(values[0])
    missing = [n for n in names if not os.path.exists(os.path.join(folder, n))]
    for name in missing:
        stand_in(os.path.join(folder, name))
    record = Path(folder) / "stand-ins.txt"
    stood = set(record.read_text().splitlines()) if record.exists() else set()
    stood |= set(missing)
    if missing:
        record.write_text("\n".join(sorted(stood)) + "\n")
    return sum(n in names or n.endswith(".pbrt") for n in stood)


def one(mi, options, observer, spectra, scene):
    """Renders a scene with both and compares."""
    folder = scene.parent
    while True:
        try:
            found = directives(scene)
            break
        except FileNotFoundError as lacks:
            stand_in(lacks.filename)
            (folder / "stand-ins.txt").open("a").write(os.path.relpath(lacks.filename, folder) + "\n")
    stood = with_stand_ins(found, folder)
    size = picture_size(found, options.width, peer.BLOCK)
    found, changed = prepared(found, size, options.depth)
    if stood:
        changed["file that the copy lacks"] = stood
    # Plain paths, as Mitsuba's: no photons, whose caustics are blurred.
    plain = {} if options.photons else {"caustics": ("bool", [False])}
    found = [Directive("LightTransport", ["path"], {**d.params, **plain}) if d.keyword == "Integrator" else d for d in found]
    text = written(found)
    with tempfile.TemporaryDirectory() as scratch:
        # The names of files start at the folder of the scene.
        file = folder / f".compared-{os.getpid()}.pbrt"
        file.write_text(text)
        try:
            reader = Reader(mi, spectra, str(folder), scratch).read(directives(file))
            stated, is_mirrored = reader.finished(observer.film(*size))
            loaded = mi.load_dict(stated)
            flip = (lambda im: im[:, ::-1]) if is_mirrored else (lambda im: im)
            start = time.time()
            theirs = [flip(peer.render_mitsuba(mi, loaded, observer, options.spp, 1 + i)) * reader.iso / 100 for i in range(options.seeds)]
            middle = time.time()
            ours = [peer.render_bhs(mi, options.bhs, file, size, options.spp_bhs or options.spp, 1 + i, 1, scratch) for i in range(options.seeds)]
            seconds = {"mitsuba": middle - start, "bhs": time.time() - middle}
        finally:
            file.unlink()
    name = str(scene.relative_to(options.folder))
    result, relative, z = peer.compare(name, [peer.blocks(im) for im in ours], [peer.blocks(im) for im in theirs], options.tolerance, options.chance)
    result.update(width=size[0], height=size[1], seeds=options.seeds, spp_bhs=options.spp_bhs or options.spp, spp_mitsuba=options.spp,
                  tolerance=options.tolerance, changed=changed, seconds=seconds)
    peer.report(result)
    print(f"  other than in the file: {told(changed)}; seconds: bhs {seconds['bhs']:.1f}, Mitsuba {seconds['mitsuba']:.1f}", flush=True)
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
        stem = name.replace("/", "_").removesuffix(".pbrt")
        for kind, images in (("bhs", ours), ("mitsuba", theirs)):
            mean = np.mean(images, axis=0).astype(np.float32)
            mi.util.write_bitmap(str(options.keep / f"{stem}_{kind}.png"), mi.Bitmap(np.ascontiguousarray(mean / max(4 * np.median(mean), 1e-6))))
        np.savez(options.keep / f"{stem}.npz", bhs=np.mean(ours, axis=0), mitsuba=np.mean(theirs, axis=0), relative=relative, z=z)
    return result


def told(changed):
    return ", ".join(f"{n} {what}" for what, n in changed.items()) or "nothing"


def line(r):
    """A row of the table of README.md."""
    green = r["channels"][1]
    ratio = f"{green['mean_ratio']:.4f}({math.ceil(green['mean_ratio_error'] * 1e4)})"
    blocks, failed, resolved = (sum(c[k] for c in r["channels"]) for k in ("blocks", "failed", "resolved"))
    blocks -= sum(c["dark"] for c in r["channels"])
    noise = max(c["median_noise"] for c in r["channels"])
    return f"| `{r['scene']}` | {told(r['changed'])} | {ratio} | {100 * noise:.2f} % | {resolved} | {blocks - failed} of {blocks} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="words; scenes whose path has one of them are compared (default: all)")
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--variant", default="scalar_spectral")
    parser.add_argument("--bhs", type=Path, default=peer.ROOT / "bhs")
    parser.add_argument("--width", type=int, default=96, help="pixels of the longer side (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--spp-bhs", type=int)
    parser.add_argument("--depth", type=int, default=5, help="bounces, of both (default: %(default)s)")
    parser.add_argument("--photons", action="store_true", help="let bhs look for caustics from the lights too")
    parser.add_argument("--tolerance", type=float, default=0.01)
    parser.add_argument("--chance", type=float, default=0.01)
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    parser.add_argument("--keep", type=Path, help="write the pictures here")
    options = parser.parse_args()

    import mitsuba as mi
    mi.set_variant(options.variant)
    import drjit
    drjit.set_thread_count(2)  # with one alone it never ends to read an EXR file
    observer = peer.SameObserver(mi, None)
    spectra = Spectra(mi, peer.ROOT, observer)
    results = json.loads(options.json.read_text()) if options.json and options.json.exists() else []
    scenes = [p for p in sorted(options.folder.rglob("*.pbrt")) if not p.name.startswith(".") and b"WorldBegin" in p.read_bytes()]
    for scene in scenes:
        name = str(scene.relative_to(options.folder))
        if options.scenes and not any(w in name for w in options.scenes):
            continue
        try:
            result = one(mi, options, observer, spectra, scene)
        except NotStated as lacks:
            print(f"\n{name}: not compared: {lacks}", flush=True)
            continue
        except (RuntimeError, SystemExit, OSError, KeyError) as fault:
            print(f"\n{name}: a fault: {str(fault)[:1000]}", flush=True)
            continue
        results = [r for r in results if r["scene"] != name] + [result]
        if options.json:
            options.json.write_text(json.dumps(results, indent=1) + "\n")
    print("\n| scene | other than in the file | mean ratio, G | noise of a block | resolved | passed |\n|---|---|--:|--:|--:|--:|")
    print("\n".join(line(r) for r in results))
    print(f"{sum(r['pass'] for r in results)} of {len(results)} pass")
    sys.exit(0 if all(r["pass"] for r in results) else 1)


if __name__ == "__main__":
    main()
