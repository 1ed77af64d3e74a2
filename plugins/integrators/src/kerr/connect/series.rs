//! Taylor series of rays around a hole that spins and of their neighbours (`docs/physics.md`, section 5), and rays that are followed by them.

use crate::kerr::connect::bundle::{Bundle, Factors, Spin};
use crate::kerr::connect::pencil::Pencil;
use bhs_core::real::{Mask, Real};

/// The Taylor series of rays and their neighbours, of N terms, and of what they are made of. Each coefficient is written before it is read.
struct Series<F, const N: usize> {
    u: [Pencil<F>; N],
    n: [[Pencil<F>; 3]; N],
    chi: [Pencil<F>; N],
    /// u^2, `K + 2 a^2 n_z^2`, and minus the denominator and the derivative of the twist.
    square: [Pencil<F>; N],
    force: [Pencil<F>; N],
    below: [Pencil<F>; N],
    rate: [Pencil<F>; N],
}

/// A sum of products, in parts that do not wait for one another.
#[derive(Clone, Copy)]
struct Sum<F> {
    v: F,
    d: [[F; 2]; 2],
}

impl<F: Real> Sum<F> {
    #[inline(always)]
    fn of(a: &Pencil<F>, b: &Pencil<F>) -> Self {
        Self { v: a.v * b.v, d: [[a.d[0] * b.v, a.v * b.d[0]], [a.d[1] * b.v, a.v * b.d[1]]] }
    }

    #[inline(always)]
    fn add(&mut self, a: &Pencil<F>, b: &Pencil<F>) {
        self.v = a.v.fma(b.v, self.v);
        for i in 0..2 {
            self.d[i] = [a.d[i].fma(b.v, self.d[i][0]), a.v.fma(b.d[i], self.d[i][1])];
        }
    }

    #[inline(always)]
    fn total(&self) -> Pencil<F> {
        Pencil { v: self.v, d: self.d.map(|[a, b]| a + b) }
    }
}

/// Coefficient number `k` of the square of a series.
#[inline(always)]
fn square<F: Real>(a: impl Fn(usize) -> Pencil<F>, k: usize) -> Pencil<F> {
    let c = F::splat;
    let half = k.div_ceil(2);
    let mut sum = Sum { v: c(0.0), d: [[c(0.0); 2]; 2] };
    for i in 0..half {
        sum.add(&a(i), &a(k - i));
    }
    let mut all = sum.total() * c(2.0);
    if k.is_multiple_of(2) {
        let middle = a(k / 2);
        all = all.plus(middle, middle);
    }
    all
}

impl<F: Real, const N: usize> Series<F, N> {
    fn nothing() -> Self {
        let zero = Pencil::constant(F::splat(0.0));
        let all = [zero; N];
        Self { u: all, n: [[zero; 3]; N], chi: all, square: all, force: all, below: all, rate: all }
    }

