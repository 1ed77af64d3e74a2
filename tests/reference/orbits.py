#!/usr/bin/env python3
"""Reference orbits of light around a Schwarzschild hole, to 30 digits, for the tests of plugins/integrators.

    python3 -m venv .venv && .venv/bin/pip install mpmath==1.4.1
    .venv/bin/python tests/reference/orbits.py          # rewrites orbits.csv and ends.csv beside this file

With w = rs u, u(phi) = 1/r: w'^2 = w^3 - w^2 + E, E = (rs/b)^2. The orbit is written in Jacobi's elliptic functions, one
formula for each arrangement of the cubic's roots; the phase comes from Legendre's integral F. The renderer's own closed form
uses Weierstrass' function and the addition theorem instead, so the two share nothing but the equation. Every orbit is also
integrated with Taylor series of order 60 from its start to the middle of its table, as a check of this script.

The initial values are doubles, and enter exactly: every digit of a row follows from the bits of rs, u0 and du0.
"""

import csv
import os
import random

from mpmath import acos, asin, ellipf, ellipfun, ellipk, im, mp, mpf, nstr, polyroots, re, sqrt

mp.dps = 80


class Orbit:
    """The orbit w(phi) with w(0) = rs u0 and w'(0) = rs du0."""

    def __init__(self, rs, u0, du0):
        self.rs = mpf(rs)
        w0, v = self.rs * mpf(u0), self.rs * mpf(du0)
        energy = v * v + w0**2 - w0**3
        roots = polyroots([1, -1, 0, energy], maxsteps=500, extraprec=1000)
        if energy < mpf(4) / 27:
            w1, w2, w3 = sorted(re(x) for x in roots)
            self.k, self.m = sqrt(w3 - w1) / 2, (w2 - w1) / (w3 - w1)
            period = 2 * ellipk(self.m)
            if w0 < (w2 + w3) / 2:
                # Outside the photon sphere: w = w1 + (w2 - w1) sn^2, from w1 through the periapsis at K back to w1 at 2K.
                self.kind, self.roots = "outside", (w1, w2)
                inverse = lambda w: ellipf(asin(sqrt(min((w - w1) / (w2 - w1), mpf(1)))), self.m)
                self.phase = inverse(w0) if v >= 0 else period - inverse(w0)
                self.fate, self.end_phase = "escaped", period - inverse(mpf(0))
            else:
                # Trapped inside it: w = w1 + (w3 - w1) / sn^2, from infinity over w3 at K back to infinity at 2K.
                self.kind, self.roots = "inside", (w1, w3)
                inverse = lambda w: ellipf(asin(sqrt(min((w3 - w1) / (w - w1), mpf(1)))), self.m)
                self.phase = period - inverse(w0) if v > 0 else inverse(w0)
                self.fate, self.end_phase = "captured", period - inverse(mpf(1))
        else:
            # Through the photon sphere: w = w1 + A (1 + cn) / (1 - cn), from infinity over w1 at 2K back to infinity at 4K.
            w1 = min((abs(im(x)), re(x)) for x in roots)[1]
            a = sqrt(3 * w1 * w1 - 2 * w1)
            self.kind, self.roots = "through", (w1, a)
            self.k, self.m = sqrt(a), mpf(1) / 2 + ((1 - w1) / 2 - w1) / (2 * a)
            inverse = lambda w: ellipf(acos((w - w1 - a) / (w - w1 + a)), self.m)
            period = 4 * ellipk(self.m)
            self.phase = period - inverse(w0) if v > 0 else inverse(w0)
            self.fate = "captured" if v > 0 else "escaped"
            self.end_phase = period - inverse(mpf(1)) if v > 0 else inverse(mpf(0))

    def end(self):
        """The angle at which the orbit reaches the horizon (w = 1) or infinity (w = 0)."""
        return (self.end_phase - self.phase) / self.k

    def at(self, phi):
        """(u, u') at the angle phi."""
        t = self.phase + self.k * mpf(phi)
        sn, cn, dn = (ellipfun(name, t, m=self.m) for name in ("sn", "cn", "dn"))
        if self.kind == "outside":
            w1, w2 = self.roots
            w, dw = w1 + (w2 - w1) * sn**2, 2 * (w2 - w1) * self.k * sn * cn * dn
        elif self.kind == "inside":
            w1, w3 = self.roots
            w, dw = w1 + (w3 - w1) / sn**2, -2 * (w3 - w1) * self.k * cn * dn / sn**3
        else:
            w1, a = self.roots
            w, dw = w1 + a * (1 + cn) / (1 - cn), -2 * a * self.k * sn * dn / (1 - cn) ** 2
        return w / self.rs, dw / self.rs


