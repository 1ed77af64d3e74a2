//! Taylor series of rays around a hole that spins and of their neighbours (`docs/physics.md`, section 5), and rays that are followed by them.

use crate::kerr::connect::bundle::{Bundle, Factors, Spin};
use crate::kerr::connect::pencil::Pencil;
use bhs_core::real::{Mask, Real};

/// The Taylor series of rays and their neighbours, of N terms, and of what they are made of. Each coefficient is written before it is read.
///
/// Those of the neighbours end after M terms: a derivative needs fewer digits than the ray.
struct Series<F, const N: usize, const D: usize, const M: usize> {
    u: [Pencil<F, D>; N],
    n: [[Pencil<F, D>; 3]; N],
    chi: [Pencil<F, D>; N],
    /// u^2, `K + 2 a^2 n_z^2`, and minus the denominator and the derivative of the twist.
    square: [Pencil<F, D>; N],
    force: [Pencil<F, D>; N],
    below: [Pencil<F, D>; N],
    rate: [Pencil<F, D>; N],
}

/// A sum of products, in parts that do not wait for one another.
#[derive(Clone, Copy)]
struct Sum<F, const D: usize> {
    v: F,
    d: [[F; 2]; D],
}

impl<F: Real, const D: usize> Sum<F, D> {
    #[inline(always)]
    fn nothing() -> Self {
        let zero = F::splat(0.0);
        Self { v: zero, d: [[zero; 2]; D] }
    }

    /// Adds the product of two numbers, and the derivatives of that if they are `wanted`.
    #[inline(always)]
    fn add(&mut self, a: &Pencil<F, D>, b: &Pencil<F, D>, wanted: bool) {
        self.v = a.v.times_plus(b.v, self.v);
        if wanted {
            for i in 0..D {
                self.d[i] = [a.d[i].times_plus(b.v, self.d[i][0]), a.v.times_plus(b.d[i], self.d[i][1])];
            }
        }
    }

    #[inline(always)]
    fn total(&self) -> Pencil<F, D> {
        let mut total = Pencil::constant(self.v);
        for i in 0..D {
            total.d[i] = self.d[i][0] + self.d[i][1];
        }
        total
    }
}

/// Coefficient number `k` of the square of a series, with its derivatives if they are `wanted`.
#[inline(always)]
fn square<F: Real, const D: usize>(a: impl Fn(usize) -> Pencil<F, D>, k: usize, wanted: bool) -> Pencil<F, D> {
    let c = F::splat;
    let half = k.div_ceil(2);
    let mut sum = Sum::nothing();
    for i in 0..half {
        sum.add(&a(i), &a(k - i), wanted);
    }
    let mut all = sum.total() * c(2.0);
    if k.is_multiple_of(2) {
        let middle = a(k / 2);
        all = all.plus(middle, middle);
    }
    all
}

impl<F: Real, const N: usize, const D: usize, const M: usize> Series<F, N, D, M> {
    #[inline(always)]
    fn nothing() -> Self {
        let zero = Pencil::constant(F::splat(0.0));
        let all = [zero; N];
        Self { u: all, n: [[zero; 3]; N], chi: all, square: all, force: all, below: all, rate: all }
    }

    /// Makes these the series of the rays that are at `at`.
    #[inline(always)]
    fn make(&mut self, factors: &Factors<F, D>, at: &Bundle<F, D>) {
        let c = F::splat;
        [self.u[0], self.u[1]] = at.u;
        [self.n[0], self.n[1]] = at.n;
        self.chi[0] = at.chi;
        let [p, q, r] = factors.of_u;
        let mut over = Pencil::constant(c(0.0));
        for k in 0..N - 2 {
            let inverse = c(1.0 / ((k + 1) * (k + 2)) as f64);
            let wanted = k + 2 < M;
            self.square[k] = square(|i| self.u[i], k, wanted);
            self.force[k] = square(|i| self.n[i][2], k, wanted) * (c(2.0) * factors.a2);
            self.below[k] = (self.u[k] * c(2.0)).plus_scaled(self.square[k], -factors.horizon);
            if k == 0 {
                self.force[0] = self.force[0] + factors.k;
                let v = c(1.0) / (c(1.0) - self.below[0].v);
                over = Pencil { v, d: self.below[0].d.map(|d| d * v * v) };
            }
            let mut cube = Sum::nothing();
            let mut pull = [Sum::nothing(); 3];
            for i in 0..=k {
                cube.add(&self.square[i], &self.u[k - i], wanted);
                for (j, pull) in pull.iter_mut().enumerate() {
                    pull.add(&self.force[i], &self.n[k - i][j], wanted);
                }
            }
            self.u[k + 2] = (p * self.u[k]).plus(q, self.square[k]).plus(r, cube.total()) * inverse;
            let mut pull = pull.map(|pull| -pull.total());
            pull[2] = pull[2].plus_scaled(self.n[k][2], factors.a2);
            self.n[k + 2] = pull.map(|pull| pull * inverse);
            let mut rest = Sum::nothing();
            for i in 1..=k {
                rest.add(&self.below[i], &self.rate[k - i], wanted);
            }
            let rate = (factors.twist[0] * self.u[k]).plus(-factors.twist[1], self.square[k]) + rest.total();
            self.rate[k] = rate * over;
            self.chi[k + 1] = self.rate[k] * c(1.0 / (k + 1) as f64);
        }
    }

