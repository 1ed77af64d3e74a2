//! Polynomials with their derivative, evaluated in short independent chains of operations.

/// `c[0] + c[1] t + c[2] t^2 + ...` and its derivative; an even number of coefficients.
///
/// Even and odd powers apart, each by Horner's rule: four chains half as long as one, which a processor runs side by side.
pub fn value_and_slope(c: &[f64], t: f64) -> (f64, f64) {
    let tt = t * t;
    let (mut even, mut odd, mut even_slope, mut odd_slope) = (0.0, 0.0, 0.0, 0.0);
    for pair in c.chunks_exact(2).rev() {
        even_slope = even_slope * tt + even;
        odd_slope = odd_slope * tt + odd;
        even = even * tt + pair[0];
        odd = odd * tt + pair[1];
    }
    (even + t * odd, odd + 2.0 * t * (even_slope + t * odd_slope))
}

/// The value alone.
pub fn value(c: &[f64], t: f64) -> f64 {
    let tt = t * t;
    let (mut even, mut odd) = (0.0, 0.0);
    for pair in c.chunks_exact(2).rev() {
        even = even * tt + pair[0];
        odd = odd * tt + pair[1];
    }
    even + t * odd
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_slopes_are_those_of_the_powers() {
        let c = [3.0, -2.0, 0.5, 7.0, -1.0, 0.25];
        for t in [-1.5, 0.0, 0.1, 2.0] {
            let powers = |k: i32| f64::powi(t, k);
            let v: f64 = (0..6).map(|k| c[k as usize] * powers(k)).sum();
            let s: f64 = (1..6).map(|k| f64::from(k) * c[k as usize] * powers(k - 1)).sum();
            let (found, slope) = value_and_slope(&c, t);
            assert!((found - v).abs() < 1e-13 && (slope - s).abs() < 1e-13 && value(&c, t) == found);
        }
    }
}
