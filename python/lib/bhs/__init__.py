"""bhs renders scenes with black holes in them, and follows their light, from Python.

>>> import bhs
>>> scene = bhs.loads('''
...     WorldBegin
...     BlackHole "schwarzschild" "float rs" 2
... ''')
>>> ray = scene.trace([0, 6, 100], [0, 0, -1])
>>> print(ray["outcome"], round(float(ray["b"]), 3))
escaped 6.0

The scene language is described in grammar/README.md of the repository, these functions in docs/python.md.
"""

from . import _vectors

_vectors.load()  # before anything else imports what is compiled

from ._bhs import __version__  # noqa: E402
from ._errors import Diagnostic, Error, SceneWarning
from ._picture import Comparison, Picture, compare, develop
from ._progress import Progress
from ._scene import Scene, Shape, load, loads

__all__ = [
    "Comparison",
    "Diagnostic",
    "Error",
    "Picture",
    "Progress",
    "Scene",
    "SceneWarning",
    "Shape",
    "__version__",
    "compare",
    "develop",
    "load",
    "loads",
]
