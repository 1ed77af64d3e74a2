//! The standard observer, the illuminant D65 and sRGB: what an `rgb` in a scene means.
//!
//! XYZ of a radiance L is `integral(L xyzbar) / integral(ybar)`; linear sRGB follows by the matrix of IEC 61966-2-1, computed
//! from its primaries and its white x = 0.3127, y = 0.3290. Films of bhs use the same convention.

use crate::tabulated::{Outside, Tabulated};
use bhs_core::spectrum::Spectrum;
use std::sync::OnceLock;

/// First and last wavelength of the standard observer's table (nm); its steps are 1 nm.
pub const OBSERVER_RANGE: [f32; 2] = [360.0, 830.0];

/// Linear sRGB from XYZ.
const SRGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_904_521, -1.537_383_177_570_093, -0.498_610_760_293_003],
    [-0.969_243_636_280_880, 1.875_967_501_507_721, 0.041_555_057_407_176],
    [0.055_630_079_696_994, -0.203_976_958_888_977, 1.056_971_514_242_879],
];

/// What the data in this module is turned into, once, when the first `rgb` is built.
pub struct Colorimetry {
    /// The illuminant D65, scaled to luminance 1: `integral(D65 ybar) = integral(ybar)`.
    pub d65: Tabulated,
    /// How much the reflectance at each wavelength of the observer's table adds to red, green and blue, as seen under D65;
    /// scaled so that the reflectance 1 is (1, 1, 1).
    pub reflectance_weights: Vec<[f64; 3]>,
}

/// The tables; an immutable cache.
pub fn colorimetry() -> &'static Colorimetry {
    static CACHE: OnceLock<Colorimetry> = OnceLock::new();
    CACHE.get_or_init(|| {
        let (observer, raw) = (observer(), d65_points());
        let raw_d65 = Tabulated::new(&raw, Outside::EndValue);
        let luminance: f64 = observer.iter().map(|[l, _, y, _]| y * f64::from(raw_d65.at(*l as f32))).sum();
        let scale = observer.iter().map(|[_, _, y, _]| y).sum::<f64>() / luminance;
        let d65 = Tabulated::new(&raw.iter().map(|(l, p)| (*l, p * scale)).collect::<Vec<_>>(), Outside::EndValue);

        let mut weights: Vec<[f64; 3]> =
            observer.iter().map(|[l, x, y, z]| srgb_from_xyz([*x, *y, *z]).map(|c| c * f64::from(d65.at(*l as f32)))).collect();
        for c in 0..3 {
            let sum: f64 = weights.iter().map(|w| w[c]).sum();
            weights.iter_mut().for_each(|w| w[c] /= sum);
        }
        Colorimetry { d65, reflectance_weights: weights }
    })
}

/// Linear sRGB of an XYZ colour.
pub fn srgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    SRGB_FROM_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

/// The numbers of a table that belongs to this crate, row by row; lines that do not start with a number are headings.
pub fn rows<const N: usize>(text: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let words = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
        let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
        numbers.try_into().ok()
    };
    text.lines().filter_map(row).collect()
}

/// The standard observer: wavelength (nm) and the three colour matching functions.
pub fn observer() -> Vec<[f64; 4]> {
    rows(include_str!("../data/cie1931_2deg_1nm.csv"))
}

/// The illuminant D65 as published: wavelength (nm) and relative power (100 at 560 nm).
pub fn d65_points() -> Vec<(f64, f64)> {
    rows(include_str!("../data/cie_d65_5nm.csv")).into_iter().map(|[l, p]| (l, p)).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// XYZ of a radiance as films compute it.
    pub fn xyz(radiance: impl Fn(f32) -> f32) -> [f64; 3] {
        let observer = observer();
        let total: f64 = observer.iter().map(|o| o[2]).sum();
        std::array::from_fn(|c| observer.iter().map(|o| o[c + 1] * f64::from(radiance(o[0] as f32))).sum::<f64>() / total)
    }

    #[test]
    fn tables_are_whole() {
        let observer = observer();
        assert_eq!((observer.len(), d65_points().len()), (471, 107));
        assert_eq!(OBSERVER_RANGE, [observer[0][0] as f32, observer[470][0] as f32]);
        assert!((observer.iter().map(|o| o[2]).sum::<f64>() - 106.8569).abs() < 1e-4);
    }

    #[test]
    fn d65_has_its_chromaticity_and_luminance_one() {
        let [x, y, z] = xyz(|l| colorimetry().d65.at(l));
        let sum = x + y + z;
        assert!((x / sum - 0.3127).abs() < 5e-5 && (y / sum - 0.3290).abs() < 5e-5, "x {} y {}", x / sum, y / sum);
        assert!((y - 1.0).abs() < 1e-6);
    }

    #[test]
    fn srgb_matrix_takes_its_white_to_one() {
        let white = [0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290];
        assert!(srgb_from_xyz(white).iter().all(|c| (c - 1.0).abs() < 1e-9));
        // The red primary: x = 0.64, y = 0.33.
        let [r, g, b] = srgb_from_xyz([0.64, 0.33, 0.03]);
        assert!(r > 0.0 && g.abs() < 1e-9 && b.abs() < 1e-9);
    }
}