    /// Makes these the series of the rays that are at `at`.
    #[inline(always)]
    fn make(&mut self, factors: &Factors<F>, at: &Bundle<F>) {
        let c = F::splat;
        [self.u[0], self.u[1]] = at.u;
        [self.n[0], self.n[1]] = at.n;
        self.chi[0] = at.chi;
        let [p, q, r] = factors.of_u;
        let mut over = Pencil::constant(c(0.0));
        for k in 0..N - 2 {
            let inverse = c(1.0 / ((k + 1) * (k + 2)) as f64);
            self.square[k] = square(|i| self.u[i], k);
            self.force[k] = square(|i| self.n[i][2], k) * (c(2.0) * factors.a2);
            self.below[k] = (self.u[k] * c(2.0)).plus_scaled(self.square[k], -factors.horizon);
            if k == 0 {
                self.force[0] = self.force[0] + factors.k;
                let v = c(1.0) / (c(1.0) - self.below[0].v);
                over = Pencil { v, d: self.below[0].d.map(|d| d * v * v) };
            }
            let mut cube = Sum::of(&self.square[0], &self.u[k]);
            let mut pull = [0, 1, 2].map(|j| Sum::of(&self.force[0], &self.n[k][j]));
            for i in 1..=k {
                cube.add(&self.square[i], &self.u[k - i]);
                for (j, pull) in pull.iter_mut().enumerate() {
                    pull.add(&self.force[i], &self.n[k - i][j]);
                }
            }
            self.u[k + 2] = (p * self.u[k]).plus(q, self.square[k]).plus(r, cube.total()) * inverse;
            let mut pull = pull.map(|pull| -pull.total());
            pull[2] = pull[2].plus_scaled(self.n[k][2], factors.a2);
            self.n[k + 2] = pull.map(|pull| pull * inverse);
            let mut rate = (factors.twist[0] * self.u[k]).plus(-factors.twist[1], self.square[k]);
            if k > 0 {
                let mut rest = Sum::of(&self.below[1], &self.rate[k - 1]);
                for i in 2..=k {
                    rest.add(&self.below[i], &self.rate[k - i]);
                }
                rate = rate + rest.total();
            }
            self.rate[k] = rate * over;
            self.chi[k + 1] = self.rate[k] * c(1.0 / (k + 1) as f64);
        }
    }

    /// How far the series may be followed: errors over the numbers themselves are about `tolerance`, with `scale` for 1/r.
    #[inline(always)]
    fn length(&self, scale: F, tolerance: f64) -> F {
        let size = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|i| self.n[k][i].v.abs());
            (self.u[k].v.abs() / scale).max(x).max(y.max(z)).max(self.chi[k.min(N - 2)].v.abs())
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
            value = value.fma(h, c);
            slope = slope.fma(h, c * F::splat(k as f64));
        }
        [value.fma(h, self.u[0].v), slope]
    }

    /// The state after the times `h`.
    #[inline(always)]
    fn at(&self, h: F, from: &Bundle<F>) -> Bundle<F> {
        let u = value_and_slope::<F, N>(|k| self.u[k], h);
        let [x, y, z] = [0, 1, 2].map(|j| value_and_slope::<F, N>(|k| self.n[k][j], h));
        let mut chi = self.chi[N - 2];
        for k in (0..N - 2).rev() {
            chi = self.chi[k].plus_scaled(chi, h);
        }
        Bundle { u, n: [[x[0], y[0], z[0]], [x[1], y[1], z[1]]], chi, ..*from }
    }
}

#[inline(always)]
fn value_and_slope<F: Real, const N: usize>(c: impl Fn(usize) -> Pencil<F>, h: F) -> [Pencil<F>; 2] {
    let mut value = c(N - 1);
    let mut slope = value;
    for k in (1..N - 1).rev() {
        value = c(k).plus_scaled(value, h);
        slope = value.plus_scaled(slope, h);
    }
    [c(0).plus_scaled(value, h), slope]
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
pub struct Followed<F: Real> {
    /// With their neighbours.
    pub end: Bundle<F>,
    /// For how long they were followed.
    pub tau: F,
    /// Which of them were given up.
    pub lost: F::Mask,
}

/// Newton's steps to where a ray leaves.
const EXIT_STEPS: u32 = 4;

/// Follows the rays `bundle` for the times `tau`, or until their 1/r becomes less than `exit` on the way out, by series of N terms.
pub fn follow<F: Real, const N: usize>(spin: &Spin<F>, bundle: &Bundle<F>, (tau, exit): (F, F), tolerance: f64) -> Followed<F> {
    let c = F::splat;
    let mut at = *bundle;
    let factors = Factors::new(spin, &at);
    let limit = c(LOST) * spin.horizon();
    let least = at.u[0].v;
    let (mut left, mut gone) = (tau, c(0.0));
    let mut lost = F::Mask::NONE;
    let mut series = Series::<F, N>::nothing();
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
