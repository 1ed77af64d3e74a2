#!/usr/bin/env python3
"""Makes what people download, in target/release-files: an archive and a wheel for this kind of machine, their checksums, what is new.

    setup/release.py                    builds all of it, and tries it
    setup/release.py --try FOLDER       tries what lies there: elsewhere, and with no compiler in the path

The archive holds a program for each level of processors (src/vectors.rs), Embree beside them, scenes, documentation, completions, manual pages and
licences. It may be unpacked anywhere. Needs what ./bhs needs.
"""

import argparse
import gzip
import hashlib
import io
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from common import DEPS, ROOT, Failure, level_environment, levels, needed_glibc, output, run_main, say, write_whole  # noqa: E402

# Folders and files of the repository that the archive has too. Meshes are fetched by setup/meshes.py: they are under other licences.
INCLUDED = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "docs", "farm", "grammar", "scenes"]
INCLUDED += ["setup/common.py", "setup/meshes.py", "setup/meshes.txt", "setup/node.txt"]
SHELLS = {"bash": "bhs", "zsh": "_bhs", "fish": "bhs.fish"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "target" / "release-files", help="folder of what is made (target/release-files)")
    parser.add_argument("--try", type=Path, dest="tried", metavar="FOLDER", help="makes nothing, and tries what is in this folder")
    arguments = parser.parse_args()
    out = (arguments.tried or arguments.out).resolve()
    if not arguments.tried:
        make(out)
    import release_check

    release_check.check(out)


def make(out):
    """Archive, wheel, checksums, notes."""
    run(["sh", "-eu", "-c", 'root=$1; . "$root/setup/prepare.sh"; prepare_tools; cd -- "$root"; prepare_crates', "sh", str(ROOT)])
    programs = {level: build(level) for level in levels()}
    libraries = embree_libraries()
    glibc = needed_glibc([*programs.values(), *libraries])
    out.mkdir(parents=True, exist_ok=True)
    # Of the release before, now that the programs of this one are there; whatever else lies in the folder is not ours.
    for former in [*out.glob("bhs-*.tar.gz"), *out.glob("bhs-*.whl")]:
        former.unlink()
    archive(out, programs, libraries, glibc)
    run([sys.executable, str(ROOT / "python" / "build_wheel.py"), "--out", str(out)])
    write_whole(out / "NOTES.md", notes(glibc).encode())
    files = sorted([*out.glob("bhs-*.tar.gz"), *out.glob("bhs-*.whl"), out / "NOTES.md"])
    write_whole(out / "SHA256SUMS", "".join("%s  %s\n" % (hashlib.sha256(f.read_bytes()).hexdigest(), f.name) for f in files).encode())
    say("made: " + ", ".join("%s (%.1f MB)" % (f.name, f.stat().st_size / 1e6) for f in files))


def run(command, **options):
    """Runs a program whose failure is ours."""
    if subprocess.run(command, **options).returncode != 0:
        raise Failure("%s has failed: see above" % " ".join(map(str, command[:2])))


def build(level):
    """Builds the program for a level; its file."""
    say("building for %s ..." % (level or platform.machine()))
    environment = level_environment(level)
    run(["cargo", "build", "--release", "--bin", "bhs"], cwd=ROOT, env=environment)
    return Path(environment["CARGO_TARGET_DIR"]) / "release" / "bhs"


def embree_libraries():
    """The files of Embree and its TBB that the set-up has found, if they are its own; else the system's are asked for where bhs runs."""
    folders = sorted(DEPS.glob("embree-[0-9]*"))
    if not folders:
        raise Failure("releases bring the Embree of setup/embree.txt along, and this machine has one of its own; remove it, and .deps/stamp")
    return [path for path in folders[-1].iterdir() if not path.is_symlink()]


# ---- the archive ----


def archive(out, programs, libraries, glibc):
    """Packs the archive. The same commit gives the same names, order and times in it."""
    version = re.search(r'\nversion = "(.*)"', (ROOT / "Cargo.toml").read_text()).group(1)
    system = platform.system().lower().replace("darwin", "macos")
    name = "-".join(["bhs", version, system, platform.machine()])
    with tempfile.TemporaryDirectory() as tmp:
        top = Path(tmp) / name
        (top / "bin").mkdir(parents=True)
        (top / "lib" / "bhs").mkdir(parents=True)
        for level, program in programs.items():
            lowest = level == levels()[0]
            target = top / ("bin/bhs" if lowest else "lib/bhs/bhs-" + level)
            shutil.copy(program, target)
            if shutil.which("strip"):
                run(["strip", "-x" if system == "macos" else "-s", str(target)])
        for library in libraries:
            shutil.copy(library, top / "lib" / "bhs" / library.name)
        for path in tracked(INCLUDED):
            (top / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / path, top / path)
        own_words(top)
        licences(top / "licences")
        write_whole(top / "INSTALL.md", install(glibc).encode())
        pack(top, out / (name + ".tar.gz"))


