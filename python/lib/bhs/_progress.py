"""How far a render is, for callbacks and for tqdm."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, Union


class Progress(NamedTuple):
    """How far a render is."""

    share: float
    """From 0 to 1."""
    spp: int
    """Samples that every pixel has."""
    total_spp: int
    elapsed: float
    """Seconds."""
    remaining: float | None
    """Seconds, once that can be foreseen."""
    mray_per_second: float


ProgressOption = Union[None, bool, Callable[[Progress], object]]


@contextmanager
def shown(progress: ProgressOption) -> Iterator[Callable[..., object] | None]:
    """What the module calls for `progress`, which is a callback, or `True` for a bar of tqdm."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with _bar(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed} gone, {remaining} left{postfix}") as bar:

            def show(*numbers: Any) -> None:
                reached = Progress(*numbers)
                bar.set_postfix_str(f"{reached.spp}/{reached.total_spp} spp", refresh=False)
                bar.update(100 * reached.share - bar.n)

            yield show
    else:
        callback = progress
        yield lambda *numbers: callback(Progress(*numbers))


@contextmanager
def counted(progress: bool | Callable[[int, int], object] | None, unit: str) -> Iterator[Callable[[int, int], object] | None]:
    """The same for so many of so many."""
    if progress is True:
        with _bar(unit=unit, unit_scale=True) as bar:

            def show(done: int, total: int) -> None:
                bar.total = total
                bar.update(done - bar.n)

            yield show
    else:
        yield progress or None


class _NoBar:
    """In place of a bar."""

    n = 0.0
    total = 0

    def update(self, by: float) -> None:
        pass

    def set_postfix_str(self, text: str, refresh: bool = True) -> None:
        pass


@contextmanager
def _bar(**options: Any) -> Iterator[Any]:
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        warnings.warn("progress=True shows a bar of tqdm, which is not installed: pip install tqdm", stacklevel=5)
        yield _NoBar()
        return
    with tqdm(**options) as bar:
        yield bar
