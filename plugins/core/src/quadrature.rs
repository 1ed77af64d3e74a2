//! Integrals by the rule of Gauss and Legendre.

use bhs_elementary::Elementary;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Node number `i` of the rule of `nodes` points on 0..1, and its weight.
pub fn gauss_legendre(i: usize, nodes: usize) -> [f64; 2] {
    // Newton's method on the Legendre polynomial from Tricomi's guess of its roots.
    let mut x = (PI * (i as f64 + 0.75) / (nodes as f64 + 0.5)).cosine();
    let mut slope = 1.0;
    for _ in 0..20 {
        let (mut p, mut before) = (1.0, 0.0);
        for k in 0..nodes {
            let k = k as f64;
            (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
        }
        slope = nodes as f64 * (x * p - before) / (x * x - 1.0);
        x -= p / slope;
    }
    [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
}

/// Points of the rule by which [`integral`] goes.
const NODES: usize = 16;

static RULE: LazyLock<[[f64; 2]; NODES]> = LazyLock::new(|| std::array::from_fn(|i| gauss_legendre(i, NODES)));

/// Relative difference between one stretch and its two halves from which the halves are right to rounding: their error is less by some powers.
const AGREEMENT: f64 = 1e-10;

/// Share of the whole integral that is rounding, wherever it stands.
const ROUNDING: f64 = 1e-16;

/// Stretches that are looked at, so that what is not smooth, or noise, comes to an end.
const MOST_STRETCHES: u32 = 2000;

/// The integral of `f` from `a` to `b` by one stretch of 16 points.
pub fn integral_at_once(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    (b - a) * RULE.iter().map(|[node, weight]| weight * f(node.mul_add(b - a, a))).sum::<f64>()
}

/// The integral of `f` from `a` to `b`, to rounding where `f` is smooth: stretches are halved until halving them changes nothing.
///
/// Where `f` is not finite, neither is the integral.
pub fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let rule = |a: f64, b: f64| integral_at_once(&f, a, b);
    // The stretches that are left, the nearest last.
    let mut left = vec![(a, b, rule(a, b))];
    let mut sum = 0.0;
    let mut looked_at = 0;
    while let Some((a, b, whole)) = left.pop() {
        looked_at += 1;
        let middle = 0.5 * (a + b);
        let halves = [rule(a, middle), rule(middle, b)];
        let both = halves[0] + halves[1];
        let differ = (both - whole).abs() > (AGREEMENT * both.abs()).max(ROUNDING * f64::abs(sum));
        // Nothing is gained by halving what is not finite.
        if differ && both.is_finite() && looked_at < MOST_STRETCHES {
            left.extend([(middle, b, halves[1]), (a, middle, halves[0])]);
        } else {
            sum += both;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_of_few_points_integrates_polynomials() {
        for nodes in [1, 2, 5, 16] {
            for power in 0..2 * nodes {
                let sum: f64 = (0..nodes).map(|i| gauss_legendre(i, nodes)).map(|[x, w]| w * x.powi(power as i32)).sum();
                assert!((sum * (power + 1) as f64 - 1.0).abs() < 1e-14, "{nodes} {power}: {sum}");
            }
        }
    }

    #[test]
    fn integrals_are_right_to_rounding() {
        let close = |found: f64, right: f64| assert!((found - right).abs() <= 4e-15 * right.abs(), "{found} is {right}");
        close(integral(f64::exp, -1.0, 2.0), 2f64.exp() - (-1f64).exp());
        // A pole close behind the end, as rays have where they leave.
        close(integral(|x| 1.0 / (x * x), 1e-7, 1.0), 1e7 - 1.0);
        close(integral(|x| x.sqrt(), 0.0, 1.0), 2.0 / 3.0);
        assert_eq!(integral(f64::sin, 0.7, 0.7), 0.0);
        // What is rough comes to an end, too.
        let rough = integral(|x| 1.0 + 1e-3 * (1e9 * x).sin().signum(), 0.0, 1.0);
        assert!((rough - 1.0).abs() < 1e-3, "{rough}");
        assert!(integral(|x| 1.0 / x, 0.0, 1.0) > 20.0);
        assert!(integral(|x| (x - 0.5).sqrt(), 0.0, 1.0).is_nan());
    }
}
