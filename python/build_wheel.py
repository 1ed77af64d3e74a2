#!/usr/bin/env python3
"""Builds the wheel for other people's machines: python/dist/bhs-*.whl, with Embree in it. Needs what ./bhs needs, and pip.

It runs on processors with AVX2 and FMA (x86-64-v3: Intel Haswell, AMD Zen and newer); --cpu x86-64-v2 makes one for older ones, which is slower.
"""

import argparse
import os
import platform
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cpu", help="the least processor that it runs on, as rustc calls it (default on x86-64: x86-64-v3)")
    parser.add_argument("--out", default=FOLDER / "dist", help="folder of the wheel (default: python/dist)")
    arguments = parser.parse_args()
    cpu = arguments.cpu or ("x86-64-v3" if platform.machine() == "x86_64" else None)
    environment = dict(os.environ)
    if cpu:
        # These flags win over those of .cargo/config.toml, which are for this very processor. What they make is kept apart.
        environment["RUSTFLAGS"] = "-Ctarget-cpu=" + cpu
        environment.setdefault("CARGO_TARGET_DIR", str(FOLDER.parent / "target" / cpu))
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--wheel-dir", str(arguments.out), str(FOLDER)]
    return subprocess.run(command, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
