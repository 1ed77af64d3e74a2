#!/usr/bin/env python3
"""Compares flat-space images of bhs with those of Mitsuba 3, block by block. See README.md beside this file.

The two scenes are stated a second time here, for Mitsuba, from the same published numbers, so that a slip in scenes/*.bhs
shows up as well as one in the renderer.
"""

import argparse
import importlib
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 8
CHANNELS = "RGB"


# ---------------------------------------------------------------------------------------------------------------- spectra

def table(path):
    """Wavelengths and values of a two-column .spd file."""
    rows = [line.split("#")[0].split() for line in path.read_text().splitlines()]
    rows = [(float(r[0]), float(r[1])) for r in rows if r]
    return [r[0] for r in rows], [r[1] for r in rows]


def spectrum(path, scale=1.0):
    """A Mitsuba spectrum that keeps its end values over 360 to 830 nm, as bhs does; Mitsuba alone has zero outside the data."""
    wavelengths, values = table(path)
    wavelengths = [359.0] + wavelengths + [831.0]
    values = [values[0]] + values + [values[-1]]
    return {
        "type": "irregular",
        "wavelengths": ", ".join(map(repr, wavelengths)),
        "values": ", ".join(repr(v * scale) for v in values),
    }


# ----------------------------------------------------------------------------------------------------------------- scenes

def mesh(folder, name, quads):
    """Quads, each split into 0-1-2 and 0-2-3, as a PLY file without vertex normals."""
    lines = ["ply", "format ascii 1.0", f"element vertex {4 * len(quads)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {2 * len(quads)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, map(float, corner))) for quad in quads for corner in quad]
    for i in range(len(quads)):
        lines += [f"3 {4 * i} {4 * i + 1} {4 * i + 2}", f"3 {4 * i} {4 * i + 2} {4 * i + 3}"]
    path = Path(folder) / f"{name}.ply"
    path.write_text("\n".join(lines) + "\n")
    return {"type": "ply", "filename": str(path), "face_normals": True}


def diffuse(reflectance):
    # Mitsuba's `diffuse` is black from behind; that of bhs and pbrt is not.
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}


def materials(spectra):
    return {
        "white": diffuse(spectrum(spectra / "cornell_white.spd")),
        "red": diffuse(spectrum(spectra / "cornell_red.spd")),
        "green": diffuse(spectrum(spectra / "cornell_green.spd")),
        "luminaire": diffuse(spectrum(spectra / "cornell_luminaire.spd")),
    }


def walls(folder, spectra, quads, lamp, scale):
    """`quads`: name -> (material, list of quads); `lamp`: a quad that faces down."""
    paint = materials(spectra)
    scene = {name: {**mesh(folder, name, q), "bsdf": paint[m]} for name, (m, q) in quads.items()}
    scene["lamp"] = {
        **mesh(folder, "lamp", [lamp]),
        "bsdf": paint["luminaire"],
        "emitter": {"type": "area", "radiance": spectrum(spectra / "cornell_light.spd", scale)},
    }
    return scene


