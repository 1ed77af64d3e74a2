"""Finds or installs what building bhs needs, and tells Cargo where it is. Started by ./bhs and ./test; needs no root.

Embree 4     from the system, else the PyPI wheel pinned in embree.txt, unpacked below .deps/
libclang     from the system, else the PyPI wheel pinned in libclang.txt, unpacked below .deps/
.cargo/config.toml   written, with the environment that the build scripts read (see `cargo_environment`), and this processor as target
.deps/stamp  written last: the paths that all this rests on. While they exist, prepare.sh does not come back here.
"""

import ctypes
import glob
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
from common import DEPS, ROOT, SETUP, Failure, install_wheel, output, run_main, say, scratch, write_whole  # noqa: E402

CONFIG = ROOT / ".cargo" / "config.toml"
CONFIG_HEADER = "# Written by setup/setup.py for this machine; git ignores it. Changes are lost: put yours into ~/.cargo/config.toml.\n"

EMBREE_PACKAGES = """\
    Connect this machine to the network and start again, or install Embree 4 yourself:
      Debian 13, Ubuntu 24.04: apt install libembree-dev      Fedora: dnf install embree-devel
      Arch: pacman -S embree      macOS: brew install embree      elsewhere: set BHS_EMBREE_DIR to the folder of libembree4"""
LIBCLANG_PACKAGES = """\
    Connect this machine to the network and start again, or install libclang yourself:
      Debian, Ubuntu: apt install libclang-dev      Fedora: dnf install clang-libs      Arch: pacman -S clang
      macOS: xcode-select --install      elsewhere: set LIBCLANG_PATH to the file"""

# bindgen 0.68, which embree4-sys uses, misreads what newer libclangs report.
LIBCLANG_OLDEST, LIBCLANG_NEWEST = 9, 21
SYSTEM_LIBCLANG_FOLDERS = [
    "/usr/lib/llvm*/lib*",
    "/usr/lib/llvm/*/lib*",
    "/usr/lib/*-linux-*",
    "/usr/lib64",
    "/usr/lib64/llvm*/lib*",
    "/usr/lib",
    "/usr/local/lib",
    "/Library/Developer/CommandLineTools/usr/lib",
    "/opt/homebrew/opt/llvm/lib",
    "/usr/local/opt/llvm/lib",
]


def main():
    compiler = c_compiler()
    found, failures = [], []
    for find in (lambda: find_embree(compiler), find_libclang):
        try:
            found.append(find())
        except Failure as failure:
            failures.append(str(failure))
    if failures:  # all of them at once: one visit to a package manager should be enough
        raise Failure("\nbhs set-up: ".join(dict.fromkeys(failures)))
    (embree, embree_dir), libclang = found
    write_config(cargo_environment(compiler, embree_dir, libclang))
    write_whole(DEPS / "stamp", "".join("%s\n" % path for path in (ROOT, CONFIG, embree, libclang)).encode())
    os.utime(DEPS / "stamp")
    say("Embree: %s" % embree)
    say("libclang: %s" % libclang)


def c_compiler():
    """The C compiler: Rust links with `cc`."""
    compiler = shutil.which("cc")
    if not compiler:
        raise Failure(
            "a C compiler (cc) is missing; Rust links with it.\n"
            "    Debian, Ubuntu: apt install gcc libc6-dev      Fedora: dnf install gcc      Arch: pacman -S gcc\n"
            "    macOS: xcode-select --install"
        )
    return compiler


# ---- Embree ----


def find_embree(compiler):
    """(library, folder to name to the linker or None when it needs no telling)."""
    given = os.environ.get("BHS_EMBREE_DIR")
    if given:
        if not os.path.isabs(given) or not embree_works(compiler, given):
            raise Failure("BHS_EMBREE_DIR is set to %s, which is no full path of a folder with a working libembree4" % given)
        return given, given
    if embree_works(compiler, None):
        return compiler_file(compiler, "libembree4.so") or compiler_file(compiler, "libembree4.dylib") or compiler, None
    for folder in ("/opt/homebrew/lib", "/usr/local/lib", "/home/linuxbrew/.linuxbrew/lib"):
        if os.path.isdir(folder) and embree_works(compiler, folder):
            return folder, folder
    runtime = compiler_file(compiler, "libembree4.so.4")
    if runtime:  # installed without its -dev package: give the linker the name it looks for
        folder = DEPS / "embree-system"
        folder.mkdir(exist_ok=True)
        link(folder / "libembree4.so", runtime)
        if embree_works(compiler, folder):
            return runtime, folder
    folder = embree_from_wheel()
    if not embree_works(compiler, folder):
        shutil.rmtree(folder)
        raise Failure("the Embree of the PyPI wheel does not run on this machine (it needs glibc 2.28).\n" + EMBREE_PACKAGES)
    return folder, folder


def embree_works(compiler, folder):
    """Whether a program that links Embree, from `folder` if given, builds, starts and finds version 4."""
    source = b"""
        #include <stdio.h>
        #include <sys/types.h>
        void *rtcNewDevice(const char *);
        ssize_t rtcGetDeviceProperty(void *, int);
        int main(void) {
            void *device = rtcNewDevice(0);
            return device && rtcGetDeviceProperty(device, 0) / 10000 == 4 ? 0 : 1;
        }"""
    with scratch() as tmp:
        command = [compiler, "-x", "c", "-", "-o", str(tmp / "probe")]
        if folder:
            command += ["-L%s" % folder, "-Wl,-rpath,%s" % folder]
        built = output(command + ["-lembree4"], input=source)
        return built is not None and output([str(tmp / "probe")]) is not None


