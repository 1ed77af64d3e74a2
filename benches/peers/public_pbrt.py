#!/usr/bin/env python3
"""How many public pbrt scenes load and render: benches/peers/public_pbrt.py BHS FOLDER [--stand-ins] [--only WORD]

FOLDER holds copies of https://github.com/gonsolo/bitterli and https://github.com/w3ntao/pbrt-minus-scenes; nothing of them is part of this
repository. Every file that has a `WorldBegin` is rendered at 128 pixels with 4 samples, as it is. Files that a copy lacks (meshes and pictures
beyond a size) are not counted as faults: with --stand-ins a small triangle, a grey picture or an empty text is put in their places."""

import json
import os
import re
import struct
import subprocess
import sys
import tempfile

PLY = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n" \
      b"property list uchar int vertex_indices\nend_header\n0 0 0\n1e-3 0 0\n0 1e-3 0\n3 0 1 2\n"
PFM = b"PF\n2 2\n-1.0\n" + struct.pack("<12f", *[0.5] * 12)


def stand_in(path):
    """Puts something harmless in the place of a file that is not there."""
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    name = path.lower()
    if name.endswith(".ply"):
        data = PLY
    elif name.endswith(".gz"):
        import gzip
        data = gzip.compress(PLY)
    elif name.endswith(".pbrt"):
        data = b"# stands in for a file that is not there\n"
    elif name.endswith(".spd"):
        data = b"300 1\n900 1\n"
    else:
        data = PFM
    with open(path, "wb") as file:
        file.write(data)


def findings(bhs, scene):
    run = subprocess.run([bhs, "check", "--json", scene], capture_output=True, text=True)
    found = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    return [d for d in found if d["severity"] == "error"]


def main():
    bhs, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
    only = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else ""
    scenes = []
    for root, _, files in os.walk(folder):
        for name in files:
            path = os.path.join(root, name)
            if name.endswith(".pbrt") and only in path and b"WorldBegin" in open(path, "rb").read():
                scenes.append(path)
    good, bad = [], []
    for scene in sorted(scenes):
        errors = findings(bhs, scene)
        for _ in range(400):
            missing = {m.group(1) for d in errors if (m := re.search(r"cannot read `(.*?)`: .*(No such file|there is no)", d["message"]))}
            if "--stand-ins" not in sys.argv or not missing:
                break
            for name in missing:
                stand_in(os.path.join(os.path.dirname(scene), name))
            errors = findings(bhs, scene)
        errors = [d for d in errors if not re.search("No such file|there is no (such file|folder)", d["message"])]
        if errors:
            kinds = sorted({d["message"] for d in errors})
            bad.append(scene)
            print(f"FAULT {scene}: {len(errors)} errors: {'; '.join(kinds[:4])}", flush=True)
            continue
        with tempfile.TemporaryDirectory() as out:
            picture = os.path.join(out, "picture.exr")
            size = re.search(rb'integer xresolution"?\s*\[?\s*(\d+).*?integer yresolution"?\s*\[?\s*(\d+)', open(scene, "rb").read(), re.S)
            height = round(128 * int(size.group(2)) / int(size.group(1))) if size else 72
            command = [bhs, "render", scene, "--resolution", f"128x{max(1, height)}", "--spp", "4", "--quiet", "-o", picture]
            run = subprocess.run(command, capture_output=True, text=True)
            if run.returncode or not os.path.exists(picture):
                bad.append(scene)
                print(f"FAULT {scene}: {run.stderr.strip()[:300]}", flush=True)
                continue
        good.append(scene)
        print(f"ok    {scene}", flush=True)
    print(f"{len(good)} of {len(good) + len(bad)} load and render")


if __name__ == "__main__":
    main()