def by_taylor_series(rs, u0, du0, phi, order=60):
    """(u, u') at phi by steps of Taylor series."""
    rs, u, du, left = mpf(rs), mpf(u0), mpf(du0), mpf(phi)
    while left > 0:
        c = [u, du]
        for n in range(order):
            square = sum(c[i] * c[n - i] for i in range(n + 1))
            c.append((mpf(3) / 2 * rs * square - c[n]) / ((n + 1) * (n + 2)))
        size = abs(u) + abs(du)
        # The last two, for one of them is zero where the orbit is symmetric.
        h = min(left, (mpf(10) ** -60 * size / max(abs(c[-1]), abs(c[-2]))) ** (mpf(1) / order))
        u, du = sum(x * h**i for i, x in enumerate(c)), sum(i * x * h ** (i - 1) for i, x in enumerate(c) if i)
        left -= h
    return u, du


def with_b(rs, r0, b, side):
    """(rs, u0, du0) of a ray at r0 with the impact parameter b, going in (side 1) or out (side -1)."""
    u0 = float(1 / mpf(r0))
    return float(rs), u0, float(side * sqrt(1 / mpf(b) ** 2 - mpf(u0) ** 2 + mpf(rs) * mpf(u0) ** 3))


def with_angle(rs, r0, alpha):
    """(rs, u0, du0) of a ray at r0 that makes the chart angle alpha with the outward radius."""
    return float(rs), float(1 / mpf(r0)), float(-1 / (mp.tan(mpf(alpha)) * mpf(r0)))


def starts():
    """Yields (regime, (rs, u0, du0))."""
    dice = random.Random(1919)
    critical = 3 * sqrt(mpf(3)) / 2
    for rs in ("0.1", "1", "37"):
        for ratio in ("1.2", "2", "3", "10", "100"):
            for _ in range(2):
                alpha = dice.uniform(0.02, 3.12)
                yield "ordinary", with_angle(rs, mpf(rs) * mpf(ratio), alpha)
    for rs in ("1e-12", "1e-6", "1e-3"):
        for r0, alpha in (("1", 2.0), ("50", 3.1), ("0.3", 0.4)):
            yield "weak", with_angle(rs, r0, alpha)
    for r0 in ("1.0001", "2", "1e6"):
        for sine in ("1e-3", "1e-6", "1e-9", "1e-12"):
            yield "radial-in", with_angle("1", r0, mp.pi - asin(mpf(sine)))
            yield "radial-out", with_angle("1", r0, asin(mpf(sine)))
    for power in (3, 6, 9, 12):
        off = mpf(10) ** -power
        for r0 in ("3", "1000", "1e6"):
            yield "critical-escapes", with_b("1", r0, critical * (1 + off), 1)
            yield "critical-captured", with_b("1", r0, critical * (1 - off), 1)
        for r0 in ("1.0001", "1.3"):
            yield "critical-from-inside", with_b("1", r0, critical * (1 - off), -1)
            yield "critical-trapped", with_b("1", r0, critical * (1 + off), -1)
    for alpha in (0.05, 0.4, 1.2, 1.9, 3.0):
        yield "horizon", with_angle("1", "1.0001", alpha)
        yield "horizon", with_angle("0.02", "0.020002", alpha)
        yield "inside", with_angle("0.5", "0.6", alpha)
    for b in ("2.7", "3", "5", "100", "1e4"):
        yield "far", with_b("1", "1e6", b, 1)
    for tilt in ("0", "1e-12", "-1e-12", "1e-6", "-1e-6"):
        yield "photon-sphere", (1.0, float(mpf(2) / 3), float(tilt))
        yield "photon-sphere", (1.0, float(mpf(2) / 3 * (1 + mpf("1e-9"))), float(tilt))


def main():
    """Writes the two tables."""
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, "orbits.csv"), "w", newline="") as states, \
            open(os.path.join(folder, "ends.csv"), "w", newline="") as ends:
        table, end_table = (csv.writer(f, lineterminator="\n") for f in (states, ends))
        table.writerow(["regime", "rs", "u0", "du0", "phi", "u", "du"])
        end_table.writerow(["regime", "rs", "u0", "du0", "fate", "phi"])
        worst = mpf(0)
        for regime, start in starts():
            orbit, numbers = Orbit(*start), [repr(x) for x in start]
            end = orbit.end()
            assert end > 0, (regime, start, end)
            end_table.writerow([regime, *numbers, orbit.fate, nstr(end, 20)])
            for fraction in (0.03, 0.25, 0.5, 0.75, 0.93, 0.999):
                phi = float(fraction * end)
                u, du = orbit.at(phi)
                table.writerow([regime, *numbers, repr(phi), nstr(u, 30), nstr(du, 30)])
                if fraction == 0.5:
                    series = by_taylor_series(*start, phi)
                    worst = max(worst, abs(series[0] / u - 1), abs(series[1] - du) / (abs(du) + abs(u)))
        print("largest relative difference to Taylor series:", nstr(worst, 3))
        assert worst < mpf(10) ** -30


if __name__ == "__main__":
    main()