def compiler_file(compiler, name):
    """Where the compiler finds a file of its own or one to link, or None."""
    path = output([compiler, "-print-file-name=" + name])
    return os.path.normpath(path) if path and os.path.isabs(path) else None


def embree_from_wheel():
    """Unpacks Embree and its TBB; the folder ends up with a libembree4.so (.dylib) for the linker."""
    system, machine = platform.system(), platform.machine()
    tag = {
        ("Linux", "x86_64"): "manylinux_2_28_x86_64",
        ("Darwin", "arm64"): "macosx_13_0_arm64",
        ("Darwin", "x86_64"): "macosx_13_0_x86_64",
    }.get((system, machine))
    if not tag:
        raise Failure("Embree 4 is missing, and PyPI has none for %s on %s.\n%s" % (system, machine, EMBREE_PACKAGES))

    def keep(path):
        return Path(path).name if re.match(r"embreex(\.libs|/\.dylibs)/", path) else None

    options = ["--platform", tag, "--python-version", "3.12", "--implementation", "cp", "--abi", "cp312"]
    folder = install_wheel("embree", "Embree 4", keep, EMBREE_PACKAGES, options)
    library = next(path for path in folder.glob("libembree4*") if not path.is_symlink())
    if system == "Linux":
        link(folder / "libembree4.so", library.name)
    else:
        # Programs look the library up under this name, in the folders that they themselves name: they may be moved with it.
        output(["install_name_tool", "-id", "@rpath/" + library.name, str(library)])
        output(["codesign", "--force", "--sign", "-", str(library)])
        link(folder / "libembree4.dylib", library.name)
    return folder


def link(path, target):
    """Makes `path` a symbolic link to `target`, whatever it was before."""
    if path.is_symlink() or path.exists():
        path.unlink()
    path.symlink_to(target)


# ---- libclang ----


def find_libclang():
    """The file of a libclang that bindgen can use."""
    given = os.environ.get("LIBCLANG_PATH")
    for path in libclang_candidates([given] if given else SYSTEM_LIBCLANG_FOLDERS):
        if LIBCLANG_OLDEST <= libclang_version(path) <= LIBCLANG_NEWEST:
            return os.path.abspath(path)
    if given:
        raise Failure("LIBCLANG_PATH is set to %s, which is no libclang of version %d to %d" % (given, LIBCLANG_OLDEST, LIBCLANG_NEWEST))

    def keep(path):
        return Path(path).name if "/native/libclang." in path else None

    folder = install_wheel("libclang", "libclang", keep, LIBCLANG_PACKAGES)
    path = next(folder.glob("libclang.*"))
    if not libclang_version(path):
        shutil.rmtree(folder)
        raise Failure("the libclang of the PyPI wheel does not load on this machine.\n" + LIBCLANG_PACKAGES)
    return path


def libclang_candidates(folders):
    """Files in these folders, or among these files, that may be a libclang, newest first in each."""
    for folder in [match for pattern in folders for match in newest_first(glob.glob(pattern))]:
        if os.path.isfile(folder):
            yield folder
        for pattern in ("libclang.so", "libclang.dylib", "libclang-[0-9]*.so*", "libclang.so.*"):
            yield from newest_first(glob.glob(os.path.join(folder, pattern)))


def newest_first(paths):
    """Sorts by the numbers in the names."""
    return sorted(paths, key=lambda path: [int(number) for number in re.findall(r"\d+", path)], reverse=True)


def libclang_version(path):
    """The major version of a libclang, 0 when it cannot be loaded."""

    class String(ctypes.Structure):
        _fields_ = [("data", ctypes.c_void_p), ("flags", ctypes.c_uint)]

    try:
        library = ctypes.CDLL(str(path))
        library.clang_getClangVersion.restype = String
        library.clang_getCString.argtypes = [String]
        library.clang_getCString.restype = ctypes.c_char_p
        text = library.clang_getCString(library.clang_getClangVersion()).decode()
    except (OSError, AttributeError):
        return 0
    version = re.search(r"version (\d+)", text)
    return int(version.group(1)) if version else 0


# ---- Cargo ----

# Built where it runs, with the vectors of this very processor, which the inner loops of orbits are written for.
TARGET_CPU = """
[target.'cfg(target_arch = "x86_64")']
rustflags = ["-Ctarget-cpu=native"]
"""


def cargo_environment(compiler, embree_dir, libclang):
    """The variables that the build scripts of embree4-sys (the last two) and of bhs (the first) read."""
    clang = ["-include", str(SETUP / "embree_layout.h")]
    builtin = compiler_file(compiler, "include")
    if builtin:
        clang += ["-idirafter", builtin]  # a libclang alone has no stddef.h; the compiler's own comes last
    if platform.system() == "Darwin":
        clang += ["-isysroot", output(["xcrun", "--show-sdk-path"]) or "/"]
    environment = {"LIBCLANG_PATH": str(libclang), "BINDGEN_EXTRA_CLANG_ARGS": " ".join(map(shlex.quote, clang))}
    if embree_dir:
        environment["BHS_EMBREE_DIR"] = str(embree_dir)
    return environment


def write_config(environment):
    """Writes .cargo/config.toml, unless there is one that somebody else wrote."""
    if CONFIG.is_file() and not CONFIG.read_text().startswith(CONFIG_HEADER[:30]):
        raise Failure(
            ".cargo/config.toml is not the set-up's own, and would be overwritten.\n"
            "    Move what it says into ~/.cargo/config.toml, delete it, and start again."
        )
    lines = ["%s = %s\n" % (name, json.dumps(value, ensure_ascii=False)) for name, value in sorted(environment.items())]
    write_whole(CONFIG, (CONFIG_HEADER + "\n[env]\n" + "".join(lines) + TARGET_CPU).encode())


if __name__ == "__main__":
    run_main(main)
