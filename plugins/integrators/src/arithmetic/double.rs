//! Sums and products of twice the precision: an unevaluated sum `hi + lo` of two `f64`, some 32 digits.
//!
//! For the few invariants of an orbit whose digits cancel: near the critical impact parameter the whole fate of a ray hangs
//! on the difference of two nearly equal numbers. Not for inner loops.
//! Source: Dekker 1971, "A floating-point technique for extending the available precision", Numer. Math. 18, with the
//! product by fused multiply-add.

use std::ops::{Add, Mul, Neg, Sub};

/// A number of twice the precision of `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double {
    hi: f64,
    lo: f64,
}

impl Double {
    /// The sum of a number and a much smaller one.
    pub const fn new(hi: f64, lo: f64) -> Self {
        Self { hi, lo }
    }

    /// The exact product of two numbers.
    pub fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        Self { hi, lo: a.mul_add(b, -hi) }
    }

    /// The nearest `f64`.
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// The sum of two numbers with the rounding error of their sum (Knuth's two-sum).
    fn sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let part = hi - a;
        Self { hi, lo: (a - (hi - part)) + (b - part) }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        // Both halves are summed exactly, so that nothing is lost when the leading parts cancel.
        let (high, low) = (Self::sum(self.hi, o.hi), Self::sum(self.lo, o.lo));
        let s = Self::sum(high.hi, high.lo + low.hi);
        Self::sum(s.hi, s.lo + low.lo)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = Self::product(self.hi, o.hi);
        Self::sum(p.hi, p.lo + (self.hi * o.lo + self.lo * o.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_cancel_come_back() {
        // (1 + e)^2 - 1 - 2 e = e^2, with e^2 far below the rounding of 1.
        let e = 2f64.powi(-40);
        let one = Double::new(1.0, 0.0);
        let x = one + Double::new(e, 0.0);
        assert_eq!((x * x - one - Double::new(2.0 * e, 0.0)).value(), e * e);
        // 1/3 to 32 digits.
        let third = Double::new(1.0 / 3.0, 1.0 / 3.0 * f64::EPSILON / 4.0);
        assert!((third + third + third - one).value().abs() < 1e-32);
    }
}
