//! Elementary functions that are the same to the last bit on every machine.
//!
//! Those of the standard library (`x.sin()`) are the system's: their last digit depends on the version of its C library, and on whether the processor
//! fuses multiplications and additions. Parts of a picture may come from any machine of a farm and join to the very bytes of the whole, so all code
//! of this project, tests aside, calls these, which are the functions of the crate `libm` (a translation of musl's), compiled with the program. Square roots,
//! absolute values, whole powers (`powi`) and rounding are exact or done by the compiler's own code, and stay the standard library's.

use glam::{DMat3, DVec2, DVec3};

/// The unit vector at this angle to the x axis (rad): in place of [`DVec2::from_angle`], which asks the standard library.
#[inline]
pub fn unit_vector(angle: f64) -> DVec2 {
    let (sine, cosine) = angle.sine_cosine();
    DVec2::new(cosine, sine)
}

/// The rotation about the unit vector `axis` by an angle (rad), right-handed (Rodrigues): in place of [`DMat3::from_axis_angle`].
pub fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sine, cosine) = angle.sine_cosine();
    let column = |of: DVec3| of * cosine + axis.cross(of) * sine + axis * (axis.dot(of) * (1.0 - cosine));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// Elementary functions of a real number.
pub trait Elementary: Sized {
    /// Sine of an angle (rad).
    #[must_use]
    fn sine(self) -> Self;
    /// Cosine of an angle (rad).
    #[must_use]
    fn cosine(self) -> Self;
    /// Both.
    #[must_use]
    fn sine_cosine(self) -> (Self, Self);
    /// Tangent of an angle (rad).
    #[must_use]
    fn tangent(self) -> Self;
    /// The angle between -pi/2 and pi/2 (rad) that has this sine.
    #[must_use]
    fn arcsine(self) -> Self;
    /// The angle between 0 and pi (rad) that has this cosine.
    #[must_use]
    fn arccosine(self) -> Self;
    /// The angle between -pi/2 and pi/2 (rad) that has this tangent.
    #[must_use]
    fn arctangent(self) -> Self;
    /// The angle between -pi and pi (rad) from the x axis to the point (`x`, self).
    #[must_use]
    fn arctangent2(self, x: Self) -> Self;
    /// e to this power.
    #[must_use]
    fn exponential(self) -> Self;
    /// 2 to this power.
    #[must_use]
    fn exponential2(self) -> Self;
    /// e to this power, less 1: exact for small numbers.
    #[must_use]
    fn exponential_m1(self) -> Self;
    /// Natural logarithm.
    #[must_use]
    fn logarithm(self) -> Self;
    /// Natural logarithm of 1 and this: exact for small numbers.
    #[must_use]
    fn logarithm_1p(self) -> Self;
    /// Logarithm to the base 2.
    #[must_use]
    fn logarithm2(self) -> Self;
    /// Logarithm to the base 10.
    #[must_use]
    fn logarithm10(self) -> Self;
    /// This to the power of `exponent`.
    #[must_use]
    fn power(self, exponent: Self) -> Self;
    /// Cube root.
    #[must_use]
    fn cube_root(self) -> Self;
    /// Hyperbolic sine.
    #[must_use]
    fn hyperbolic_sine(self) -> Self;
    /// Hyperbolic cosine.
    #[must_use]
    fn hyperbolic_cosine(self) -> Self;
    /// Hyperbolic tangent.
    #[must_use]
    fn hyperbolic_tangent(self) -> Self;
    /// The number that has this hyperbolic sine.
    #[must_use]
    fn inverse_hyperbolic_sine(self) -> Self;
    /// The number that has this hyperbolic tangent.
    #[must_use]
    fn inverse_hyperbolic_tangent(self) -> Self;
    /// Length of the vector (self, `other`), without overflow on the way.
    #[must_use]
    fn hypotenuse(self, other: Self) -> Self;
}

