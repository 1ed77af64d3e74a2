"""What tests share: small scenes, the program of the same wheel, and what it says."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]

# A hole before a wall with a lamp beside it: surfaces, sky, shadow and noise.
ROOM = """
Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "float exposure" 1 "string layers" ["redshift" "normal"]
Sampler "sobol" "integer pixelsamples" 4
LookAt 0 1 -6  0 1 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
BlackHole "schwarzschild" "point3 center" [0 1 0] "float rs" 0.5
LightSource "infinite" "rgb L" [0.2 0.3 0.4]
Shape "bilinearmesh" "point3 P" [-2 -1 3  2 -1 3  -2 3 3  2 3 3]
AttributeBegin
  AreaLightSource "diffuse" "float scale" 0.05 "bool twosided" true
  Translate 2 2 0
  Shape "sphere" "float radius" 0.4
AttributeEnd
"""

# A hole of rs = 2 (M = 1) with nothing around it.
HOLE = 'WorldBegin BlackHole "schwarzschild" "float rs" 2 LightSource "infinite"'


@pytest.fixture
def room(tmp_path):
    """The file of a scene."""
    path = tmp_path / "room.bhs"
    path.write_text(ROOM)
    return path


@pytest.fixture(scope="session")
def program():
    """Runs the program that the wheel has installed; what it writes to standard output."""

    def run(*words, text=None):
        command = [str(Path(sys.executable).parent / "bhs"), *map(str, words)]
        done = subprocess.run(command, input=text, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def traced(program):
    """What the program says of rays, or pairs: an object for each."""

    def run(scene, flag, rows):
        lines = "\n".join(",".join(repr(float(x)) for x in row) for row in np.reshape(rows, (-1, 6)))
        return [json.loads(line) for line in program("trace", scene, flag, "-", text=lines + "\n").splitlines()]

    return run
