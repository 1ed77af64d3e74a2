"""Pictures are those of the program, to the bit, and rendering gets in nobody's way."""

import os
import signal
import subprocess
import sys
import threading
import time

import bhs
import numpy as np
import OpenEXR
import pytest
from conftest import HOLE, ROOM

# Hours of work.
LONG = ROOM.replace('"integer pixelsamples" 4', '"integer pixelsamples" 100000000')


def channels(path):
    """The channels of an EXR file, as somebody else's library reads them."""
    found = OpenEXR.File(str(path), separate_channels=True).channels()
    return {name: channel.pixels for name, channel in found.items()}


def same_bits(a, b):
    return a.shape == b.shape and a.dtype == b.dtype == np.float32 and (a.view(np.uint32) == b.view(np.uint32)).all()


@pytest.mark.parametrize(
    ("flags", "options"),
    [
        ([], {}),
        (["--spp", "7", "--seed", "3"], {"spp": 7, "seed": 3}),
        (["--resolution", "20x10", "--crop", "0.25,1,0,0.5"], {"resolution": (20, 10), "crop": (0.25, 1, 0, 0.5)}),
        (["--aov", "impactparameter", "--transport", "hemisphere"], {"layers": ["impactparameter"], "transport": "hemisphere"}),
        (["--quick", "--integrator", "exact", "--threads", "1"], {"quick": True, "integrator": "exact", "threads": 1}),
        (["--noise", "0.05", "--spp", "64", "--min-spp", "8"], {"noise": 0.05, "spp": 64, "min_spp": 8}),
        (["--noise", "0.1", "--spp", "64", "--noise-over", "picture"], {"noise": 0.1, "spp": 64, "noise_over": "picture"}),
        (["--exposure", "auto", "--tonecurve", "aces", "--bits", "16"], {"exposure": "auto", "tonecurve": "aces", "bits": 16}),
    ],
)
def test_numbers_and_files_are_those_of_the_program(room, tmp_path, program, flags, options):
    program("render", room, "-o", tmp_path / "program.exr", "--quiet", *flags)
    picture = bhs.load(room).render(**options)
    right = channels(tmp_path / "program.exr")
    assert picture.channels.keys() == right.keys()
    assert all(same_bits(picture.channels[name], right[name]) for name in right)
    assert same_bits(picture.image, np.stack([right[c] for c in "RGB"], axis=-1))
    assert picture._repr_png_() == (tmp_path / "program.png").read_bytes()

    picture.save(tmp_path / "python.exr")
    picture.save(str(tmp_path / "python.png"))
    written = channels(tmp_path / "python.exr")
    assert all(same_bits(written[name], right[name]) for name in right)
    assert (tmp_path / "python.png").read_bytes() == (tmp_path / "program.png").read_bytes()
    headers = [OpenEXR.File(str(tmp_path / name)).header() for name in ["program.exr", "python.exr"]]
    passing = {"capDate", "comments", "bhs:seconds", "utcOffset"}
    said = [{k: str(v) for k, v in header.items() if k not in passing and k != "channels"} for header in headers]
    assert said[0] == said[1] and "bhs:scene" in said[0]


def test_layers_have_nan_where_no_ray_has_a_value(room):
    picture = bhs.load(room).render(layers=["impactparameter"])
    assert list(picture.layers) == ["redshift", "normal", "impactparameter"]
    assert picture.units["impactparameter"] == "scene"
    redshift, normal = picture.layers["redshift"], picture.layers["normal"]
    assert redshift.shape == (30, 40) and normal.shape == (30, 40, 3)
    # The shadow has no redshift, the sky no normal; the wall looks along z.
    assert np.isnan(redshift).any() and np.isnan(normal).any(axis=-1).sum() > np.isnan(redshift).sum()
    wall = normal[~np.isnan(normal).any(axis=-1) & (np.abs(np.abs(normal[..., 2]) - 1) < 1e-6)]
    assert len(wall) > 100
    # In the file these are -0.
    assert (np.signbit(picture.channels["redshift"]) == np.isnan(redshift)).all()


def test_threads_and_repetition_do_not_matter(room):
    scene = bhs.load(room)
    pictures = [scene.render(threads=threads).image for threads in [1, 2, 3, None]]
    assert all(same_bits(pictures[0], other) for other in pictures[1:])


def test_several_cameras(tmp_path):
    scene = bhs.loads(ROOM.replace('Camera "perspective"', 'Camera "orthographic" "string name" "flat"\nCamera "perspective" "string name" "other"'))
    assert scene.cameras == ["flat", "other"]
    first, flat, other = (scene.render(camera=name).image for name in [None, "flat", "other"])
    assert same_bits(first, flat) and not same_bits(flat, other)
    with pytest.raises(bhs.Error, match="did you mean `flat`"):
        scene.render(camera="flt")


