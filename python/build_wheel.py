#!/usr/bin/env python3
"""Builds the wheel for other people's machines: python/dist/bhs-*.whl, with Embree in it. Needs what ./bhs needs, and pip.

On x86-64 it has a module for each level of processors, x86-64-v2, -v3 (AVX2) and -v4 (AVX-512), and takes the best that the processor runs.
"""

import argparse
import base64
import csv
import hashlib
import io
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(FOLDER.parent / "setup"))
from common import DEPS, level_environment, levels  # noqa: E402

MODULE = "bhs/_bhs.abi3.so"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=FOLDER / "dist", help="folder of the wheel (default: python/dist)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as tmp:
        wheels = [build(level, Path(tmp) / str(level)) for level in levels()]
        arguments.out.mkdir(parents=True, exist_ok=True)
        out = arguments.out / wheels[0].name
        join(wheels, out)
    print(out)


def build(level, folder):
    """Builds the wheel of a level in a folder of its own; its file."""
    environment = level_environment(level)
    # Where Embree is looked for while it is copied into the wheel.
    places = [str(path) for path in DEPS.glob("embree-*")] + [os.environ.get("LD_LIBRARY_PATH", "")]
    environment["LD_LIBRARY_PATH"] = ":".join(filter(None, places))
    command = [sys.executable, "-m", "pip", "wheel", "--disable-pip-version-check", "--no-deps", "--wheel-dir", str(folder), str(FOLDER)]
    if subprocess.run(command, env=environment).returncode != 0:
        sys.exit("bhs: the wheel for %s has not been built: see above" % (level or "this processor"))
    return next(folder.glob("*.whl"))


def join(wheels, out):
    """Writes the wheel of the lowest level with the modules of the others beside its own."""
    with zipfile.ZipFile(wheels[0]) as first:
        members = [(info, first.read(info)) for info in first.infolist()]
    for level, wheel in list(zip(levels(), wheels))[1:]:
        with zipfile.ZipFile(wheel) as other:
            info = other.getinfo(MODULE)
            same = {i.filename: i.CRC for i in other.infolist() if i.filename.startswith("bhs.libs/")}
            ours = {i.filename: i.CRC for i, _ in members if i.filename.startswith("bhs.libs/")}
            if same != ours:
                sys.exit("bhs: the wheels of two levels bring other libraries: %s, %s" % (sorted(ours), sorted(same)))
            # In the same folder, from which the libraries are looked for.
            info.filename = "bhs/_bhs-%s.so" % level
            members.append((info, other.read(MODULE)))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as wheel:
        record = io.StringIO()
        rows = csv.writer(record, lineterminator="\n")
        for info, data in members:
            if info.filename.endswith(".dist-info/RECORD"):
                listed = info
                continue
            wheel.writestr(info, data, zipfile.ZIP_DEFLATED)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            rows.writerow([info.filename, "sha256=" + digest, len(data)])
        rows.writerow([listed.filename, "", ""])
        wheel.writestr(listed, record.getvalue(), zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    main()
