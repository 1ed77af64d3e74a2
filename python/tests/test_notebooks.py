"""The notebooks run to their end, and what they assert holds. `BLESS=1` puts their pictures where docs/python.md shows them."""

import os
import shutil

import nbformat
import pytest
from conftest import ROOT
from nbclient import NotebookClient

NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))
SHOWN = ROOT / "docs/python"


def test_all_are_there():
    assert [path.stem for path in NOTEBOOKS] == ["disc_spectrum", "einstein_ring", "light_bending", "redshift"]
    page = (ROOT / "docs/python.md").read_text()
    assert all(f"](python/{path.stem}.png)" in page and f"](../python/notebooks/{path.name})" in page for path in NOTEBOOKS)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "what it shows is not kept in the repository: clear its outputs"
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    picture = tmp_path / f"{path.stem}.png"
    assert 5_000 < picture.stat().st_size < 75_000
    if os.environ.get("BLESS"):
        SHOWN.mkdir(exist_ok=True)
        shutil.copy(picture, SHOWN)