def cornell_box(folder, spectra):
    quads = {
        "floor": ("white", [[(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]]),
        "ceiling": ("white", [[(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]]),
        "back": ("white", [[(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]]),
        "right": ("green", [[(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]]),
        "left": ("red", [[(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]]),
        "short": ("white", [
            [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)],
            [(290, 0, 114), (290, 165, 114), (240, 165, 272), (240, 0, 272)],
            [(130, 0, 65), (130, 165, 65), (290, 165, 114), (290, 0, 114)],
            [(82, 0, 225), (82, 165, 225), (130, 165, 65), (130, 0, 65)],
            [(240, 0, 272), (240, 165, 272), (82, 165, 225), (82, 0, 225)],
        ]),
        "tall": ("white", [
            [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)],
            [(423, 0, 247), (423, 330, 247), (472, 330, 406), (472, 0, 406)],
            [(472, 0, 406), (472, 330, 406), (314, 330, 456), (314, 0, 456)],
            [(314, 0, 456), (314, 330, 456), (265, 330, 296), (265, 0, 296)],
            [(265, 0, 296), (265, 330, 296), (423, 330, 247), (423, 0, 247)],
        ]),
    }
    lamp = [(343, 548.3, 227), (343, 548.3, 332), (213, 548.3, 332), (213, 548.3, 227)]
    camera = dict(origin=[278, 273, -800], target=[278, 273, 0], fov=39.3077)
    return walls(folder, spectra, quads, lamp, 4.0), camera, 6


def spheres(folder, spectra):
    quads = {
        "floor": ("white", [[(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]]),
        "ceiling": ("white", [[(-1, 1.5, -1), (1, 1.5, -1), (1, 1.5, 1), (-1, 1.5, 1)]]),
        "back": ("white", [[(-1, 0, -1), (1, 0, -1), (1, 1.5, -1), (-1, 1.5, -1)]]),
        "left": ("red", [[(-1, 0, 1), (-1, 0, -1), (-1, 1.5, -1), (-1, 1.5, 1)]]),
        "right": ("green", [[(1, 0, -1), (1, 0, 1), (1, 1.5, 1), (1, 1.5, -1)]]),
    }
    lamp = [(-0.4, 1.49, -0.3), (0.4, 1.49, -0.3), (0.4, 1.49, 0.3), (-0.4, 1.49, 0.3)]
    scene = walls(folder, spectra, quads, lamp, 1.0)
    scene["glass"] = {
        "type": "sphere", "center": [0.4, 0.3, 0.3], "radius": 0.3,
        "bsdf": {"type": "dielectric", "int_ior": 1.45, "ext_ior": 1.0},
    }
    scene["mirror"] = {
        "type": "sphere", "center": [-0.4, 0.3, -0.3], "radius": 0.3,
        "bsdf": {"type": "conductor", "material": "none"},
    }
    camera = dict(origin=[0, 0.75, 3.18], target=[0, 0.75, 0], fov=37.85)
    return scene, camera, 8


# Scene and shape of its picture (width over height).
LARGE = {"cornell_box": (cornell_box, 1.0), "spheres": (spheres, 4.0 / 3.0)}

# Small scenes, each a pair scenes/NAME.bhs and scenes/NAME.py beside this file. The latter has `ASPECT` and
# `build(peer, mi, folder, spectra)`, which gives shapes, camera and maxdepth; `peer` is this module.
SMALL_FOLDER = Path(__file__).resolve().parent / "scenes"


def small(name):
    """The function that makes a small scene for Mitsuba, as those above are, and the shape of its picture."""
    sys.path.insert(0, str(SMALL_FOLDER))
    module = importlib.import_module(name)
    sys.path.pop(0)

    def build(folder, spectra):
        import mitsuba
        return module.build(sys.modules[__name__], mitsuba, folder, spectra)

    return build, module.ASPECT


SMALL = sorted(path.stem for path in SMALL_FOLDER.glob("*.py") if path.stem not in {"stage"})
SCENES = [*LARGE, *SMALL]


def scene_file(name):
    return (SMALL_FOLDER if name in SMALL else ROOT / "scenes") / f"{name}.bhs"


def mitsuba_scene(mi, shapes, camera, maxdepth, film, rr_depth=100_000):
    """A scene for Mitsuba. `rr_depth`: the first path segment that roulette may be played for; the default is never."""
    return mi.load_dict({
        "type": "scene",
        # bhs (as pbrt) counts bounces, Mitsuba path segments.
        "integrator": {"type": "path", "max_depth": maxdepth + 1, "rr_depth": rr_depth},
        "sensor": {
            "type": "perspective",
            "fov": camera["fov"],
            "fov_axis": "smaller",
            "near_clip": 1e-3,
            "far_clip": 1e5,
            "to_world": mi.ScalarTransform4f().look_at(origin=camera["origin"], target=camera["target"], up=[0, 1, 0]),
            "sampler": {"type": "independent"},
            "film": film,
        },
        **shapes,
    })


# -------------------------------------------------------------------------------------------------------------- rendering

# Linear sRGB of CIE XYZ (the primaries of IEC 61966-2-1 and the white of the table of D65, as in plugins/colour).
SRGB_FROM_XYZ = np.array([[3.240444, -1.537134, -0.498530], [-0.969267, 1.876012, 0.041556], [0.055644, -0.204026, 1.057227]])


class SameObserver:
    """Mitsuba records X, Y and Z through the colour-matching functions that bhs has: the CIE's table in steps of 1 nm."""

    def __init__(self, mi, spectra):
        rows = [line.split(",") for line in (ROOT / "plugins/colour/data/cie1931_2deg_1nm.csv").read_text().splitlines()]
        self.table = np.array([[float(x) for x in row] for row in rows if row[0].isdigit()])
        self.y_integral = self.table[:, 2].sum()

    def film(self, width, height):
        first, last = self.table[0, 0], self.table[-1, 0]
        bands = {
            f"band{k}_{name}": {"type": "regular", "wavelength_min": float(first), "wavelength_max": float(last),
                                "values": ", ".join(map(repr, map(float, self.table[:, k])))}
            for k, name in ((1, "x"), (2, "y"), (3, "z"))
        }
        return {"type": "specfilm", "width": width, "height": height, "component_format": "float32", "rfilter": {"type": "box"}, **bands}

    def rgb(self, image):
        return np.array(image, dtype=np.float64) / self.y_integral @ SRGB_FROM_XYZ.T

    def y_bar(self, wavelengths):
        return np.interp(wavelengths, self.table[:, 0], self.table[:, 2])


class MitsubaObserver:
    """Mitsuba's own RGB film: the CIE's table in steps of 5 nm."""

    def __init__(self, mi, spectra):
        self.mi = mi
        # It divides by 106.75026 where the integral of its y-bar is 106.85703: radiance 1 would get Y = 1.0010.
        integral = self.y_bar((np.arange(360 * 4, 830 * 4) + 0.5) / 4).sum() / 4
        self.scale = 1.0 / (mi.MI_CIE_Y_NORMALIZATION * integral)

    def film(self, width, height):
        return {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32",
                "rfilter": {"type": "box"}}

    def rgb(self, image):
        return self.scale * np.array(image, dtype=np.float64)

    def y_bar(self, wavelengths):
        # An array of one number each in the variants that compile.
        return np.array([np.ravel(np.array(self.mi.cie1931_y(float(w))))[0] for w in wavelengths], dtype=np.float64)


OBSERVERS = {"same": SameObserver, "mitsuba": MitsubaObserver}


def check_radiance(mi, spectra, observer):
    """An emitter seen head-on must show its own radiance, for a constant and for the lamp's spectrum."""
    lamp = spectrum(spectra / "cornell_light.spd")
    wavelengths = [float(w) for w in lamp["wavelengths"].split(",")]
    values = [float(v) for v in lamp["values"].split(",")]
    grid = (np.arange(360 * 4, 830 * 4) + 0.5) / 4
    y_bar = observer.y_bar(grid)
    cases = {
        "radiance 1": ({"type": "irregular", "wavelengths": "359, 831", "values": "1, 1"}, 1.0),
        "cornell-light": (lamp, float((np.interp(grid, wavelengths, values) * y_bar).sum() / y_bar.sum())),
    }
    worst = 0.0
    print(f"Mitsuba {mi.__version__}, {mi.variant()}, {type(observer).__name__}")
    for name, (radiance, expected) in cases.items():
        shapes = {"wall": {"type": "rectangle", "emitter": {"type": "area", "radiance": radiance}}}
        scene = mitsuba_scene(mi, shapes, dict(origin=[0, 0, 1], target=[0, 0, 0], fov=20), 1, observer.film(32, 32))
        rgb = observer.rgb(mi.render(scene, spp=2048)).mean(axis=(0, 1))
        y = float(rgb @ np.linalg.inv(SRGB_FROM_XYZ)[1])
        print(f"check: {name}: R G B = {rgb[0]:.4f} {rgb[1]:.4f} {rgb[2]:.4f}, Y = {y:.5f}, expected {expected:.5f}")
        worst = max(worst, abs(y / expected - 1.0))
    return worst


def render_mitsuba(mi, scene, observer, spp, seed):
    return observer.rgb(mi.render(scene, spp=spp, seed=seed))


def render_bhs(mi, program, scene_file, size, spp, seed, threads, folder):
    out = Path(folder) / f"bhs_{seed}.exr"
    command = [str(program), "render", str(scene_file), "-o", str(out), "--spp", str(spp), "--seed", str(seed),
               "--resolution", f"{size[0]}x{size[1]}", "--quiet"]
    if threads:
        command += ["--threads", str(threads)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nfailed with {done.returncode}:\n{done.stdout}{done.stderr}")
    bitmap = mi.Bitmap(str(out)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap)


def blocks(image):
    """Means of the 8 x 8 blocks."""
    h, w, c = image.shape
    return image.astype(np.float64).reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, c).mean(axis=(1, 3))


def mean_and_error(samples):
    stack = np.stack(samples)
    return stack.mean(axis=0), stack.std(axis=0, ddof=1) / math.sqrt(len(samples))


# ------------------------------------------------------------------------------------------------------------- comparison

def student_limit(freedom, probability):
    """The |t| that Student's distribution exceeds with the given (two-sided) probability."""
    # With t = sqrt(freedom) tan(x), the density is cos(x)^(freedom - 1).
    x = (np.arange(1_000_000) + 0.5) * (math.pi / 2 / 1_000_000)
    tail = np.cumsum((np.cos(x) ** (freedom - 1))[::-1])[::-1]
    return math.sqrt(freedom) * math.tan(x[np.searchsorted(-tail, -probability * tail[0])])


def compare(name, ours, theirs, tolerance, chance):
    """Block statistics. A block passes when it deviates by at most `tolerance`, or by no more than noise explains beyond that;
    `chance` is the probability that noise alone makes any block of the picture fail."""
    limit = student_limit(2 * len(ours) - 2, chance / (3 * ours[0].shape[0] * ours[0].shape[1]))
    (a, sa), (b, sb) = mean_and_error(ours), mean_and_error(theirs)
    error = np.sqrt(sa**2 + sb**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Blocks that are black in both renderers agree; a negative channel (outside sRGB) is measured by its size.
        relative = np.where((a == b), 0.0, (a - b) / np.abs(b))
        noise = np.where(error == 0.0, 0.0, error / np.abs(b))
        z = np.where(error == 0.0, 0.0, (a - b) / error)
    # Next to nothing beside the picture's mean: a relative deviation means nothing there.
    dark = np.abs(b) < 1e-3 * b.mean()
    rows = []
    for k, channel in enumerate(CHANNELS):
        use = ~dark[..., k]
        d, s, zz = relative[..., k][use], noise[..., k][use], z[..., k][use]
        worst = np.unravel_index(np.argmax(np.where(use, np.abs(relative[..., k]), -1.0)), use.shape)
        resolved = 3.0 * s < tolerance
        failed = np.abs(d) > tolerance + limit * s
        # An over-all test that does not care for the noise of single blocks.
        mean_a, mean_b = a[..., k].mean(), b[..., k].mean()
        total = [np.mean([im[..., k].mean() for im in images]) for images in (ours, theirs)]
        total_error = [np.std([im[..., k].mean() for im in images], ddof=1) / math.sqrt(len(images)) for images in (ours, theirs)]
        rows.append({
            "channel": channel,
            "blocks": int(use.size),
            "dark": int((~use).sum()),
            "mean_bhs": float(mean_a),
            "mean_mitsuba": float(mean_b),
            "mean_ratio": float(mean_a / mean_b),
            "mean_ratio_error": float(math.hypot(total_error[0] / total[0], total_error[1] / total[1])),
            "largest": float(np.abs(d).max()),
            "largest_at_pixel": [int(worst[1]) * BLOCK, int(worst[0]) * BLOCK],
            "largest_z": float(z[..., k][worst]),
            "quantiles": {q: float(np.quantile(np.abs(d), float(q))) for q in ("0.5", "0.9", "0.99")},
            "mean_deviation": float(d.mean()),
            "median_noise": float(np.median(s)),
            "within_tolerance": float((np.abs(d) <= tolerance).mean()),
            "resolved": int(resolved.sum()),
            "resolved_within_tolerance": float((np.abs(d[resolved]) <= tolerance).mean()) if resolved.any() else None,
            "z_rms": float(np.sqrt((zz**2).mean())),
            "z_mean": float(zz.mean()),
            "z_largest": float(np.abs(zz).max()),
            "failed": int(failed.sum()),
        })
    return {"scene": name, "limit": limit, "pass": all(r["failed"] == 0 for r in rows), "channels": rows}, relative, z


def report(result):
    print(f"\n{result['scene']}: {result['width']} x {result['height']}, {result['seeds']} seeds of {result['spp_bhs']} (bhs) and "
          f"{result['spp_mitsuba']} (Mitsuba) samples a pixel")
    print("       mean ratio            |deviation| of 8x8 blocks          noise    within   resolved blocks    z        blocks")
    print("       bhs / Mitsuba         median    90 %    99 %     max     median     1 %   count within 1 %   rms   max  failed")
    for r in result["channels"]:
        q = r["quantiles"]
        inside = r["resolved_within_tolerance"]
        inside = "      -" if inside is None else f"{100 * inside:6.2f}%"
        print(f"  {r['channel']}  {r['mean_ratio']:.5f} +- {r['mean_ratio_error']:.5f}   {100 * q['0.5']:5.2f}%  {100 * q['0.9']:5.2f}%  "
              f"{100 * q['0.99']:5.2f}%  {100 * r['largest']:6.2f}%   {100 * r['median_noise']:5.2f}%  {100 * r['within_tolerance']:5.1f}%  "
              f"{r['resolved']:5d}   {inside}    {r['z_rms']:5.2f} {r['z_largest']:5.1f}  {r['failed']:4d} of {r['blocks'] - r['dark']}")
    n = result["seeds"]
    expected = math.sqrt((2 * n - 2) / (2 * n - 4)) if n > 2 else float("inf")
    print(f"  z rms of two renderers that agree: about {expected:.2f} (Student, {2 * n - 2} degrees of freedom); a block fails that deviates by "
          f"more than {100 * result['tolerance']:g} % + {result['limit']:.1f} standard errors")
    print("  PASS" if result["pass"] else "  FAIL")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", choices=SCENES, action="append", help="default: all")
    parser.add_argument("--variant", default="scalar_spectral", help="Mitsuba's variant, e.g. llvm_ad_spectral (default: %(default)s)")
    parser.add_argument("--observer", choices=list(OBSERVERS), default="same", help="Mitsuba's colour-matching functions: "
                        "those of bhs (1 nm), or its own (5 nm) (default: %(default)s)")
    parser.add_argument("--bhs", type=Path, default=ROOT / "bhs", help="the program (default: %(default)s)")
    parser.add_argument("--spectra", type=Path, default=ROOT / "plugins/spectra/data", help="folder of the spectra (default: %(default)s)")
    parser.add_argument("--height", type=int, default=192, help="of the picture [pixels], a multiple of 24 (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=8, help="independent renders by each program (default: %(default)s)")
    parser.add_argument("--spp", type=int, default=256, help="samples a pixel in each render (default: %(default)s)")
    parser.add_argument("--spp-mitsuba", type=int, help="the same for Mitsuba, if different")
    parser.add_argument("--tolerance", type=float, default=0.01, help="allowed deviation of a block (default: %(default)s)")
    parser.add_argument("--chance", type=float, default=0.01, help="that noise alone fails a picture (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=0, help="threads for each program (default: all)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--keep", type=Path, help="write both pictures, and the blocks' deviations and z, as EXR into this folder")
    parser.add_argument("--mitsuba-only", action="store_true", help="check Mitsuba against itself (two sets of seeds) without bhs")
    options = parser.parse_args()
    if options.height % 24:
        parser.error("--height must be a multiple of 24")

    import mitsuba as mi
    mi.set_variant(options.variant)
    if options.threads:
        import drjit
        drjit.set_thread_count(max(2, options.threads))  # with one alone it never ends to read an EXR file

    observer = OBSERVERS[options.observer](mi, options.spectra)
    radiance_error = check_radiance(mi, options.spectra, observer)
    results = []
    for name in options.scene or SCENES:
        build, aspect = LARGE[name] if name in LARGE else small(name)
        size = (round(options.height * aspect), options.height)
        spp_mitsuba = options.spp_mitsuba or options.spp
        with tempfile.TemporaryDirectory() as folder:
            scene = mitsuba_scene(mi, *build(folder, options.spectra), observer.film(*size))
            start = time.time()
            theirs = [render_mitsuba(mi, scene, observer, spp_mitsuba, 1 + i) for i in range(options.seeds)]
            time_theirs = time.time() - start
            start = time.time()
            if options.mitsuba_only:
                ours = [render_mitsuba(mi, scene, observer, options.spp, 1001 + i) for i in range(options.seeds)]
            else:
                ours = [render_bhs(mi, options.bhs, scene_file(name), size, options.spp, 1 + i, options.threads, folder)
                        for i in range(options.seeds)]
            time_ours = time.time() - start
        result, relative, z = compare(name, [blocks(im) for im in ours], [blocks(im) for im in theirs], options.tolerance, options.chance)
        result.update(mitsuba_only=options.mitsuba_only, width=size[0], height=size[1], seeds=options.seeds, spp_bhs=options.spp, spp_mitsuba=spp_mitsuba,
                      seconds_bhs=time_ours, seconds_mitsuba=time_theirs, mitsuba=mi.__version__, variant=options.variant, observer=options.observer,
                      radiance_check=radiance_error, tolerance=options.tolerance, chance=options.chance)
        report(result)
        print(f"  seconds: bhs {time_ours:.1f}, Mitsuba {time_theirs:.1f}", flush=True)
        results.append(result)
        if options.keep:
            options.keep.mkdir(parents=True, exist_ok=True)
            pictures = {"bhs": np.mean(ours, axis=0), "mitsuba": np.mean(theirs, axis=0), "deviation": relative, "z": z}
            for kind, picture in pictures.items():
                mi.Bitmap(picture.astype(np.float32)).write(str(options.keep / f"{name}_{kind}.exr"))
            for kind in ("bhs", "mitsuba"):
                mi.util.write_bitmap(str(options.keep / f"{name}_{kind}.png"), mi.Bitmap(pictures[kind].astype(np.float32)))
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")
    sys.exit(0 if all(r["pass"] for r in results) and radiance_error < 2e-3 else 1)


if __name__ == "__main__":
    main()
