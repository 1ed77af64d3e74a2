//! Arithmetic that is written once: for one number, or for eight side by side.
//!
//! The same operations in the same order give the same bits for one ray and for each of several, on every processor ([`Real::times_plus`]).

use crate::lanes::{LANES, Lanes};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, BitXor, Div, Index, Mul, Neg, Not, Sub, SubAssign};

mod vector;

pub use vector::{Vector, Vectors};

/// A yes or no of each number of a [`Real`].
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self> + Send + Sync + 'static
{
    /// No for all.
    const NONE: Self;

    /// Yes for all.
    const ALL: Self;

    /// Yes for at least one.
    fn any(self) -> bool;

    /// Yes for all.
    fn all(self) -> bool;

    /// Bit i is set where number i has a yes.
    fn bits(self) -> u32;

    /// The mask with these [`Mask::bits`].
    fn of_bits(bits: u32) -> Self;
}

/// A number, or several side by side that the same operations apply to.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Send
    + Sync
    + 'static
{
    /// A yes or no of each number.
    type Mask: Mask;

    /// The numbers one after the other.
    type Array: Copy + Index<usize, Output = f64>;

    /// How many numbers.
    const COUNT: usize;

    /// The number `x`, or so many of it.
    fn splat(x: f64) -> Self;

    /// Number i is `number(i)`.
    fn from_fn(number: impl FnMut(usize) -> f64) -> Self;

    /// Number `i`, below [`Real::COUNT`].
    fn lane(self, i: usize) -> f64;

    /// All numbers, where several are looked up by their place.
    fn to_array(self) -> Self::Array;

    /// The least whole number that is not below it.
    fn ceil(self) -> Self;

    /// The greatest whole number that is not above it.
    fn floor(self) -> Self;

    /// Whether it is neither infinite nor NaN.
    fn is_finite(self) -> Self::Mask;

    /// `self b + c`, rounded twice whatever the processor: with instructions that round once, pictures would depend on what the program is built for.
    #[inline(always)]
    fn times_plus(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    /// Square root.
    fn sqrt(self) -> Self;

    /// Absolute value.
    fn abs(self) -> Self;

    /// The lesser of two, neither of which may be NaN.
    fn min(self, o: Self) -> Self;

    /// The greater of two, neither of which may be NaN.
    fn max(self, o: Self) -> Self;

    /// `self < o`; no for NaN, here and below.
    fn lt(self, o: Self) -> Self::Mask;

    /// `self <= o`
    fn le(self, o: Self) -> Self::Mask;

    /// `self > o`
    #[inline(always)]
    fn gt(self, o: Self) -> Self::Mask {
        o.lt(self)
    }

    /// `self >= o`
    #[inline(always)]
    fn ge(self, o: Self) -> Self::Mask {
        o.le(self)
    }

    /// The numbers `yes` where the mask says so, elsewhere `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

impl Mask for bool {
    const NONE: Self = false;
    const ALL: Self = true;

    #[inline(always)]
    fn any(self) -> bool {
        self
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }

    #[inline(always)]
    fn of_bits(bits: u32) -> Self {
        bits & 1 == 1
    }
}

impl Mask for Lanes {
    const NONE: Self = Self::ZERO;
    const ALL: Self = Self::new([f64::from_bits(u64::MAX); LANES]);

    #[inline(always)]
    fn any(self) -> bool {
        Self::any(self)
    }

    #[inline(always)]
    fn all(self) -> bool {
        Self::all(self)
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.to_bitmask()
    }

    #[inline(always)]
    fn of_bits(bits: u32) -> Self {
        crate::lanes::of_bits(bits)
    }
}

impl Real for f64 {
    type Mask = bool;
    type Array = [Self; 1];
    const COUNT: usize = 1;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn from_fn(mut number: impl FnMut(usize) -> f64) -> Self {
        number(0)
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn to_array(self) -> [Self; 1] {
        [self]
    }

    #[inline(always)]
    fn ceil(self) -> Self {
        Self::ceil(self)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self::floor(self)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        if self < o { self } else { o }
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        if self > o { self } else { o }
    }

    #[inline(always)]
    fn lt(self, o: Self) -> bool {
        self < o
    }

    #[inline(always)]
    fn le(self, o: Self) -> bool {
        self <= o
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl Real for Lanes {
    type Mask = Self;
    type Array = [f64; LANES];
    const COUNT: usize = LANES;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self::splat(x)
    }

    #[inline(always)]
    fn from_fn(number: impl FnMut(usize) -> f64) -> Self {
        Self::from(std::array::from_fn::<f64, LANES, _>(number))
    }

    #[inline(always)]
    fn lane(self, i: usize) -> f64 {
        Self::to_array(self)[i]
    }

    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        Self::to_array(self)
    }

    #[inline(always)]
    fn ceil(self) -> Self {
        Self::ceil(self)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self::floor(self)
    }

    #[inline(always)]
    fn is_finite(self) -> Self {
        Self::is_finite(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        self.fast_min(o)
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.fast_max(o)
    }

    #[inline(always)]
    fn lt(self, o: Self) -> Self {
        self.simd_lt(o)
    }

    #[inline(always)]
    fn le(self, o: Self) -> Self {
        self.simd_le(o)
    }

    #[inline(always)]
    fn select(mask: Self, yes: Self, no: Self) -> Self {
        mask.select(yes, no)
    }
}

/// `a b + c`: see [`Real::times_plus`].
#[inline(always)]
pub fn times_plus<F: Real>(a: F, b: F, c: F) -> F {
    a.times_plus(b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Some of everything, as one number or eight.
    fn formula<F: Real>(a: F, b: F) -> F {
        let v = Vector { x: a, y: b, z: a - b };
        let w = v.cross(Vector::all(DVec3::new(0.3, -0.2, 0.7))).normalize().plus(v, F::splat(0.1));
        let larger = w.largest().max(a.abs().sqrt()).min(F::splat(0.9)) / times_plus(b, b, F::splat(0.5));
        F::select(a.lt(b) | b.le(F::splat(0.0)), larger, -w.dot(v)) + w.or(v, a.gt(b)).length()
    }

    #[test]
    fn eight_numbers_are_as_one_to_the_bit() {
        let a: [f64; LANES] = [0.1, -0.4, 2.5, 1e-3, -7.0, 0.3, 11.0, -0.01];
        let b: [f64; LANES] = [0.7, 0.2, -1.5, 1e3, 7.0, 0.3, -0.2, -3.0];
        let all = formula(Lanes::from(a), Lanes::from(b)).to_array();
        for i in 0..LANES {
            assert_eq!(all[i].to_bits(), formula(a[i], b[i]).to_bits(), "{i}");
        }
    }

    #[test]
    fn masks_know_their_bits() {
        for bits in [0, 1, 0b1010_0110, 0xff] {
            let mask = <Lanes as Mask>::of_bits(bits);
            assert_eq!(Mask::bits(mask), bits);
            assert_eq!((Mask::any(mask), Mask::all(mask)), (bits != 0, bits == 0xff));
            assert_eq!(Mask::bits(!mask), 0xff & !bits);
            assert_eq!(bool::of_bits(bits).bits(), bits & 1);
        }
        assert_eq!((Mask::bits(Lanes::NONE), Mask::bits(Lanes::ALL)), (0, 0xff));
        assert!(!f64::NAN.lt(1.0) && !Mask::any(Real::le(Lanes::splat(f64::NAN), Lanes::ONE)));
    }
}
