//! Numbers that carry their gradient: exact derivatives of whatever is computed with them (forward automatic differentiation).

use crate::real::Real;
use bhs_elementary::Elementary;
use glam::DVec3;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number that depends on the place, with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The number.
    pub value: f64,
    /// Its derivatives by the three coordinates.
    pub gradient: DVec3,
}

impl Dual {
    /// A number that is the same everywhere.
    pub const fn constant(value: f64) -> Self {
        Self { value, gradient: DVec3::ZERO }
    }

    /// The coordinates of the point `x`.
    pub fn variables(x: DVec3) -> [Self; 3] {
        [
            Self { value: x.x, gradient: DVec3::X },
            Self { value: x.y, gradient: DVec3::Y },
            Self { value: x.z, gradient: DVec3::Z },
        ]
    }

    /// The number `value` of a function of this one whose derivative is `slope`.
    #[inline]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, gradient: self.gradient * slope }
    }

    /// Square root; of 0, with a gradient that is not finite.
    #[inline]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    /// 1 over it.
    #[inline]
    pub fn recip(self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse)
    }

    /// Whole power.
    #[inline]
    pub fn powi(self, n: i32) -> Self {
        self.chain(self.value.powi(n), f64::from(n) * self.value.powi(n - 1))
    }

    /// e to the power of it.
    #[inline]
    pub fn exp(self) -> Self {
        let value = self.value.exponential();
        self.chain(value, value)
    }

    /// Natural logarithm.
    #[inline]
    pub fn ln(self) -> Self {
        self.chain(self.value.logarithm(), 1.0 / self.value)
    }

    /// Sine (of radians).
    #[inline]
    pub fn sin(self) -> Self {
        self.chain(self.value.sine(), self.value.cosine())
    }

    /// Cosine (of radians).
    #[inline]
    pub fn cos(self) -> Self {
        self.chain(self.value.cosine(), -self.value.sine())
    }

    /// Arc tangent (rad).
    #[inline]
    pub fn atan(self) -> Self {
        self.chain(self.value.arctangent(), 1.0 / (1.0 + self.value * self.value))
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl Add for Dual {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, gradient: self.gradient + o.gradient }
    }
}

impl Sub for Dual {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self { value: self.value - o.value, gradient: self.gradient - o.gradient }
    }
}

impl Mul for Dual {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self { value: self.value * o.value, gradient: self.gradient * o.value + o.gradient * self.value }
    }
}

impl Div for Dual {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Self { value, gradient: (self.gradient - o.gradient * value) / o.value }
    }
}

impl Neg for Dual {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, gradient: -self.gradient }
    }
}

impl AddAssign for Dual {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl SubAssign for Dual {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

/// Comparisons are those of the values; numbers that go in and out have no gradient.
impl Real for Dual {
    type Mask = bool;
    type Array = [f64; 1];
    const COUNT: usize = 1;

    #[inline]
    fn splat(x: f64) -> Self {
        Self::constant(x)
    }

    #[inline]
    fn from_fn(mut number: impl FnMut(usize) -> f64) -> Self {
        Self::constant(number(0))
    }

    /// Without derivatives.
    fn to_array(self) -> [f64; 1] {
        [self.value]
    }

    fn ceil(self) -> Self {
        Self::splat(self.value.ceil())
    }

    fn floor(self) -> Self {
        Self::splat(self.value.floor())
    }

    fn is_finite(self) -> bool {
        self.value.is_finite()
    }

    #[inline]
    fn lane(self, _: usize) -> f64 {
        self.value
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }

    #[inline]
    fn min(self, o: Self) -> Self {
        if o.value < self.value { o } else { self }
    }

    #[inline]
    fn max(self, o: Self) -> Self {
        if o.value > self.value { o } else { self }
    }

    #[inline]
    fn lt(self, o: Self) -> bool {
        self.value < o.value
    }

    #[inline]
    fn le(self, o: Self) -> bool {
        self.value <= o.value
    }

    #[inline]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

macro_rules! with_numbers {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator<f64> for Dual {
            type Output = Self;
            #[inline]
            fn $method(self, o: f64) -> Self {
                $operator::$method(self, Self::constant(o))
            }
        }

        impl $operator<Dual> for f64 {
            type Output = Dual;
            #[inline]
            fn $method(self, o: Dual) -> Dual {
                $operator::$method(Dual::constant(self), o)
            }
        }
    )*};
}

with_numbers!(Add add, Sub sub, Mul mul, Div div);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_for_one_and_eight_yields_gradients() {
        fn f<F: Real>(a: F, b: F) -> F {
            let c = F::select(a.lt(b), a.times_plus(b, F::splat(0.3)), b - a).max(a.abs() * F::splat(0.1));
            c.sqrt().min(F::splat(3.0) / b)
        }
        for (x, y) in [(0.4, 0.9), (0.9, 0.4), (-0.8, 1.3), (5.0, 7.0)] {
            let [a, b, _] = Dual::variables(DVec3::new(x, y, 0.0));
            let (found, h) = (f(a, b), 1e-6);
            assert_eq!(found.value, f(x, y));
            let slopes = [f(x + h, y) - f(x - h, y), f(x, y + h) - f(x, y - h)].map(|d| d / (2.0 * h));
            assert!((found.gradient.x - slopes[0]).abs() < 1e-8 && (found.gradient.y - slopes[1]).abs() < 1e-8, "{x} {y}");
        }
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        let f = |[x, y, z]: [Dual; 3]| {
            let r = (x * x + y * y + z * z).sqrt();
            let odd = (x * y - z / (1.0 + r)).sin() * (0.3 * z).exp() + (r * 0.5).atan() - (2.0 + y.cos()).ln();
            odd / r.powi(3) + x.recip() - (-y)
        };
        let x = DVec3::new(0.7, -0.4, 1.3);
        let found = f(Dual::variables(x));
        for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let h = 1e-6;
            let slope = (f(Dual::variables(x + unit * h)).value - f(Dual::variables(x - unit * h)).value) / (2.0 * h);
            assert!((found.gradient[axis] - slope).abs() < 1e-8 * slope.abs().max(1.0), "{axis}");
        }
    }
}
