//! Polynomials, sines and cosines for the inner loops of orbits: short independent chains of operations, which a processor runs
//! side by side, and fused multiply-adds where it has them.

use bhs_core::real::{Real, times_plus};

/// Number of coefficients of an orbit's Taylor series.
pub const TERMS: usize = 16;

/// `x` to the powers 1, 2 and 4.
#[inline(always)]
fn powers<F: Real>(t: F) -> (F, F, F) {
    let tt = t * t;
    (t, tt, tt * tt)
}

/// Four chains of powers of t^4 joined: `a[0] + a[1] t + a[2] t^2 + a[3] t^3`.
#[inline(always)]
fn join<F: Real>(a: [F; 4], (t, tt, _): (F, F, F)) -> F {
    times_plus(tt, times_plus(t, a[3], a[2]), times_plus(t, a[1], a[0]))
}

/// `c[0] + c[1] t + c[2] t^2 + ...`
#[inline(always)]
pub fn value<F: Real>(c: &[F; TERMS], t: F) -> F {
    let p = powers(t);
    let mut a = [c[12], c[13], c[14], c[15]];
    for row in [8, 4, 0] {
        for i in 0..4 {
            a[i] = times_plus(a[i], p.2, c[row + i]);
        }
    }
    join(a, p)
}

/// `c[0] + c[1] t + c[2] t^2 + ...` and its derivative.
#[inline(always)]
pub fn value_and_slope<F: Real>(c: &[F; TERMS], t: F) -> (F, F) {
    let p = powers(t);
    let mut a = [F::splat(13.0) * c[13], F::splat(14.0) * c[14], F::splat(15.0) * c[15], F::splat(0.0)];
    for row in [8, 4, 0] {
        for i in 0..4 {
            let n = row + i + 1;
            a[i] = times_plus(a[i], p.2, F::splat(n as f64) * c[n]);
        }
    }
    (value(c, t), join(a, p))
}

/// Largest angle for [`cos_sin`], in radians.
pub const LARGEST_ANGLE: f64 = 1.6;

/// Of cosine in x^2 and sine over x, by powers of x^4: even powers of x^2 of the cosine, odd ones; the same of the sine.
const COS_SIN: [[f64; 4]; 6] = {
    let mut rows = [[0.0; 4]; 6];
    let (mut factorial, mut n) = (1.0, 0);
    while n < 24 {
        let sign = if (n / 2) % 2 == 0 { 1.0 } else { -1.0 };
        // Power n of x belongs to the cosine if it is even, to the sine if it is odd.
        rows[n / 4][2 * (n % 2) + (n / 2) % 2] = sign / factorial;
        n += 1;
        factorial *= n as f64;
    }
    rows
};

/// Cosine and sine of an angle of at most [`LARGEST_ANGLE`] either way (rad), to a few 1e-16: their power series.
#[inline(always)]
pub fn cos_sin<F: Real>(x: F) -> (F, F) {
    let (x, xx, x4) = powers(x);
    let mut a = COS_SIN[5].map(F::splat);
    for row in [4, 3, 2, 1, 0] {
        for i in 0..4 {
            a[i] = times_plus(a[i], x4, F::splat(COS_SIN[row][i]));
        }
    }
    (times_plus(xx, a[1], a[0]), x * times_plus(xx, a[3], a[2]))
}

/// The arc tangent of `q`, to some 1e-8, for |q| < 0.25.
#[inline(always)]
pub fn small_arc_tangent<F: Real>(q: F) -> F {
    let qq = q * q;
    let c = |x: f64| F::splat(x);
    q * times_plus(qq, times_plus(qq, times_plus(qq, times_plus(qq, c(1.0 / 9.0), c(-1.0 / 7.0)), c(0.2)), c(-1.0 / 3.0)), c(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_those_of_the_powers() {
        let c: [f64; TERMS] = std::array::from_fn(|k| ((7 * k + 3) % 11) as f64 - 5.0 + 0.25 * k as f64);
        for t in [-1.5, -0.3, 0.0, 0.1, 0.9, 2.0] {
            let powers = |k: i32| f64::powi(t, k);
            let v: f64 = (0..TERMS).map(|k| c[k] * powers(k as i32)).sum();
            let s: f64 = (1..TERMS).map(|k| k as f64 * c[k] * powers(k as i32 - 1)).sum();
            let size: f64 = (0..TERMS).map(|k| (k as f64 * c[k] * powers(k as i32)).abs()).sum::<f64>().max(1.0);
            let (found, slope) = value_and_slope(&c, t);
            assert!((found - v).abs() < 1e-15 * size && (slope - s).abs() < 1e-14 * size && value(&c, t) == found, "{t}");
        }
    }

    #[test]
    fn cosines_and_sines_are_those_of_the_library() {
        for i in -1000..=1000 {
            let x = f64::from(i) * 1e-3 * LARGEST_ANGLE;
            let (cos, sin) = cos_sin(x);
            let off = (cos - x.cos()).abs().max((sin - x.sin()).abs());
            assert!(off < 1e-15, "{x}: {off:e}");
        }
    }

    #[test]
    fn small_angles_are_near_the_arc_tangent() {
        for i in -1000..=1000 {
            let tangent = 0.25e-3 * f64::from(i);
            assert!((small_arc_tangent(tangent) - tangent.atan()).abs() < 3e-8, "{tangent}");
        }
    }
}
