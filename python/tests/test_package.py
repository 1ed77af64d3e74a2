"""What the wheel brings along."""

import re
import subprocess
import sys
from pathlib import Path

import bhs
import mypy.api
from conftest import ROOT


def test_versions_agree(program):
    version = re.search(r'\[workspace.package\]\nversion = "(.*)"', (ROOT / "Cargo.toml").read_text()).group(1)
    crate = re.search(r'^version = "(.*?)"', (ROOT / "python/Cargo.toml").read_text(), re.M).group(1)
    assert bhs.__version__ == crate == version
    assert program("--version") == f"bhs {version}\n"


def test_the_two_lock_files_agree():
    """Else a wheel would be another bhs than the program."""

    def versions(path):
        found = {}
        for name, version in re.findall(r'^name = "(.*)"\nversion = "(.*)"', path.read_text(), re.M):
            found.setdefault(name, set()).add(version)
        return found

    own, root = versions(ROOT / "python/Cargo.lock"), versions(ROOT / "Cargo.lock")
    shared = own.keys() & root.keys()
    assert len(shared) > 100
    assert not [name for name in sorted(shared) if not own[name] & root[name]]


def test_the_program_is_there_as_a_module_too(program):
    done = subprocess.run([sys.executable, "-m", "bhs", "plugins", "spacetime"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == program("plugins", "spacetime")


def test_exit_codes_are_those_of_the_program(tmp_path):
    for words, code in [(["--no-such-flag"], 2), (["check", str(tmp_path / "none.bhs")], 1), (["--help"], 0)]:
        assert subprocess.run([sys.executable, "-m", "bhs", *words], capture_output=True).returncode == code


def test_types_are_told():
    folder = Path(bhs.__file__).parent
    assert (folder / "py.typed").is_file()
    said, wrong, status = mypy.api.run(["--config-file", str(ROOT / "python/pyproject.toml"), "--cache-dir", "/dev/null", "-p", "bhs"])
    assert status == 0, said + wrong


def test_what_is_public_is_described():
    for name in bhs.__all__:
        thing = getattr(bhs, name)
        if callable(thing):
            assert thing.__doc__, name
