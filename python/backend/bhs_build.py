"""Builds the wheel: maturin, after the set-up that ./bhs does too, with Embree in the wheel.

pip calls these functions (PEP 517). What is built is for the processor that it is built on, as with ./bhs; for other people's machines:
python/build_wheel.py.
"""

import os
import subprocess
import sys
from pathlib import Path

import maturin
from maturin import (  # noqa: F401  (asked for by pip)
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
)

ROOT = Path(__file__).resolve().parent.parent.parent
# Libraries that a plain system lacks, Embree and its TBB, come into the wheel, where the module looks for them first; the platform's name is that of the oldest
# systems that have what is left.
ARGUMENTS = ["--auditwheel", "repair", "--compatibility", "pypi"]


def prepare():
    """Embree, libclang and the crates are there, and what the program has built already is used."""
    prepare_script = 'root=$1; . "$root/setup/prepare.sh"; prepare_tools; cd -- "$root/python"; prepare_crates'
    if subprocess.run(["sh", "-eu", "-c", prepare_script, "sh", str(ROOT)]).returncode != 0:
        sys.exit("bhs: the set-up has failed: see above")
    os.environ.setdefault("CARGO_TARGET_DIR", str(ROOT / "target"))


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """The wheel."""
    prepare()
    return maturin.build_wheel(wheel_directory, {"build-args": ARGUMENTS}, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """A link to this folder, for who works on it; the module finds Embree where the set-up has put it."""
    prepare()
    return maturin.build_editable(wheel_directory, None, metadata_directory)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Name and version."""
    prepare()
    return maturin.prepare_metadata_for_build_wheel(metadata_directory)


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel
