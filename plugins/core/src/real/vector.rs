//! Vectors of numbers of any kind.

use super::Real;
use crate::lanes::{LANES, Lanes};
use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// A vector, or one of each of several rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<F> {
    /// First coordinates.
    pub x: F,
    /// Second coordinates.
    pub y: F,
    /// Third coordinates.
    pub z: F,
}

impl<F: Real> Vector<F> {
    /// The same vector of all rays.
    #[inline(always)]
    pub fn all(v: DVec3) -> Self {
        Self { x: F::splat(v.x), y: F::splat(v.y), z: F::splat(v.z) }
    }

    /// Vector i is `vector(i)`.
    #[inline(always)]
    pub fn from_fn(vector: impl Fn(usize) -> DVec3) -> Self {
        Self { x: F::from_fn(|i| vector(i).x), y: F::from_fn(|i| vector(i).y), z: F::from_fn(|i| vector(i).z) }
    }

    /// The vector of ray number `i`.
    #[inline]
    pub fn lane(self, i: usize) -> DVec3 {
        DVec3::new(self.x.lane(i), self.y.lane(i), self.z.lane(i))
    }

    /// The coordinates as arrays, where several are looked up by their place.
    #[inline(always)]
    pub fn to_arrays(self) -> [F::Array; 3] {
        [self.x.to_array(), self.y.to_array(), self.z.to_array()]
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, o: Self) -> F {
        self.x.times_plus(o.x, self.y.times_plus(o.y, self.z * o.z))
    }

    /// Vector products.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self { x: self.y * o.z - self.z * o.y, y: self.z * o.x - self.x * o.z, z: self.x * o.y - self.y * o.x }
    }

    /// Squares of the lengths.
    #[inline(always)]
    pub fn length_squared(self) -> F {
        self.dot(self)
    }

    /// Lengths.
    #[inline(always)]
    pub fn length(self) -> F {
        self.length_squared().sqrt()
    }

    /// The unit vectors along it.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (F::splat(1.0) / self.length())
    }

    /// `self + o s`
    #[inline(always)]
    pub fn plus(self, o: Self, s: F) -> Self {
        Self { x: o.x.times_plus(s, self.x), y: o.y.times_plus(s, self.y), z: o.z.times_plus(s, self.z) }
    }

    /// Each divided by its number.
    #[inline(always)]
    pub fn over(self, s: F) -> Self {
        Self { x: self.x / s, y: self.y / s, z: self.z / s }
    }

    /// The largest of the absolute coordinates.
    #[inline(always)]
    pub fn largest(self) -> F {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(self, o: Self, which: F::Mask) -> Self {
        let pick = |yes, no| F::select(which, yes, no);
        Self { x: pick(self.x, o.x), y: pick(self.y, o.y), z: pick(self.z, o.z) }
    }
}

/// A vector of each of eight rays.
pub type Vectors = Vector<Lanes>;

impl Vector<Lanes> {
    /// Vector number i of ray number i.
    #[inline(always)]
    pub fn of(v: [DVec3; LANES]) -> Self {
        Self { x: Lanes::from(v.map(|v| v.x)), y: Lanes::from(v.map(|v| v.y)), z: Lanes::from(v.map(|v| v.z)) }
    }
}

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vector<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<F: Real> Add for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<F: Real> Sub for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<F: Real> Mul<F> for Vector<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: F) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}
