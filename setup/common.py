"""What setup.py, meshes.py, oidn.py and release.py share: paths, messages, running programs, wheels from PyPI, one set-up at a time."""

import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from contextlib import contextmanager, nullcontext
from pathlib import Path

try:
    import fcntl
except ImportError:  # on Windows: there nothing keeps two set-ups from being started at once
    fcntl = None

ROOT = Path(__file__).resolve().parent.parent
SETUP = ROOT / "setup"
DEPS = ROOT / ".deps"  # everything that is installed here; git ignores it


class Failure(Exception):
    """Something is missing that the set-up cannot get; the text says what, and how the user gets it."""


def say(text):
    """One line of progress, on stderr so that the program's own output stays clean."""
    print("bhs set-up: " + text, file=sys.stderr, flush=True)


def run_main(main, alone=True):
    """Runs `main`, alone on this checkout unless it starts set-up scripts itself; a Failure becomes a message and exit status 1."""
    try:
        with locked() if alone else nullcontext():
            main()
    except Failure as failure:
        sys.exit("bhs set-up: " + str(failure))
    except KeyboardInterrupt:
        sys.exit(130)


@contextmanager
def locked():
    """Holds .deps/lock, so that two set-ups started at once take turns, and clears what an interrupted one left."""
    DEPS.mkdir(exist_ok=True)
    with open(DEPS / "lock", "w") as lock:
        if fcntl:
            fcntl.flock(lock, fcntl.LOCK_EX)
        for leftover in DEPS.glob("tmp-*"):
            shutil.rmtree(leftover, ignore_errors=True)
        yield


@contextmanager
def scratch():
    """A temporary folder on the same file system as .deps, so that finished things can be renamed into place."""
    with tempfile.TemporaryDirectory(prefix="tmp-", dir=DEPS) as folder:
        yield Path(folder)


def write_whole(path, data):
    """Writes a file so that it is never seen half-written, and only when its content changes."""
    if path.is_file() and path.read_bytes() == data:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name("." + path.name + ".part")
    part.write_bytes(data)
    os.replace(part, path)


def output(command, **options):
    """A program's standard output, or None when it is absent or fails."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, **options)
    except OSError:
        return None
    return done.stdout.decode(errors="replace").strip() if done.returncode == 0 else None


def complaint(text):
    """What a program said went wrong, shortened and indented, for a message."""
    lines = [line for line in text.decode(errors="replace").splitlines() if "error" in line.lower()]
    return "\n".join("      " + (line if len(line) < 200 else "..." + line[-200:]) for line in lines[:4])


def pip():
    """The command that starts pip. A pip of another Python will do: wheels are only downloaded, never installed."""
    if importlib.util.find_spec("pip"):
        return [sys.executable, "-m", "pip"]
    for name in ("pip3", "pip"):
        if shutil.which(name):
            return [name]
    raise Failure(
        "pip is missing; it downloads what this machine's own packages lack.\n"
        "    Debian, Ubuntu: apt install python3-pip      Fedora: dnf install python3-pip      Arch: pacman -S python-pip\n"
        "    anywhere: python3 -m ensurepip --user"
    )


def requirement(name):
    """(package, version) pinned in setup/<name>.txt."""
    for line in (SETUP / (name + ".txt")).read_text().splitlines():
        if "==" in line and not line.startswith("#"):
            package, version = line.split()[0].split("==")
            return package, version
    raise Failure("setup/%s.txt pins nothing" % name)


def install_wheel(name, what, keep, instead, options=()):
    """Downloads the wheel pinned in setup/<name>.txt and unpacks it; returns the folder, which exists only when whole.

    pip checks the hash. `keep` maps a path in the wheel to one in the folder, or to None for what is not wanted.
    `what` and `instead` are for the message: what the wheel stands in for, and how else to get it.
    """
    package, version = requirement(name)
    folder = DEPS / ("%s-%s" % (name, version))
    if folder.is_dir():
        return folder
    download = pip() + ["download", "--no-deps", "--only-binary", ":all:", "--require-hashes"]
    download += ["--requirement", "setup/%s.txt" % name] + list(options)
    say("fetching the wheel %s %s from PyPI ..." % (package, version))
    with scratch() as tmp:
        quickly = ["--quiet", "--disable-pip-version-check", "--no-input", "--retries", "2", "--timeout", "30", "--dest", str(tmp)]
        environment = dict(os.environ, PIP_REQUIRE_VIRTUALENV="0")  # nothing is installed
        done = subprocess.run(download + quickly, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        wheels = list(tmp.glob("*.whl"))
        if done.returncode != 0 or not wheels:
            raise Failure(
                "%s is missing, and pip could not download the wheel %s %s:\n%s\n%s\n"
                "    or, on a machine with network, run this in a copy of this folder:\n"
                "      python3 -m pip %s --dest WHEELS\n"
                "      and copy WHEELS to this machine, and set PIP_FIND_LINKS to its full path before you start again"
                % (what, package, version, complaint(done.stderr), instead, " ".join(download[download.index("download") :]))
            )
        unpack(wheels[0], tmp / "unpacked", keep)
        (tmp / "unpacked").rename(folder)
    return folder


def unpack(wheel, folder, keep):
    """Unpacks the members of a wheel that `keep` names; programs stay executable."""
    with zipfile.ZipFile(wheel) as archive:
        for member in archive.infolist():
            wanted = None if member.is_dir() else keep(member.filename)
            if wanted:
                target = folder / wanted
                target.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(member) as source, open(target, "wb") as sink:
                    shutil.copyfileobj(source, sink)
                target.chmod(0o755 if (member.external_attr >> 16) & 0o111 else 0o644)


# ---- programs for other machines ----


def levels():
    """The levels of processors that downloads have code for, from the lowest (src/vectors.rs); `None` where there is one code for all.

    `BHS_LEVELS` names fewer of them, with commas between.
    """
    if platform.machine() not in ("x86_64", "AMD64"):
        return [None]
    every = ["x86-64-v2", "x86-64-v3", "x86-64-v4"]
    asked = os.environ.get("BHS_LEVELS", ",".join(every)).split(",")
    if unknown := [level for level in asked if level not in every]:
        raise Failure("BHS_LEVELS has `%s`; there are %s" % (unknown[0], ", ".join(every)))
    return [level for level in every if level in asked]


def level_environment(level):
    """The environment in which Cargo builds for a level, apart from what it builds for this machine.

    Its flags win over those of .cargo/config.toml, which are for this very processor.
    """
    environment = dict(os.environ)
    if level:
        environment["RUSTFLAGS"] = "-Ctarget-cpu=" + level
    environment["CARGO_TARGET_DIR"] = str(ROOT / "target" / (level or "release-all"))
    own = "@loader_path" if platform.system() == "Darwin" else "$ORIGIN"
    environment["BHS_RPATH"] = own + ":" + own + "/../lib/bhs"
    return environment


def needed_glibc(paths):
    """The oldest glibc that has all that these files ask of it, as (major, minor); (0, 0) where they ask nothing."""
    asked = [(0, 0)]
    for path in paths:
        asked += [tuple(map(int, found)) for found in re.findall(rb"\0GLIBC_(\d+)\.(\d+)", Path(path).read_bytes())]
    return max(asked)
