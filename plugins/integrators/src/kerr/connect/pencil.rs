//! Numbers of rays with their derivatives by two angles of the launch: a ray with its neighbours.

use bhs_core::real::Real;
use std::ops::{Add, Mul, Neg, Sub};

/// A number with its derivatives by two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pencil<F> {
    /// The number.
    pub v: F,
    /// Its derivatives.
    pub d: [F; 2],
}

impl<F: Real> Pencil<F> {
    /// A number that is the same for all neighbours.
    #[inline(always)]
    pub fn constant(v: F) -> Self {
        Self { v, d: [F::splat(0.0); 2] }
    }

    /// `self + a b`
    #[inline(always)]
    pub fn plus(self, a: Self, b: Self) -> Self {
        let d = |i: usize| a.d[i].fma(b.v, a.v.fma(b.d[i], self.d[i]));
        Self { v: a.v.fma(b.v, self.v), d: [d(0), d(1)] }
    }

    /// `self + a s`
    #[inline(always)]
    pub fn plus_scaled(self, a: Self, s: F) -> Self {
        let d = |i: usize| a.d[i].fma(s, self.d[i]);
        Self { v: a.v.fma(s, self.v), d: [d(0), d(1)] }
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(self, o: Self, which: F::Mask) -> Self {
        let pick = |a, b| F::select(which, a, b);
        Self { v: pick(self.v, o.v), d: [pick(self.d[0], o.d[0]), pick(self.d[1], o.d[1])] }
    }

    /// The number of ray `i` and its derivatives.
    #[inline]
    pub fn lane(&self, i: usize) -> Pencil<f64> {
        Pencil { v: self.v.lane(i), d: self.d.map(|d| d.lane(i)) }
    }
}

impl<F: Real> Add for Pencil<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { v: self.v + o.v, d: [self.d[0] + o.d[0], self.d[1] + o.d[1]] }
    }
}

impl<F: Real> Sub for Pencil<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { v: self.v - o.v, d: [self.d[0] - o.d[0], self.d[1] - o.d[1]] }
    }
}

impl<F: Real> Neg for Pencil<F> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { v: -self.v, d: self.d.map(|d| -d) }
    }
}

impl<F: Real> Mul for Pencil<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let d = |i: usize| self.d[i].fma(o.v, self.v * o.d[i]);
        Self { v: self.v * o.v, d: [d(0), d(1)] }
    }
}

impl<F: Real> Mul<F> for Pencil<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: F) -> Self {
        Self { v: self.v * s, d: self.d.map(|d| d * s) }
    }
}