def tracked(names):
    """The files of the repository below these names."""
    listed = output(["git", "-C", str(ROOT), "ls-files", "--", *names])
    if not listed:
        raise Failure("releases are made from a clone of the repository: git lists what belongs to it")
    return listed.splitlines()


def own_words(top):
    """Completions and manual pages, which the program writes itself."""
    program = str(top / "bin" / "bhs")
    manual = output([program, "man"])
    if manual is None:
        raise Failure("the program that was built does not start from another folder")
    for shell, name in SHELLS.items():
        write_whole(top / "share" / "completions" / name, (output([program, "completions", shell]) + "\n").encode())
    commands = re.findall(r"^\.TP\nbhs\\-(\w+)\(1\)", manual, re.M)
    for command in [None, *commands]:
        page = output([program, "man", *([command] if command else [])])
        write_whole(top / "share" / "man" / "man1" / ("bhs%s.1" % ("-" + command if command else "")), (page + "\n").encode())


def licences(folder):
    """The licences of the crates and libraries that are inside, and a list of them."""
    told = json.loads(output(["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", host()], cwd=ROOT) or "{}")
    used = {node["id"] for node in told.get("resolve", {}).get("nodes", [])}
    if not used:
        raise Failure("cargo metadata says nothing of the crates that bhs is made of")
    rows = ["Embree 4 and oneTBB (lib/bhs): Apache-2.0, the text of LICENSE-APACHE", ""]
    for package in sorted(told["packages"], key=lambda package: package["name"]):
        if package["id"] not in used or not package["source"]:
            continue
        rows.append("%s %s: %s" % (package["name"], package["version"], package["license"] or "see its file"))
        for path in sorted(Path(package["manifest_path"]).parent.glob("*")):
            if re.match(r"(?i)(un)?licen[cs]e|copying|notice|copyright", path.name) and path.is_file():
                write_whole(folder / ("%s-%s" % (package["name"], package["version"])) / path.name, path.read_bytes())
    write_whole(folder / "LIST.txt", ("\n".join(rows) + "\n").encode())


def host():
    """The kind of machine, as rustc calls it."""
    return re.search(r"^host: (.*)$", output(["rustc", "-vV"]) or "", re.M).group(1)


def install(glibc):
    """What the archive says of itself."""
    needs = "Linux with glibc %d.%d or newer" % glibc if glibc != (0, 0) else platform.system()
    return """# Installing bhs

Unpack this anywhere; `bin/bhs` is the program, or a link to it from a folder of your `PATH`. It finds what it needs from its own place. It needs %s.

    bin/bhs render scenes/cornell_hole.bhs
    python3 setup/meshes.py --all           # the meshes of other scenes, with npm or pip

`bin/bhs` runs the code that suits the processor; `bhs --version --verbose` says which, and `BHS_VECTORS` names another (docs/download.md). Completions for shells and
manual pages are in `share`, licences in `licences`.
""" % needs


def pack(top, path):
    """Writes a folder as .tar.gz."""
    time = int(output(["git", "-C", str(ROOT), "log", "-1", "--format=%ct"]) or 0)

    def plain(member):
        member.uid = member.gid = 0
        member.uname = member.gname = ""
        member.mtime = time
        return member

    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for file in sorted(top.rglob("*")):
            tar.add(file, arcname=file.relative_to(top.parent), recursive=False, filter=plain)
    with open(path, "wb") as sink, gzip.GzipFile(filename="", fileobj=sink, mode="wb", mtime=time) as zipped:
        zipped.write(packed.getvalue())


# ---- what is new ----


def notes(glibc):
    """What CHANGELOG.md says of this version, and what it runs on."""
    text = (ROOT / "CHANGELOG.md").read_text()
    version = re.search(r'\nversion = "(.*)"', (ROOT / "Cargo.toml").read_text()).group(1)
    found = re.search(r"^## %s.*?$(.*?)(?=^## |\Z)" % re.escape(version), text, re.M | re.S)
    if not found:
        raise Failure("CHANGELOG.md says nothing of version %s" % version)
    needs = "Linux with glibc %d.%d or newer; " % glibc if glibc != (0, 0) else ""
    return "# bhs %s\n\n%s%s: %s.\n%s" % (version, needs, platform.machine(), ", ".join(filter(None, levels())) or "one code", found.group(1))


if __name__ == "__main__":
    run_main(main, alone=False)
