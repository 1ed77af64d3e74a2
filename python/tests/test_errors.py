"""One exception, with the message as the program draws it and the findings as data."""

import pickle

import bhs
import pytest
from conftest import ROOM

FAULTY = ROOM.replace('"float fov" 50', '"float fow" 50').replace('"float rs" 0.5', '"float rs" -1')


def test_all_findings_have_their_places(tmp_path):
    path = tmp_path / "faulty.bhs"
    path.write_text(FAULTY)
    with pytest.raises(bhs.Error) as caught:
        bhs.load(path)
    found = caught.value.diagnostics
    assert [(d.severity, d.code, d.line, d.column) for d in found] == [
        ("error", "unknown-parameter", 5, 29),
        ("error", "bad-value", 7, found[1].column),
    ]
    assert found[0].file == str(path) and found[0].end_line == 5 and found[0].end_column == 32
    assert "fow" in found[0].message and "fov" in found[0].hint
    # As it is drawn.
    said = str(caught.value)
    assert "faulty.bhs:5:29" in said and "^^^" in said and said.endswith("2 errors")


def test_of_a_text_too():
    with pytest.raises(bhs.Error, match="<text>:5:29") as caught:
        bhs.loads(FAULTY)
    assert caught.value.diagnostics[0].file == "<text>"
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.diagnostics == caught.value.diagnostics


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(bhs.Error, match="cannot read the scene") as caught:
        bhs.load(tmp_path / "none.bhs")
    assert [d.code for d in caught.value.diagnostics] == ["cannot-read"]
    with pytest.raises(bhs.Error, match="cannot read"):
        bhs.compare(tmp_path / "none.exr", tmp_path / "none.exr")
    with pytest.raises(bhs.Error, match="cannot read"):
        bhs.develop(tmp_path / "none.exr")


def test_warnings_are_told_and_kept():
    with pytest.warns(bhs.SceneWarning, match="never used"):
        scene = bhs.loads(ROOM + 'MakeNamedMaterial "paint" "string type" "diffuse"')
    assert [d.severity for d in scene.warnings] == ["warning"] and scene.warnings[0].line == 15


def test_variables():
    text = ROOM.replace('"float fov" 50', '"float fov" $fov').replace("Sampler", 'Define "fov" 30\nSampler')
    default, wide = bhs.loads(text), bhs.loads(text, fov=80)
    assert default.variables == {} and wide.variables == {"fov": 80.0}
    assert (default.render().image != wide.render().image).any()
    assert (bhs.loads(text, fov=50).render().image == bhs.loads(ROOM).render().image).all()
    for variables, why in [({"fow": 80}, "did you mean `fov`"), ({"fov": float("nan")}, "variable `fov`: .*not a number")]:
        with pytest.raises(bhs.Error, match=why):
            bhs.loads(text, **variables)
    with pytest.raises(TypeError):
        bhs.loads(text, fov="wide")
