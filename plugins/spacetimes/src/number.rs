//! Arithmetic that is written once and runs on one number, on eight side by side, and on numbers with their gradients.

use bhs_core::dual::Dual;
use bhs_core::lanes::Lanes;
use glam::{DMat3, DVec3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, several side by side, or one with its gradient.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number `x`.
    fn splat(x: f64) -> Self;

    /// `self b + c`, rounded once where the processor can, for one number as for eight.
    fn fma(self, b: Self, c: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { self.mul_add(b, c) } else { self * b + c }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self::splat(x)
    }

    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        self.mul_add(b, c)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}

impl Number for Dual {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self::constant(x)
    }

    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        self * b + c
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
}

/// `x - center`
#[inline(always)]
pub fn from_center<F: Number>([x, y, z]: [F; 3], center: DVec3) -> [F; 3] {
    [x - F::splat(center.x), y - F::splat(center.y), z - F::splat(center.z)]
}

/// Square of the length.
#[inline(always)]
pub fn square<F: Number>([x, y, z]: [F; 3]) -> F {
    x.fma(x, y.fma(y, z * z))
}

/// The matrix of derivatives of the gradient field `gradient` at `x`.
pub fn hessian(gradient: impl Fn([Dual; 3]) -> [Dual; 3], x: DVec3) -> DMat3 {
    let [a, b, c] = gradient(Dual::variables(x)).map(|g| g.gradient);
    DMat3::from_cols(a, b, c)
}

/// Implements [`bhs_core::spacetime::GradedIndex`] beyond what is given, of a type with a method `index_of<F: Number>(&self, [F; 3]) -> (F, [F; 3])`.
macro_rules! one_and_eight {
    () => {
        fn index(&self, x: glam::DVec3) -> (f64, glam::DVec3) {
            let (square, gradient) = self.index_of(x.to_array());
            (square, gradient.into())
        }

        fn index_each(&self, at: bhs_core::lanes::Vectors) -> (bhs_core::lanes::Lanes, bhs_core::lanes::Vectors) {
            let (square, [x, y, z]) = self.index_of([at.x, at.y, at.z]);
            (square, bhs_core::lanes::Vectors { x, y, z })
        }

        fn hessian(&self, x: glam::DVec3) -> glam::DMat3 {
            $crate::number::hessian(|x| self.index_of(x).1, x)
        }
    };
}
pub(crate) use one_and_eight;
