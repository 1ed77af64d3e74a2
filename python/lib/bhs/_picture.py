"""Pictures: rendered, compared, developed."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _bhs


class Picture:
    """A picture that has been rendered: made by `Scene.render`. In a notebook it shows itself."""

    def __init__(self, picture: _bhs.Picture) -> None:
        self._picture = picture

    @cached_property
    def image(self) -> np.ndarray:
        """Linear red, green and blue (sRGB primaries): an array of shape (height, width, 3), single precision, as the EXR file has them."""
        return self._picture.image()

    @cached_property
    def layers(self) -> Mapping[str, np.ndarray]:
        """Its layers by name: arrays of shape (height, width), or (height, width, n) of layers with several channels. NaN where no ray has a value."""
        return {name: values[..., 0] if values.shape[-1] == 1 else values for name, (values, _) in self._picture.layers().items()}

    @cached_property
    def units(self) -> Mapping[str, str]:
        """The units of its layers; `scene` are units of the scene."""
        return {name: unit for name, (_, unit) in self._picture.layers().items()}

    @cached_property
    def channels(self) -> Mapping[str, np.ndarray]:
        """All channels of the EXR file by name, each of shape (height, width); there -0 stands for no value of a layer."""
        return self._picture.channels()

    @cached_property
    def stats(self) -> dict[str, Any]:
        """What it took: what `bhs render --stats` writes."""
        stats: dict[str, Any] = json.loads(self._picture.stats)
        return stats

    @property
    def spp(self) -> int:
        """Samples that every pixel has."""
        return int(self.stats["samples_per_pixel"])

    @property
    def notes(self) -> list[str]:
        """What the user should know of it."""
        return self._picture.notes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the EXR file (`.exr`: all channels, linear, with what is known of the picture in its header) or the PNG file (`.png`: developed), as the
        program does. It appears whole, or not at all."""
        self._picture.save(os.fspath(path))

    def develop(
        self,
        *,
        exposure: float | str | None = None,
        tonecurve: str | None = None,
        white: float | str | None = None,
        bloom: float | None = None,
        bits: int | None = None,
        layer: str | None = None,
        false_color: bool = False,
    ) -> np.ndarray:
        """The picture, or a layer, as a screen shows it: see `bhs.develop`. What is not given is as the picture was rendered with."""
        return _array(self._picture.develop(look_words(exposure, tonecurve, white, bloom, bits), layer, false_color))

    def _repr_png_(self) -> bytes:
        return self._picture.png()

    def __repr__(self) -> str:
        height, width = self.image.shape[:2]
        layers = "".join(f", {name}" for name in self.layers)
        return f"<bhs.Picture {width}x{height}, {self.spp} spp{layers}>"


AnyPicture = Union[Picture, str, "os.PathLike[str]", npt.ArrayLike]


@dataclass(frozen=True)
class Comparison:
    """How far a picture is from a reference. `str()` is the table that `bhs compare` prints."""

    mse: float
    """Mean of the squared differences."""
    relative_mse: float
    """Mean of squared difference over squared reference, with 1e-2 of its mean square added below."""
    psnr: float
    """Peak signal-to-noise ratio for a peak of 1 (dB); infinite for equal pictures."""
    largest: float
    """Largest difference of two values."""
    mean_ratio: dict[str, float]
    """Mean of the picture over that of the reference, by channel."""
    flip: np.ndarray | None
    """FLIP of each pixel, from 0 to 1: how much the difference catches the eye; `None` if it was not asked for, or there are no colours."""
    _text: str

    @property
    def mean_flip(self) -> float | None:
        """The mean of FLIP."""
        return None if self.flip is None else float(self.flip.mean(dtype=np.float64))

    def __str__(self) -> str:
        return self._text


def compare(a: AnyPicture, b: AnyPicture, *, flip: bool = True) -> Comparison:
    """Compares the picture `a` with the reference `b`: each a `Picture`, an array of linear red, green and blue of shape (height, width, 3), or the path
    of an EXR file. FLIP takes the longest; `flip=False` leaves it out."""
    (mse, relative_mse, psnr, largest), ratios, image, text = _bhs.compare(_given(a), _given(b), flip)
    return Comparison(mse, relative_mse, psnr, largest, dict(ratios), image, text.rstrip())


def develop(
    picture: AnyPicture,
    *,
    exposure: float | str | None = None,
    tonecurve: str | None = None,
    white: float | str | None = None,
    bloom: float | None = None,
    bits: int | None = None,
    layer: str | None = None,
    false_color: bool = False,
) -> np.ndarray:
    """A picture as a screen shows it: an array of shape (height, width, 3) of whole numbers, 8 bits or with `bits=16` that many.

    `picture` is a `Picture`, an array of linear red, green and blue, or the path of an EXR file. `exposure` (stops, or `"auto"`), `tonecurve` (`"clip"`,
    `"reinhard"`, `"aces"`, `"agx"`), `white` (K, or `"auto"`) and `bloom` (pixels) are those of `bhs develop`; `layer` shows a layer in place of the picture,
    `false_color` in colours that stand for its numbers.
    """
    if isinstance(picture, Picture):
        return picture.develop(
            exposure=exposure, tonecurve=tonecurve, white=white, bloom=bloom, bits=bits, layer=layer, false_color=false_color
        )
    look = look_words(exposure, tonecurve, white, bloom, bits)
    return _array(_bhs.develop(_given(picture), look, layer, false_color))


def look_words(
    exposure: float | str | None,
    tonecurve: str | None,
    white: float | str | None,
    bloom: float | None,
    bits: int | None,
) -> dict[str, str]:
    """What is given, in words."""
    given = {"exposure": exposure, "tonecurve": tonecurve, "white": white, "bloom": bloom, "bits": bits}
    return {name: str(value) for name, value in given.items() if value is not None}


def _given(picture: AnyPicture) -> Any:
    """As the module takes it."""
    if isinstance(picture, Picture):
        return picture._picture
    if isinstance(picture, (str, os.PathLike)):
        return os.fspath(picture)
    return np.ascontiguousarray(picture, dtype=np.float32)


def _array(shown: tuple[np.ndarray, list[int], int]) -> np.ndarray:
    data, (width, height), size = shown
    numbers = data if size == 1 else data.view(">u2").astype(np.uint16)
    return numbers.reshape(height, width, 3)
