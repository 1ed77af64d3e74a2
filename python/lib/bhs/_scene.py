"""Scenes."""

from __future__ import annotations

import operator
import os
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _bhs
from ._errors import Diagnostic, Error, SceneWarning
from ._picture import Picture, look_words
from ._progress import ProgressOption, counted, shown

_OUTCOMES = np.array(["hit", "escaped", "captured", "out of steps"])
_SIDES = np.array(["", "near", "far"])

Resolution = Sequence[int]
RayProgress = Union[None, bool, Callable[[int, int], object]]


class Shape(NamedTuple):
    """A `Shape` directive of a scene."""

    name: str
    """Of the plugin, such as `sphere`."""
    place: str
    """File, line and column."""


def load(path: str | os.PathLike[str], /, **variables: float) -> Scene:
    """Loads the scene file `path`; `variables` are numbers for those that it defines, as `-D` gives them to the program.

    Raises `bhs.Error` with all that is wrong with it, and warns with `bhs.SceneWarning`.
    """
    return Scene(os.fspath(path), None, variables)


def loads(text: str, /, **variables: float) -> Scene:
    """Loads the scene `text`, whose relative paths start from the current folder: see `load`."""
    return Scene(None, text, variables)


class Scene:
    """A scene that has been loaded: made by `bhs.load` and `bhs.loads`."""

    def __init__(self, path: str | None, text: str | None, variables: dict[str, float]) -> None:
        self._name = path or "<text>"
        self._scene = _bhs.Scene(path, text, variables)
        said, found = self._scene.warnings
        self.warnings: list[Diagnostic] = [Diagnostic._of_json(one) for one in found]
        """What the user should know of it."""
        if found:
            warnings.warn(said, SceneWarning, stacklevel=3)

    def __repr__(self) -> str:
        width, height = self.resolution
        return f"<bhs.Scene {self._name}: {width}x{height} pixels, {self.spp} spp, {len(self.shapes)} shapes>"

    @property
    def cameras(self) -> list[str | None]:
        """The names of its cameras; `None` of one without a name."""
        return self._scene.cameras

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of its picture (pixels)."""
        width, height = self._scene.resolution
        return width, height

    @property
    def spp(self) -> int:
        """Samples a pixel."""
        return self._scene.spp

    @property
    def seed(self) -> int:
        """The seed of its random numbers."""
        return self._scene.seed

    @property
    def integrator(self) -> str:
        """The name of the integrator of light rays; `straight` where nothing bends light."""
        return self._scene.integrator

    @property
    def variables(self) -> dict[str, float]:
        """The variables that were given and that it reads."""
        return self._scene.variables

    @property
    def shapes(self) -> list[Shape]:
        """Its `Shape` directives: what the column `shape` of `trace` counts."""
        return [Shape(*shape) for shape in self._scene.shapes]

    def render(
        self,
        spp: int | None = None,
        seed: int | None = None,
        *,
        resolution: Resolution | None = None,
        crop: Sequence[float] | None = None,
        camera: str | None = None,
        layers: Sequence[str] = (),
        integrator: str | None = None,
        transport: str | None = None,
        quick: bool = False,
        exposure: float | str | None = None,
        tonecurve: str | None = None,
        white: float | str | None = None,
        bloom: float | None = None,
        bits: int | None = None,
        denoise: bool = False,
        time: float | None = None,
        noise: float | None = None,
        noise_over: str | None = None,
        min_spp: int | None = None,
        threads: int | None = None,
        progress: ProgressOption = None,
    ) -> Picture:
        """Renders the picture of a camera, of the first one unless `camera` names another, as `bhs render` does with flags of these names: the numbers are the same.

        `layers` are recorded besides those of the scene (`--aov`). `time` (s) ends it early. `noise` gives each pixel samples until its
        noise is below it, or with `noise_over="picture"` the picture as a whole, `spp` of them at most; `min_spp` is the least with either.
        `progress` is called about twenty times a second with a
        `bhs.Progress`, or `True` for a bar of tqdm. Other Python threads go on meanwhile, and Ctrl-C stops it.
        """
        options: dict[str, Any] = {
            "spp": _whole("spp", spp, 32),
            "seed": _whole("seed", seed, 64),
            "resolution": _several("resolution", resolution, 2),
            "crop": _several("crop", crop, 4),
            "camera": camera,
            "layers": _names("layers", layers),
            "integrator": integrator,
            "transport": transport,
            "quick": quick,
            "look": look_words(exposure, tonecurve, white, bloom, bits),
            "denoise": denoise,
            "time": time,
            "noise": noise,
            "noise_over": noise_over,
            "min_spp": _whole("min_spp", min_spp, 32),
            "threads": _whole("threads", threads, 32),
        }
        with shown(progress) as callback:
            picture = Picture(self._scene.render(options, callback))
        for note in picture.notes:
            if note.startswith("warning: "):
                warnings.warn(note.removeprefix("warning: "), SceneWarning, stacklevel=2)
        return picture

    def trace(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        *,
        side: str | npt.ArrayLike = "near",
        footprint: npt.ArrayLike = 0.0,
        threads: int | None = None,
        progress: RayProgress = None,
    ) -> np.ndarray:
        """Follows rays and returns what becomes of each: a structured array with the names that `bhs trace` gives its JSON.

        `origins` (world coordinates) and `directions` (of the chart, of any length) have three numbers in their last axis, and are broadcast against
        one another; the array has the shape of what is before that. `side` is `near` or `far`, of all or of each; `footprint` is the width of the
        patch that a ray stands for where it arrives (scene units). Numbers that a ray does not have are NaN, `shape` is -1 then, texts are empty.
        """
        rays, shape = _rays(origins, directions, side, footprint)
        with counted(progress, "ray") as callback:
            columns = self._scene.trace(rays, threads, callback)
        return self._rows(columns).reshape(shape)

    def trace_pixels(self, pixels: npt.ArrayLike, *, camera: str | None = None, threads: int | None = None) -> np.ndarray:
        """Follows the rays through the centres of pixels of a camera: what its picture sees there.

        `pixels` are columns and rows, counted from 0 from the top left: two numbers in the last axis. The array is that of `trace`, with `ray_origin` and
        `ray_direction` besides. Light is measured by the camera, which may move.
        """
        given = np.asarray(pixels)
        if given.shape[-1:] != (2,):
            raise ValueError(f"expected pixels as pairs of column and row, found an array of shape {given.shape}")
        if not np.issubdtype(given.dtype, np.integer) or (given.size and given.min() < 0):
            raise ValueError("expected columns and rows of pixels as whole numbers, counted from 0")
        flat = np.ascontiguousarray(given.reshape(-1, 2), dtype=np.uint32)
        columns = self._scene.trace_pixels(flat, camera, threads)
        return self._rows(columns).reshape(given.shape[:-1])

    def path(self, origin: npt.ArrayLike, direction: npt.ArrayLike, *, side: str = "near") -> np.ndarray:
        """The points of the way of one ray, as a structured array: `point`, `direction`, `side`, `phi` (angle swept around the hole), `time` (that light
        takes from there to the start), `redshift` (of light from there)."""
        rays, shape = _rays(origin, direction, side, 0.0)
        if shape:
            raise ValueError("expected one ray: three numbers for its origin and three for its direction")
        columns = self._scene.path(rays)
        columns["side"] = _SIDES[columns["side"]]
        return _structured(columns)

    def connect(self, p: npt.ArrayLike, q: npt.ArrayLike, *, threads: int | None = None) -> np.ndarray:
        """The geodesics from the points `p` to the points `q` (world coordinates, three numbers in the last axis, broadcast against one another).

        A structured array with a row for each geodesic: `pair` is the number of its pair, `image` that of the geodesic (two for each turn around the
        hole), `phi` the angle that it sweeps, `launch` and `arrival` its unit directions, `spread` the area across a bundle at `q` per solid angle at `p`,
        `blocked` whether a surface stands in its way.
        """
        starts, ends = np.broadcast_arrays(_points(p, "p"), _points(q, "q"))
        return _structured(self._scene.connect(_flat(starts), _flat(ends), threads))

    def _rows(self, columns: dict[str, np.ndarray]) -> np.ndarray:
        """The array of rays of their columns, with texts in place of numbers."""
        shapes = self.shapes
        named = {}
        for name, values in columns.items():
            if name == "outcome":
                values = _OUTCOMES[values]
            elif name == "side":
                values = _SIDES[values]
            named[name] = values
            if name == "shape":
                # The last one is that of no shape, -1.
                named["shape_name"] = np.array([*(shape.name for shape in shapes), ""])[values]
                named["shape_place"] = np.array([*(shape.place for shape in shapes), ""])[values]
        return _structured(named)


def _whole(name: str, number: int | None, bits: int) -> int | None:
    """A number that may be given."""
    if number is None:
        return None
    try:
        whole = operator.index(number)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, found {number!r}") from None
    if not 0 <= whole < 1 << bits:
        raise Error(f"{name}: expected a whole number from 0 to {(1 << bits) - 1}, found {whole}")
    return whole


def _several(name: str, numbers: Sequence[float] | None, count: int) -> list[float] | None:
    """So many numbers that may be given."""
    if numbers is None:
        return None
    try:
        given = list(numbers)
    except TypeError:
        given = []
    if len(given) != count:
        raise TypeError(f"{name}: expected {count} numbers, found {numbers!r}")
    return given


def _names(name: str, names: Sequence[str]) -> list[str]:
    if isinstance(names, str):
        raise TypeError(f"{name}: expected a list of names, such as [{names!r}]")
    return list(names)


def _structured(columns: dict[str, np.ndarray]) -> np.ndarray:
    """An array of records of columns of one length."""
    rows = np.empty(
        len(next(iter(columns.values()))),
        dtype=[(name, values.dtype, values.shape[1:]) for name, values in columns.items()],
    )
    for name, values in columns.items():
        rows[name] = values
    return rows


def _points(given: npt.ArrayLike, name: str) -> np.ndarray:
    points = np.asarray(given, dtype=np.float64)
    if points.shape[-1:] != (3,):
        raise ValueError(f"{name}: expected points of three numbers, found an array of shape {points.shape}")
    return points


def _flat(points: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(points.reshape(-1, 3))


def _rays(
    origins: npt.ArrayLike, directions: npt.ArrayLike, side: str | npt.ArrayLike, footprint: npt.ArrayLike
) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[int, ...]]:
    """Rays as the module takes them, and the shape of their array."""
    starts, ways = np.broadcast_arrays(_points(origins, "origins"), _points(directions, "directions"))
    shape = starts.shape[:-1]
    sides = np.asarray(side)
    if not np.isin(sides, ["near", "far"]).all():
        raise ValueError("side: expected `near` or `far`")
    far = np.ascontiguousarray(np.broadcast_to(sides == "far", shape)).ravel()
    widths = np.ascontiguousarray(np.broadcast_to(np.asarray(footprint, dtype=np.float64), shape)).ravel()
    return (_flat(starts), _flat(ways), far, widths), shape
