"""Pictures compared and developed, as by the program."""

import io
import json

import bhs
import numpy as np
import PIL.Image
import pytest
from conftest import ROOM


@pytest.fixture(scope="module")
def pair():
    """Two pictures of one scene."""
    scene = bhs.loads(ROOM)
    return scene.render(seed=1), scene.render(seed=2)


def test_differences_are_those_of_the_program(pair, tmp_path, program):
    paths = [tmp_path / "a.exr", tmp_path / "b.exr"]
    for picture, path in zip(pair, paths, strict=True):
        picture.save(path)
    right = json.loads(program("compare", *paths, "--json"))
    for a, b in [pair, paths, (pair[0].image, pair[1].image), (pair[0], paths[1])]:
        found = bhs.compare(a, b)
        for name in ["mse", "relative_mse", "psnr", "largest"]:
            assert getattr(found, name) == pytest.approx(right[name], rel=1e-14)
        assert found.mean_flip == pytest.approx(right["flip"], rel=1e-12)
        assert found.flip.shape == (30, 40) and list(found.mean_ratio) == (["B", "G", "R"] if a is paths[0] else ["R", "G", "B"])
        assert sorted(str(found).splitlines()) == sorted(program("compare", *paths, "--diff", tmp_path / "diff.png").splitlines())
    # By the definition.
    a, b = (picture.image.astype(np.float64) for picture in pair)
    assert found.mse == pytest.approx(((a - b) ** 2).mean(), rel=1e-12)


def test_equal_pictures_and_others(pair):
    same = bhs.compare(pair[0], pair[0].image, flip=False)
    assert (same.mse, same.psnr, same.largest, same.flip, same.mean_flip) == (0, np.inf, 0, None, None)
    with pytest.raises(bhs.Error, match="differ in size: 40x30 and 5x4"):
        bhs.compare(pair[0], np.zeros((4, 5, 3)))
    with pytest.raises(bhs.Error, match=r"\(height, width, 3\)"):
        bhs.compare(np.zeros((4, 5, 4)), np.zeros((4, 5, 4)))
    with pytest.raises(TypeError):
        bhs.compare(np.zeros((4, 5)), np.zeros((4, 5)))


@pytest.mark.parametrize(
    ("flags", "options"),
    [
        ([], {}),
        (["--exposure", "-1.5", "--tonecurve", "agx"], {"exposure": -1.5, "tonecurve": "agx"}),
        (["--exposure", "auto", "--white", "3200", "--bloom", "2"], {"exposure": "auto", "white": 3200, "bloom": 2}),
        (["--layer", "normal"], {"layer": "normal"}),
        (["--layer", "redshift", "--false-color"], {"layer": "redshift", "false_color": True}),
    ],
)
def test_pictures_are_developed_as_by_the_program(pair, tmp_path, program, flags, options):
    path = tmp_path / "a.exr"
    pair[0].save(path)
    program("develop", path, "-o", tmp_path / "a.png", "--quiet", *flags)
    right = np.asarray(PIL.Image.open(tmp_path / "a.png"))
    for shown in [bhs.develop(path, **options), bhs.develop(pair[0], **options), pair[0].develop(**options)]:
        assert shown.dtype == np.uint8 and (shown == right).all()
    if "layer" not in options:
        # An array has no look of its own: the scene's exposure is told.
        assert (bhs.develop(pair[0].image, **{"exposure": 1, **options}) == right).all()


def test_sixteen_bits_and_known_values():
    grey = np.array([[[0, 0.5, 1], [0.18, 0.18, 0.18]]])
    shown = bhs.develop(grey)
    assert shown.tolist() == [[[0, 188, 255], [118, 118, 118]]]
    # The sRGB curve by its definition.
    assert bhs.develop(grey, bits=16)[0, 0, 1] == round((1.055 * 0.5 ** (1 / 2.4) - 0.055) * 65535)
    assert bhs.develop(grey, exposure=1)[0, 0, 1] == 255
    with pytest.raises(bhs.Error, match="layers"):
        bhs.develop(grey, layer="redshift")
    with pytest.raises(bhs.Error, match="expected 8 or 16"):
        bhs.develop(grey, bits=12)


def test_a_picture_shows_itself(pair):
    shown = PIL.Image.open(io.BytesIO(pair[0]._repr_png_()))
    assert shown.size == (40, 30) and (np.asarray(shown) == pair[0].develop()).all()