    /// How far the series may be followed: errors over the numbers themselves are about `tolerance`, with `scale` for 1/r.
    #[inline(always)]
    fn length(&self, scale: F, tolerance: f64) -> F {
        let per_scale = F::splat(1.0) / scale;
        let size = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|i| self.n[k][i].v.abs());
            (self.u[k].v.abs() * per_scale).max(x).max(y.max(z)).max(self.chi[k.min(N - 2)].v.abs())
        };
        let (last, before) = (size(N - 1).to_array(), size(N - 2).to_array());
        F::from_fn(|i| root(tolerance / last[i], N as i64 - 1).min(root(tolerance / before[i], N as i64 - 2)))
    }

    /// 1/r and its derivative after the times `h`.
    #[inline(always)]
    fn radial(&self, h: F) -> [F; 2] {
        let last = self.u[N - 1].v;
        let (mut value, mut slope) = (last, last * F::splat((N - 1) as f64));
        for k in (1..N - 1).rev() {
            let c = self.u[k].v;
            value = value.times_plus(h, c);
            slope = slope.times_plus(h, c * F::splat(k as f64));
        }
        [value.times_plus(h, self.u[0].v), slope]
    }

    /// The state after the times `h`.
    #[inline(always)]
    fn at(&self, h: F, from: &Bundle<F, D>) -> Bundle<F, D> {
        let u = Self::value_and_slope(|k| &self.u[k], h);
        let [x, y, z] = [0, 1, 2].map(|j| Self::value_and_slope(|k| &self.n[k][j], h));
        let [turn, _] = horner(|k| self.chi[k].v, N - 1, h);
        let mut chi = Pencil::constant(turn);
        for j in 0..D {
            [chi.d[j], _] = horner(|k| self.chi[k].d[j], M - 1, h);
        }
        Bundle { u, n: [[x[0], y[0], z[0]], [x[1], y[1], z[1]]], chi, ..*from }
    }

    #[inline(always)]
    fn value_and_slope<'a>(c: impl Fn(usize) -> &'a Pencil<F, D>, h: F) -> [Pencil<F, D>; 2] {
        let [v, w] = horner(|k| c(k).v, N, h);
        let (mut value, mut slope) = (Pencil::constant(v), Pencil::constant(w));
        for j in 0..D {
            [value.d[j], slope.d[j]] = horner(|k| c(k).d[j], M, h);
        }
        [value, slope]
    }
}

/// The value of a polynomial of so many terms at `h`, and its slope.
#[inline(always)]
fn horner<F: Real>(c: impl Fn(usize) -> F, terms: usize, h: F) -> [F; 2] {
    let mut value = c(terms - 1);
    let mut slope = value;
    for k in (1..terms - 1).rev() {
        value = value.times_plus(h, c(k));
        slope = slope.times_plus(h, value);
    }
    [value.times_plus(h, c(0)), slope]
}

/// About the root of the given degree, not too large: a logarithm is the bits of a number, nearly.
#[inline(always)]
fn root(of: f64, degree: i64) -> f64 {
    const ONE: i64 = 1.0f64.to_bits() as i64;
    let of = if of < 1e300 { of.max(1e-300) } else { 1e300 };
    // The guess is too large by some 6 % at most.
    0.95 * f64::from_bits(((of.to_bits() as i64 - ONE) / degree + ONE) as u64)
}

/// Steps after which rays are given up.
const MOST_STEPS: u32 = 60;

/// Share of the horizon's 1/r at which a ray is given up.
const LOST: f64 = 0.999;

/// Where rays have come.
#[derive(Clone, Copy, Debug)]
pub struct Followed<F: Real, const D: usize> {
    /// With their neighbours.
    pub end: Bundle<F, D>,
    /// For how long they were followed.
    pub tau: F,
    /// Which of them were given up.
    pub lost: F::Mask,
}

/// Newton's steps to where a ray leaves.
const EXIT_STEPS: u32 = 4;

/// Follows the rays `bundle` for the times `tau`, or until their 1/r becomes less than `exit` on the way out, by series of N terms.
///
/// The series of neighbours have M terms.
pub fn follow<F: Real, const N: usize, const D: usize, const M: usize>(
    spin: &Spin<F>,
    bundle: &Bundle<F, D>,
    (tau, exit): (F, F),
    tolerance: f64,
) -> Followed<F, D> {
    let c = F::splat;
    let mut at = *bundle;
    let factors = Factors::new(spin, &at);
    let limit = c(LOST) * spin.horizon();
    let least = at.u[0].v;
    let (mut left, mut gone) = (tau, c(0.0));
    let mut lost = F::Mask::NONE;
    let mut series = Series::<F, N, D, M>::nothing();
    for _ in 0..MOST_STEPS {
        lost = lost | !at.u[0].v.lt(limit);
        let moving = left.gt(c(0.0)) & !lost;
        if !moving.any() {
            break;
        }
        series.make(&factors, &at);
        let mut h = series.length(at.u[0].v.abs().max(least), tolerance).min(left);
        h = F::select(moving, h, c(0.0));
        let [u, du] = series.radial(h);
        let leaves = moving & u.lt(exit) & du.lt(c(0.0));
        left = F::select(leaves, c(0.0), left - h);
        if leaves.any() {
            let (whole, mut u, mut du) = (h, u, du);
            for _ in 0..EXIT_STEPS {
                h = F::select(leaves & du.lt(c(0.0)), (h - (u - exit) / du).max(c(0.0)).min(whole), h);
                [u, du] = series.radial(h);
            }
        }
        at = series.at(h, &at);
        gone += h;
    }
    Followed { end: at, tau: gone, lost: lost | left.gt(c(0.0)) }
}
