//! Roots of functions of one number.

/// Where `f` is 0 between `a` and `b`, where it has different signs; `rising` if that at `a` is below 0: regula falsi, kept in bounds (the
/// Illinois variant; Dowell and Jarratt 1971).
pub fn root(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64, rising: bool) -> f64 {
    let sign = if rising { 1.0 } else { -1.0 };
    let (mut fa, mut fb) = ((sign * f(a)).min(0.0), (sign * f(b)).max(0.0));
    let mut side = 0;
    for _ in 0..100 {
        if fb == 0.0 || b - a <= f64::EPSILON * b.abs() {
            return b;
        }
        let middle = (a + (b - a) * (fa / (fa - fb))).clamp(a, b);
        let value = sign * f(middle);
        if value == 0.0 || middle == a || middle == b {
            return middle;
        }
        if value > 0.0 {
            (b, fb) = (middle, value);
            fa *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            (a, fa) = (middle, value);
            fb *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_whatever_the_sign() {
        for target in [0.1, 1.0, 7.5] {
            let found = root(|x| x * x * x - target, 0.0, 2.0, true);
            assert!((found.powi(3) - target).abs() < 1e-14 * target.max(1.0), "{found}");
            let found = root(|x| target - x.exp(), -5.0, 5.0, false);
            assert!((found.exp() / target - 1.0).abs() < 1e-14, "{found}");
        }
        assert_eq!(root(|x| x, 0.0, 1.0, true), 0.0);
    }
}
