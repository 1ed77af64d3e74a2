"""Spectra, transforms and the map of the sky of pbrt-v4, from its documentation: for pbrt_mitsuba.py."""

import math
import os

import numpy as np

from pbrt_text import NotStated

GRID = np.arange(360, 831)  # nm


def table(wavelengths, values):
    """A Mitsuba spectrum of a table."""
    if not np.ptp(values):
        return {"type": "uniform", "value": float(values[0])}
    join = lambda v: ", ".join(repr(float(x)) for x in v)
    return {"type": "irregular", "wavelengths": join(wavelengths), "values": join(values)}


class Spectra:
    """Colours and tables as numbers at every nanometre, with pbrt's meaning."""

    def __init__(self, mi, root, observer):
        self.mi, self.data, self.root = mi, root / "plugins/spectra/data", root
        self.y_bar = observer.y_bar(GRID)
        rows = [line.split(",") for line in (root / "plugins/colour/data/cie_d65_5nm.csv").read_text().splitlines()]
        rows = np.array([[float(x) for x in r] for r in rows if r[0][:1].isdigit()])
        self.d65 = self.of_luminance_1(np.interp(GRID, rows[:, 0], rows[:, 1]))

    def luminance(self, values):
        return float((values * self.y_bar).sum() / self.y_bar.sum())

    def of_luminance_1(self, values):
        return values / self.luminance(values)

    def sigmoid(self, rgb):
        """The smooth spectrum of a colour from 0 to 1 (Jakob and Hanika 2019)."""
        if rgb[0] == rgb[1] == rgb[2]:
            return np.full(GRID.shape, float(rgb[0]))
        c = np.ravel(np.array(self.mi.srgb_model_fetch([float(v) for v in rgb])))
        x = (c[0] * GRID + c[1]) * GRID + c[2]
        return 0.5 + 0.5 * x / np.sqrt(1 + x * x)

    def unbounded(self, rgb):
        most = 2 * max(rgb)
        return most * self.sigmoid([v / most for v in rgb]) if most > 0 else np.zeros(GRID.shape)

    def file(self, path):
        rows = [line.split("#")[0].replace(",", " ").split() for line in open(path)]
        return np.array([[float(x) for x in r[:2]] for r in rows if r])

    def named(self, name):
        metal, part = name.split("-")[1:3] if name.count("-") == 2 else ("", "")
        path = self.data / f"{metal}_pbrt_v4.csv"
        if not path.exists():
            raise NotStated(f"the spectrum {name}")
        rows = [line.split(",") for line in path.read_text().splitlines()]
        rows = np.array([[float(x) for x in r] for r in rows if r[0][:1].isdigit()])
        return np.interp(GRID, rows[:, 0], rows[:, 1 if part == "eta" else 2], 0, 0)

    def number(self, d, name, default, folder, share=False):
        """A spectrum that is no light: `share` where it is a reflectance."""
        kind, values = d.params.get(name, (None, default))
        if kind == "rgb":
            return self.sigmoid(np.clip(values, 0, 1)) if share else self.unbounded(values)
        if isinstance(values, str) or isinstance(values[0], str):
            word = values if isinstance(values, str) else values[0]
            if word.startswith(("metal-", "glass-")):
                return self.named(word)
            rows = self.file(os.path.join(folder, word))
            return np.interp(GRID, rows[:, 0], rows[:, 1], 0, 0)
        if len(values) == 1:
            return np.full(GRID.shape, float(values[0]))
        return np.interp(GRID, values[0::2], values[1::2], 0, 0)

    def light(self, d, name, folder):
        """What a light emits, and the luminance that pbrt makes it: 1, and that of the colour for one given by red, green and blue."""
        kind, values = d.params.get(name, ("rgb", [1, 1, 1]))
        if kind == "rgb":
            return self.unbounded(values) * self.d65
        if kind == "blackbody":
            metres = GRID * 1e-9
            return self.of_luminance_1(1 / (metres**5 * (np.exp(0.014387768775 / (metres * values[0])) - 1)) * 1e-30)
        return self.of_luminance_1(self.number(d, name, [1], folder))


def matrix(args):
    return np.array(args, dtype=float).reshape(4, 4).T


def look_at(eye, at, up):
    eye, at, up = map(np.asarray, (eye, at, up))
    d = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(up / np.linalg.norm(up), d)
    right /= np.linalg.norm(right)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = right, np.cross(d, right), d, eye
    return np.linalg.inv(m)


def rotate(angle, axis):
    a, t = np.asarray(axis) / np.linalg.norm(axis), math.radians(angle)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    m = np.eye(4)
    m[:3, :3] = np.eye(3) + math.sin(t) * k + (1 - math.cos(t)) * k @ k
    return m


def diagonal(*values):
    return np.diag([*values, 1.0])


def translation(x, y, z):
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def square_from_sphere(d):
    """pbrt's equal-area octahedral map: the place in the unit square of a direction (Clarberg 2008, as in pbrt-v4)."""
    x, y, z = np.abs(d)
    r = np.sqrt(np.maximum(0, 1 - z))
    a, b = np.maximum(x, y), np.minimum(x, y)
    phi = np.arctan2(b, a) * 2 / math.pi
    phi = np.where(x < y, 1 - phi, phi)
    v = phi * r
    u = r - v
    u, v = np.where(d[2] < 0, 1 - v, u), np.where(d[2] < 0, 1 - u, v)
    return (np.copysign(u, d[0]) + 1) / 2, (np.copysign(v, d[1]) + 1) / 2


def fresnel(cosine, eta):
    """What an interface reflects of light that comes with `cosine`, to an index `eta` over that of its own side."""
    below = np.sqrt(np.maximum(0, 1 - (1 - cosine**2) / eta**2))
    parallel, perpendicular = (eta * cosine - below) / (eta * cosine + below), (cosine - eta * below) / (cosine + eta * below)
    return np.where(below > 0, (parallel**2 + perpendicular**2) / 2, 1.0), below


def under_coat(share, eta, thickness):
    """The reflectance under Mitsuba's clear coat that reflects as `share` does under pbrt's, which takes light away: exp(-thickness) straight across.

    On its way in and out light loses nearly as much in all directions (for 0.01 and an index of 1.5 from 1 to 1.33 %), and the mean stands for them."""
    c = (np.arange(4000) + 0.5) / 4000
    reflected, below = fresnel(c, eta)
    crossing = ((1 - reflected) * np.exp(-thickness / below) * c).sum() / ((1 - reflected) * c).sum()
    to_and_fro = 2 * (fresnel(c, 1 / eta)[0] * np.exp(-2 * thickness / c) * c).mean()
    whole = crossing**2 * share / (1 - share * to_and_fro)
    # Mitsuba's fit of the inner reflectance.
    x = 1 / eta
    return whole / (1 + whole * (-1.4399 * x**2 + 0.7099 * x + 0.6681 + 0.0636 / x))
