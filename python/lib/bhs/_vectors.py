"""Loads the compiled module that suits the processor: a wheel brings one for each level of processors, of which `_bhs` itself is the lowest."""

import os
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

from . import _bhs as lowest


def load() -> None:
    """Puts the module of the level that `BHS_VECTORS` names in place of the lowest, else that of the best that the processor runs."""
    name = lowest.__name__
    others = {path.stem.removeprefix("_bhs-"): path for path in sorted(Path(__file__).parent.glob("_bhs-*.so"))}
    asked, levels = os.environ.get("BHS_VECTORS") or None, [lowest.vectors(), *others]
    chosen = lowest.choose_vectors(asked, levels)
    if chosen not in others:
        return
    spec = spec_from_loader(name, ExtensionFileLoader(name, str(others[chosen])))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    module.choose_vectors(asked, levels)  # it says why it runs
    sys.modules[name] = module
    setattr(sys.modules[__package__ or ""], "_bhs", module)