def test_a_scene_whose_files_change_is_refused(room):
    scene = bhs.load(room)
    before = scene.render().image
    room.write_text(ROOM.replace("0.2 0.3 0.4", "0.2 0.3 0.9"))
    # What was loaded is there; anything else would be another scene.
    assert same_bits(scene.render().image, before)
    with pytest.raises(bhs.Error, match="has changed since it was loaded"):
        scene.render(spp=2)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"spp": 0}, "pixelsamples"),
        ({"seed": 1 << 64}, "seed: expected a whole number"),
        ({"resolution": (0, 10)}, "from 1 to 65536"),
        ({"crop": (0.5, 0.5, 0, 1)}, "cropwindow"),
        ({"layers": ["depht"]}, "did you mean `depth`"),
        ({"integrator": "exactly"}, "exact"),
        ({"exposure": "bright"}, "number of stops"),
        ({"tonecurve": "film"}, "expected clip"),
        ({"time": -1}, "number of seconds"),
        ({"noise": 0}, "noise: expected"),
        ({"min_spp": 0}, "at least 1"),
        ({"noise_over": "room"}, "expected `pixel` or `picture`"),
        ({"resolution": (65536, 65536)}, "too large"),
    ],
)
def test_what_cannot_be_is_said(room, options, why):
    with pytest.raises(bhs.Error, match=why):
        bhs.load(room).render(**options)


def test_arguments_of_other_kinds_are_named(room):
    scene = bhs.load(room)
    for options, why in [({"spp": "many"}, "spp"), ({"spp": 1.5}, "spp"), ({"resolution": 5}, "resolution"), ({"layers": "depth"}, "layers")]:
        with pytest.raises(TypeError, match=f"^{why}: expected"):
            scene.render(**options)


def test_a_scene_without_a_camera_can_be_traced_and_says_why_it_has_no_picture():
    scene = bhs.loads(HOLE)
    assert scene.trace([0, 0, 20], [0, 0, 1])["outcome"] == "escaped"
    with pytest.raises(bhs.Error, match="camera"):
        scene.render()


def test_what_cannot_be_written_leaves_nothing(room, tmp_path):
    picture = bhs.load(room).render()
    for name, why in [("picture.jpg", "ends in .exr or .png"), ("none/picture.exr", "none"), ("picture", "ends in")]:
        with pytest.raises(bhs.Error, match=why):
            picture.save(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["room.bhs"]


def test_stats_and_notes(room):
    picture = bhs.load(room).render()
    assert picture.spp == 4 and picture.stats["counts"]["paths"] == 40 * 30 * 4
    assert "40x30, 4 spp, redshift, normal" in repr(picture)
    with pytest.warns(bhs.SceneWarning, match="black"):
        dark = bhs.loads('LookAt 0 0 -4 0 0 0 0 1 0 Camera "perspective" WorldBegin Shape "sphere"').render(spp=1, resolution=(8, 8))
    assert any("black" in note for note in dark.notes)


def test_progress_is_told_to_the_end(room):
    told = []
    bhs.load(room).render(spp=64, progress=told.append)
    shares = [reached.share for reached in told]
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert told[-1].spp == told[-1].total_spp == 64 and told[-1].elapsed > 0 and told[-1].mray_per_second > 0


def test_what_a_callback_raises_comes_out():
    calls = []

    def stop(reached):
        calls.append(reached)
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        bhs.loads(LONG).render(progress=stop)
    assert len(calls) == 1


def test_time_ends_it():
    picture = bhs.loads(LONG).render(time=0.2)
    assert picture.stats["stopped"] == "time" and 1 <= picture.spp < 100000000


def test_tqdm_shows_a_bar(room, capsys):
    bhs.load(room).render(progress=True)
    assert "4/4 spp" in capsys.readouterr().err


def test_other_threads_go_on():
    counted = []
    over = threading.Event()

    def count():
        while not over.is_set():
            counted.append(1)
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    before = len(counted)
    bhs.loads(LONG).render(time=0.5)
    over.set()
    other.join()
    # With the interpreter held it would be none.
    assert len(counted) - before > 20


@pytest.mark.parametrize(
    "work",
    [
        f"bhs.loads({LONG!r}).render()",
        f"bhs.loads({HOLE!r}).trace(np.full((3000000, 3), 5.0), np.random.default_rng(0).normal(size=(3000000, 3)), threads=1)",
    ],
)
def test_an_interrupt_stops_the_work(work):
    program = f"import bhs, numpy as np, sys\nprint('begun', flush=True)\ntry:\n    {work}\nexcept KeyboardInterrupt:\n    print('interrupted')"
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "begun\n"
    time.sleep(1.5)
    assert child.poll() is None, "the work was over before it could be interrupted"
    os.kill(child.pid, signal.SIGINT)
    # The rest of the work would take far longer.
    said, _ = child.communicate(timeout=60)
    assert said == "interrupted\n" and child.returncode == 0
