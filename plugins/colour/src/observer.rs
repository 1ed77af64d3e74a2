//! The CIE's tables: the 1931 2-degree standard observer and the illuminant D65.

use std::sync::OnceLock;

/// First and last wavelength of the standard observer's table (nm); its steps are 1 nm.
pub const OBSERVER_RANGE: [f32; 2] = [360.0, 830.0];

/// The integral of the colour matching function y over the table (nm): XYZ are divided by it.
pub const Y_INTEGRAL: f64 = 106.856_914_916_767_01;

/// XYZ of the illuminant D65 at Y = 1: integrals over the two tables, both linear between their rows. Its chromaticity rounds to the
/// x = 0.3127, y = 0.3290 of IEC 61966-2-1.
pub const D65_XYZ: [f64; 3] = [0.950_470_650_887_718_8, 1.0, 1.088_815_213_181_332_7];

/// Y of the illuminant D65 with the powers of its table, 100 at 560 nm.
pub const D65_LUMINANCE: f64 = 98.889_808_846_247_09;

/// The numbers of a table, row by row; lines that do not start with a number are headings.
fn rows<const N: usize>(text: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map_while(|w| w.trim().parse().ok()).collect();
        numbers.try_into().ok()
    };
    text.lines().filter_map(row).collect()
}

/// The standard observer: wavelength (nm) and the three colour matching functions, in steps of 1 nm; an immutable cache.
pub fn standard_observer() -> &'static [[f64; 4]] {
    static TABLE: OnceLock<Vec<[f64; 4]>> = OnceLock::new();
    TABLE.get_or_init(|| rows(include_str!("../data/cie1931_2deg_1nm.csv")))
}

/// The illuminant D65 as published: wavelength (nm) and relative power (100 at 560 nm), in steps of 5 nm.
pub fn d65() -> Vec<(f64, f64)> {
    rows(include_str!("../data/cie_d65_5nm.csv")).into_iter().map(|[lambda_nm, power]| (lambda_nm, power)).collect()
}

/// The colour matching functions at any wavelength, in single precision: for the samples of a picture.
pub struct MatchingFunctions {
    rows: Vec<[f32; 3]>,
}

impl MatchingFunctions {
    /// Those of the CIE 1931 2-degree observer, 360 to 830 nm.
    pub fn cie_1931() -> Self {
        Self { rows: standard_observer().iter().map(|[_, bar @ ..]| bar.map(|v| v as f32)).collect() }
    }

    /// The functions x, y, z at a wavelength (nm), linear between the table's rows, zero outside.
    #[inline]
    pub fn at(&self, lambda_nm: f32) -> [f32; 3] {
        let x = lambda_nm - OBSERVER_RANGE[0];
        if !(x >= 0.0 && x <= (self.rows.len() - 1) as f32) {
            return [0.0; 3];
        }
        let i = (x as usize).min(self.rows.len() - 2);
        let t = x - i as f32;
        std::array::from_fn(|k| self.rows[i][k] + t * (self.rows[i + 1][k] - self.rows[i][k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_whole_and_their_integrals_are_the_published_ones() {
        let observer = standard_observer();
        assert_eq!((observer.len(), d65().len()), (471, 107));
        assert_eq!(OBSERVER_RANGE, [observer[0][0] as f32, observer[470][0] as f32]);
        let sums: [f64; 3] = std::array::from_fn(|k| observer.iter().map(|row| row[k + 1]).sum());
        for (sum, published) in sums.into_iter().zip([106.8655, 106.8569, 106.8923]) {
            assert!((sum - published).abs() < 1e-4, "{sum} {published}");
        }
        let trapezia: f64 = observer.windows(2).map(|pair| 0.5 * (pair[0][2] + pair[1][2])).sum();
        assert!((trapezia - Y_INTEGRAL).abs() < 1e-10, "{trapezia}");
    }

    #[test]
    fn matching_functions_end_with_the_table() {
        let functions = MatchingFunctions::cie_1931();
        assert_eq!([functions.at(359.9), functions.at(830.1), functions.at(f32::NAN)], [[0.0; 3]; 3]);
        assert!(functions.at(830.0)[1] > 0.0);
        let [a, half, b] = [555.0, 555.5, 556.0].map(|l| functions.at(l)[1]);
        assert!((half - 0.5 * (a + b)).abs() < 1e-6);
    }

    /// The constant is that of the tables; ASTM E308-01 has 0.95047, 1, 1.08883 for D65 and this observer.
    #[test]
    fn the_white_is_that_of_the_tables() {
        let points = d65();
        let power = |lambda: f64| {
            let i = points.partition_point(|p| p.0 <= lambda).clamp(1, points.len() - 1);
            let ((a, p), (b, q)) = (points[i - 1], points[i]);
            p + (lambda - a) / (b - a) * (q - p)
        };
        // Simpson's rule, which is exact for products of two linear functions.
        let mut xyz = [0.0; 3];
        for pair in standard_observer().windows(2) {
            let [a, b] = [pair[0], pair[1]];
            for (k, sum) in xyz.iter_mut().enumerate() {
                let middle = 0.5 * (a[k + 1] + b[k + 1]) * power(0.5 * (a[0] + b[0]));
                *sum += (a[k + 1] * power(a[0]) + 4.0 * middle + b[k + 1] * power(b[0])) / 6.0;
            }
        }
        assert!((xyz[1] / Y_INTEGRAL - D65_LUMINANCE).abs() < 1e-12 * D65_LUMINANCE, "{}", xyz[1] / Y_INTEGRAL);
        for ((found, white), published) in xyz.map(|v| v / xyz[1]).into_iter().zip(D65_XYZ).zip([0.95047, 1.0, 1.08883]) {
            assert!((found - white).abs() < 1e-12 && (white - published).abs() < 2e-5, "{found} {white} {published}");
        }
    }
}