macro_rules! elementary {
    ($real:ty; $($name:ident($($argument:ident)?) = $function:ident),*; $both:ident) => {
        impl Elementary for $real {
            $(#[inline]
            fn $name(self $(, $argument: Self)?) -> Self {
                libm::$function(self $(, $argument)?)
            })*

            #[inline]
            fn sine_cosine(self) -> (Self, Self) {
                libm::$both(self)
            }
        }
    };
}

elementary!(f64; sine() = sin, cosine() = cos, tangent() = tan, arcsine() = asin, arccosine() = acos, arctangent() = atan, arctangent2(x) = atan2,
    exponential() = exp, exponential2() = exp2, exponential_m1() = expm1, logarithm() = log, logarithm_1p() = log1p, logarithm2() = log2,
    logarithm10() = log10, power(exponent) = pow, cube_root() = cbrt, hyperbolic_sine() = sinh, hyperbolic_cosine() = cosh, hyperbolic_tangent() = tanh, inverse_hyperbolic_sine() = asinh, inverse_hyperbolic_tangent() = atanh,
    hypotenuse(other) = hypot; sincos);

elementary!(f32; sine() = sinf, cosine() = cosf, tangent() = tanf, arcsine() = asinf, arccosine() = acosf, arctangent() = atanf, arctangent2(x) = atan2f,
    exponential() = expf, exponential2() = exp2f, exponential_m1() = expm1f, logarithm() = logf, logarithm_1p() = log1pf, logarithm2() = log2f,
    logarithm10() = log10f, power(exponent) = powf, cube_root() = cbrtf, hyperbolic_sine() = sinhf, hyperbolic_cosine() = coshf, hyperbolic_tangent() = tanhf, inverse_hyperbolic_sine() = asinhf, inverse_hyperbolic_tangent() = atanhf,
    hypotenuse(other) = hypotf; sincosf);

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard library's are another implementation: within a few units of the last place.
    macro_rules! agree {
        ($x:expr, $real:ident, $($ours:ident($($argument:expr)?) = $std:ident),*) => {
            $({
                let (ours, std) = ($x.$ours($($argument)?), $x.$std($($argument)?));
                let both = ours == std || ours.is_nan() && std.is_nan();
                assert!(both || ((ours - std) / std).abs() < 8.0 * $real::EPSILON, "{}: {ours} {std}", stringify!($std));
            })*
        };
    }

    macro_rules! all_agree {
        ($x:expr, $real:ident) => {
            agree!(
                $x,
                $real,
                sine() = sin,
                cosine() = cos,
                tangent() = tan,
                arcsine() = asin,
                arccosine() = acos,
                arctangent() = atan,
                arctangent2(0.7) = atan2,
                exponential() = exp,
                exponential2() = exp2,
                exponential_m1() = exp_m1,
                logarithm() = ln,
                logarithm_1p() = ln_1p,
                logarithm2() = log2,
                logarithm10() = log10,
                cube_root() = cbrt,
                hyperbolic_sine() = sinh,
                hyperbolic_cosine() = cosh,
                hyperbolic_tangent() = tanh,
                inverse_hyperbolic_sine() = asinh,
                inverse_hyperbolic_tangent() = atanh,
                hypotenuse(2.0) = hypot
            );
            agree!($x.abs(), $real, power(1.7) = powf);
            assert_eq!($x.sine_cosine(), ($x.sine(), $x.cosine()));
        };
    }

    #[test]
    fn they_are_the_functions_that_their_names_say() {
        for i in -400..400 {
            let x = f64::from(i) * 0.0173 + 0.001;
            all_agree!(x, f64);
            let single = x as f32;
            all_agree!(single, f32);
        }
        assert_eq!(1e200_f64.hypotenuse(1e200), 1e200 * 2_f64.sqrt());
    }

    #[test]
    fn turns_are_those_of_glam() {
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        for i in -20..20 {
            let angle = f64::from(i) * 0.4;
            assert!((unit_vector(angle) - DVec2::from_angle(angle)).length() < 1e-15);
            assert!((rotation(axis, angle) - DMat3::from_axis_angle(axis, angle)).abs_diff_eq(DMat3::ZERO, 1e-15));
        }
    }
}
