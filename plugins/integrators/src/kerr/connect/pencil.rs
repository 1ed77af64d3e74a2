//! Numbers of rays with their derivatives by D angles of the launch: with two of them a ray with its neighbours, with none the ray alone.

use bhs_core::real::Real;
use std::ops::{Add, Mul, Neg, Sub};

/// A number with its derivatives by D angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil<F, const D: usize> {
    /// The number.
    pub v: F,
    /// Its derivatives.
    pub d: [F; D],
}

impl<F: Real, const D: usize> Pencil<F, D> {
    /// A number that is the same for all neighbours.
    #[inline(always)]
    pub fn constant(v: F) -> Self {
        Self { v, d: [F::splat(0.0); D] }
    }

    /// `self + a b`
    #[inline(always)]
    pub fn plus(self, a: Self, b: Self) -> Self {
        let mut d = self.d;
        for i in 0..D {
            d[i] = a.d[i].times_plus(b.v, a.v.times_plus(b.d[i], d[i]));
        }
        Self { v: a.v.times_plus(b.v, self.v), d }
    }

    /// `self + a s`
    #[inline(always)]
    pub fn plus_scaled(self, a: Self, s: F) -> Self {
        let mut d = self.d;
        for i in 0..D {
            d[i] = a.d[i].times_plus(s, d[i]);
        }
        Self { v: a.v.times_plus(s, self.v), d }
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(self, o: Self, which: F::Mask) -> Self {
        let pick = |a, b| F::select(which, a, b);
        let mut d = self.d;
        for i in 0..D {
            d[i] = pick(d[i], o.d[i]);
        }
        Self { v: pick(self.v, o.v), d }
    }

    /// The number of ray `i` and its derivatives.
    #[inline]
    pub fn lane(&self, i: usize) -> Pencil<f64, D> {
        Pencil { v: self.v.lane(i), d: self.d.map(|d| d.lane(i)) }
    }
}

impl<F: Real, const D: usize> Add for Pencil<F, D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let mut d = self.d;
        for i in 0..D {
            d[i] += o.d[i];
        }
        Self { v: self.v + o.v, d }
    }
}

impl<F: Real, const D: usize> Sub for Pencil<F, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let mut d = self.d;
        for i in 0..D {
            d[i] -= o.d[i];
        }
        Self { v: self.v - o.v, d }
    }
}

impl<F: Real, const D: usize> Neg for Pencil<F, D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut d = self.d;
        for d in &mut d {
            *d = -*d;
        }
        Self { v: -self.v, d }
    }
}

impl<F: Real, const D: usize> Mul for Pencil<F, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let mut d = self.d;
        for i in 0..D {
            d[i] = d[i].times_plus(o.v, self.v * o.d[i]);
        }
        Self { v: self.v * o.v, d }
    }
}

impl<F: Real, const D: usize> Mul<F> for Pencil<F, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: F) -> Self {
        let mut d = self.d;
        for d in &mut d {
            *d = *d * s;
        }
        Self { v: self.v * s, d }
    }
}
