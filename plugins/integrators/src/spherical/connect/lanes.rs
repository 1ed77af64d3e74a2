//! Numbers side by side: what lets one pass of arithmetic solve both images of a pair of points. Solving one connection is a
//! chain of operations that wait for each other; a second one beside it costs little.

use std::ops::{Add, Mul, Neg, Sub};

/// `N` numbers that the same operations apply to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    /// The same number in every lane.
    pub fn all(x: f64) -> Self {
        Self([x; N])
    }

    /// `f` of every lane.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        // Loops, which become operations on all lanes.
        let mut values = self.0;
        for v in &mut values {
            *v = f(*v);
        }
        Self(values)
    }

    /// `f` of the lanes of two.
    #[inline(always)]
    pub fn zip(self, o: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut values = self.0;
        for (v, o) in values.iter_mut().zip(o.0) {
            *v = f(*v, o);
        }
        Self(values)
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// Reciprocals.
    #[inline(always)]
    pub fn recip(self) -> Self {
        self.map(|x| 1.0 / x)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                self.zip(o, |a, b| a $op b)
            }
        }
        impl<const N: usize> $trait<f64> for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                self.map(|a| a $op o)
            }
        }
        impl<const N: usize> $trait<Lanes<N>> for f64 {
            type Output = Lanes<N>;
            #[inline(always)]
            fn $method(self, o: Lanes<N>) -> Lanes<N> {
                o.map(|b| self $op b)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}
