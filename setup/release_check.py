"""Tries a release as a stranger would: unpacked in a new folder, with no compiler and no file of this repository in reach.

    setup/release.py --try FOLDER

Pictures of every level that this processor runs are compared byte for byte, whole and merged from parts of several levels; the wheel likewise, in an
empty virtual environment.
"""

import subprocess
import sys
import tarfile
import tempfile
import venv
from pathlib import Path

from common import Failure, levels, say

# A scene of each kind of arithmetic: single orbits and lanes, orbits around a hole that spins, several holes, straight rays with caustics.
SCENES = {
    "cornell_hole": ["--resolution", "96x72", "--spp", "8"],
    "kerr_disc": ["--resolution", "96x54", "--spp", "4"],
    "kerr_room": ["--resolution", "64x48", "--spp", "4"],
    "two_holes": ["--resolution", "64x36", "--spp", "4"],
    "wormhole": ["--resolution", "64x36", "--spp", "4"],
    "spheres": ["--resolution", "96x72", "--spp", "8"],
}
# Most, as one line of docs/python.md.
PYTHON = 'import bhs; print(bhs.load("{scene}").render(spp=2, resolution=(32, 24)).image.tobytes().hex())'


def check(folder):
    """Tries all of it."""
    archives, wheels = sorted(folder.glob("bhs-*.tar.gz")), sorted(folder.glob("bhs-*.whl"))
    if not archives or not wheels:
        raise Failure("%s has no archive or no wheel of bhs" % folder)
    with tempfile.TemporaryDirectory() as tmp:
        tmp = Path(tmp)
        (tmp / "empty").mkdir()
        with tarfile.open(archives[-1]) as archive:
            archive.extractall(tmp / "a b", filter="data")  # a space in the path
        top = next((tmp / "a b").iterdir())
        say(said([top / "bin" / "bhs", "--version", "--verbose"], tmp).replace("\n", "; ").rstrip("; "))
        runs = [level for level in levels() if is_run(top, level, tmp)]
        say("this processor runs %s" % ", ".join(map(str, runs)))
        for scene, flags in SCENES.items():
            compare(top, scene, flags, runs, tmp)
        if len(runs) > 1:
            merge(top, runs, tmp)
        try_wheel(wheels[-1], top, runs, tmp)


def said(command, tmp, level=None, fails=False, cwd=None):
    """What a program prints, started with nothing in its path and nothing of this environment."""
    environment = {"PATH": str(tmp / "empty"), "HOME": str(tmp), "LC_ALL": "C.UTF-8"}
    if level:
        environment["BHS_VECTORS"] = level
    done = subprocess.run([str(word) for word in command], env=environment, cwd=cwd or tmp, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    text = (done.stdout + (done.stderr if fails else b"")).decode()
    if (done.returncode != 0) != fails:
        raise Failure("`%s` ends with code %d: %s" % (" ".join(map(str, command)), done.returncode, done.stderr.decode()))
    return text


def is_run(top, level, tmp):
    """Whether the processor runs a level. Where it does not, the program says what is lacking."""
    command = [top / "bin" / "bhs", "--version", "--verbose"]
    try:
        text = said(command, tmp, level)
    except Failure as failure:
        if "this processor lacks" not in str(failure):
            raise
        return False
    if level and "(%s): BHS_VECTORS asks for it" % level not in text:
        raise Failure("the program for %s says: %s" % (level, text))
    return True


def compare(top, scene, flags, runs, tmp):
    """Renders a scene by every level: the same pixels and the same PNG."""
    made = {}
    for level in runs:
        out = tmp / ("%s.%s.exr" % (scene, level))
        said([top / "bin" / "bhs", "render", top / "scenes" / (scene + ".bhs"), "-o", out, "--quiet", *flags], tmp, level)
        made[level] = pixels(out), out.with_suffix(".png").read_bytes()
    same("the pictures of %s" % scene, made)


def merge(top, runs, tmp):
    """Renders a picture in parts, each by another level: merged, it is the whole."""
    bhs, scene = top / "bin" / "bhs", top / "scenes" / "cornell_hole.bhs"
    flags = ["--quiet", "--resolution", "64x48", "--spp", "6"]
    parts = [tmp / ("part.%d.bhspart" % k) for k in range(1, 7)]
    for k, part in enumerate(parts):
        said([bhs, "render", scene, "--part", "%d/6" % (k + 1), "-o", part, *flags], tmp, runs[k % len(runs)])
    said([bhs, "merge", "-o", tmp / "merged.exr", "--quiet", *parts], tmp)
    said([bhs, "render", scene, "-o", tmp / "whole.exr", *flags], tmp)
    same("parts of several levels, merged, and the whole", {name: pixels(tmp / (name + ".exr")) for name in ("merged", "whole")})


def same(what, made):
    """Says that all are the same, or which differ from the first."""
    names = list(made)
    others = [name for name in names[1:] if made[name] != made[names[0]]]
    if others:
        raise Failure("%s differ: those of %s from that of %s" % (what, ", ".join(map(str, others)), names[0]))
    say("%s: the same bytes (%s)" % (what, ", ".join(map(str, names))))


def pixels(path):
    """The bytes of an EXR file behind its header, which has the seconds that the render took."""
    data = path.read_bytes()
    at = 8
    while data[at]:
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(data[at : at + 4], "little")
    return data[at + 1 :]


def try_wheel(wheel, top, runs, tmp):
    """Installs the wheel where nothing else is, and runs the module and the program that come with it."""
    environment = tmp / "venv"
    venv.create(environment, with_pip=True)
    python = environment / "bin" / "python"
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel)]
    if subprocess.run(pip, cwd=tmp).returncode != 0:
        raise Failure("pip cannot install %s" % wheel.name)
    one_liner = PYTHON.replace("{scene}", str(top / "scenes" / "cornell_hole.bhs"))
    same("pictures of the wheel", {level: said([python, "-c", one_liner], tmp, level) for level in runs})
    if len(runs) > 1:
        text = said([python, "-c", "import bhs"], tmp, "x86-64-v9", fails=True)
        if "ImportError: BHS_VECTORS is `x86-64-v9`" not in text:
            raise Failure("a level that there is not is met with: " + text)
    program = said([environment / "bin" / "bhs", "--version", "--verbose"], tmp)
    if said([top / "bin" / "bhs", "--version", "--verbose"], tmp) != program:
        raise Failure("the program of the wheel is another: " + program)
    say("wheel: " + wheel.name)


if __name__ == "__main__":
    sys.exit("bhs set-up: this is started by setup/release.py")
