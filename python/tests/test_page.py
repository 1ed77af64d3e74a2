"""The examples of docs/python.md run as they stand, one after the other, and say what the page says."""

import re

from conftest import ROOT


def test_examples_run(tmp_path, monkeypatch, capsys):
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/python.md").read_text(), re.M | re.S)
    names = {}
    for example in examples:
        exec(compile(example, "docs/python.md", "exec"), names)
    assert len(examples) == 4
    assert (tmp_path / "kerr_disc.exr").is_file() and names["picture"].layers["redshift"].shape == (144, 256)
    assert names["shown"].dtype == "uint8" and names["difference"].psnr > 0
    assert set(names["rays"]["outcome"]) == {"hit", "captured"} and set(names["joined"]["pair"]) == {0, 1}
    assert "1 29 unknown parameter `fow`" in capsys.readouterr().out


def test_the_example_of_the_package(capsys):
    import doctest

    import bhs

    assert doctest.testmod(bhs).attempted > 0 and doctest.testmod(bhs).failed == 0
