"""Finds or fetches Intel's Open Image Denoise 2, which bhs loads when a picture is to be denoised. Started by ./bhs and ./test; needs no root.

From the system, or from the folder that BHS_OIDN_DIR names, if they have it; else from the PyPI wheel pinned in oidn.txt, unpacked below .deps/.
src/denoise/library.rs looks in the same places.

With --if-there-is-one, a platform for which PyPI has no wheel is no failure: bhs works without the library, and its tests say what they skip.
"""

import ctypes
import os
import platform
import re
import shutil
import sys
from pathlib import Path

sys.dont_write_bytecode = True
from common import Failure, install_wheel, run_main, say  # noqa: E402

PACKAGES = """\
    Connect this machine to the network and start again, or install Open Image Denoise 2 yourself:
      Debian 13: apt install libopenimagedenoise-dev      Fedora: dnf install oidn-libs      Arch: pacman -S openimagedenoise
      macOS: brew install open-image-denoise      elsewhere: set BHS_OIDN_DIR to the folder of libOpenImageDenoise"""

NAME = "libOpenImageDenoise.2.dylib" if platform.system() == "Darwin" else "libOpenImageDenoise.so.2"
SYSTEM_FOLDERS = ["", "/opt/homebrew/lib", "/usr/local/lib"]  # the first: wherever the loader looks

# What a processor needs of the wheel; the rest is for graphics cards.
NEEDED = re.compile(
    r"pyoidn/oidn/lib/(libOpenImageDenoise\.so\.2|libOpenImageDenoise\.2\.dylib"
    r"|libOpenImageDenoise_(core|device_cpu)\.(so\.)?\d+\.\d+\.\d+(\.dylib)?|libtbb\.so\.12|libtbb\.12\.dylib)$"
)


def main():
    # What BHS_OIDN_DIR names is the user's; bhs says whether it is any good.
    if os.environ.get("BHS_OIDN_DIR") or any(works(os.path.join(folder, NAME)) for folder in SYSTEM_FOLDERS):
        return
    tag = {
        ("Linux", "x86_64"): "manylinux2014_x86_64",
        ("Darwin", "arm64"): "macosx_14_0_arm64",
        ("Darwin", "x86_64"): "macosx_13_0_x86_64",
    }.get((platform.system(), platform.machine()))
    if not tag:
        missing = "Open Image Denoise 2 is missing, and PyPI has none for %s on %s" % (platform.system(), platform.machine())
        if "--if-there-is-one" in sys.argv:
            say(missing + ": nothing will be denoised")
            return
        raise Failure(missing + ".\n" + PACKAGES)

    def keep(path):
        # In a folder of this name the libraries find one another.
        return "lib/" + Path(path).name if NEEDED.match(path) else None

    options = ["--platform", tag, "--python-version", "3.12"]
    folder = install_wheel("oidn", "Open Image Denoise 2", keep, PACKAGES, options)
    if not works(str(folder / "lib" / NAME)):
        shutil.rmtree(folder)
        raise Failure("the Open Image Denoise of the PyPI wheel does not run on this machine.\n" + PACKAGES)
    say("Open Image Denoise: %s" % folder)


def works(path):
    """Whether the library loads, and finds what computes on this machine's processor."""
    try:
        library = ctypes.CDLL(path)
        library.oidnNewDevice.restype = ctypes.c_void_p
        library.oidnCommitDevice.argtypes = library.oidnReleaseDevice.argtypes = [ctypes.c_void_p]
        library.oidnGetDeviceInt.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
    except (OSError, AttributeError):
        return False
    device = library.oidnNewDevice(1)  # the processor
    if not device:
        return False
    library.oidnCommitDevice(device)
    version = library.oidnGetDeviceInt(device, b"version")
    library.oidnReleaseDevice(device)
    return version // 10000 == 2


if __name__ == "__main__":
    run_main(main)
