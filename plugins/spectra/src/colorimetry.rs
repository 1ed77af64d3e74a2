//! What an `rgb` in a scene means, from the tables of `bhs_colour`: the illuminant D65 as a spectrum, and the colours of reflectances under it.

use crate::tabulated::{Outside, Tabulated};
use bhs_colour::{D65_LUMINANCE, srgb_from_xyz, standard_observer};
use bhs_core::spectrum::Spectrum;
use std::sync::{Arc, OnceLock};

/// What the tables are turned into, once, when the first `rgb` is built.
pub struct Colorimetry {
    /// The illuminant D65, scaled to luminance 1: `integral(D65 ybar) = integral(ybar)`.
    pub d65: Arc<Tabulated>,
    /// How much the reflectance at each wavelength of the observer's table adds to red, green and blue, as seen under D65;
    /// scaled so that the reflectance 1 is (1, 1, 1).
    pub reflectance_weights: Vec<[f64; 3]>,
}

/// The tables; an immutable cache.
pub fn colorimetry() -> &'static Colorimetry {
    static CACHE: OnceLock<Colorimetry> = OnceLock::new();
    CACHE.get_or_init(|| {
        let points: Vec<_> = bhs_colour::d65().into_iter().map(|(lambda_nm, power)| (lambda_nm, power / D65_LUMINANCE)).collect();
        let d65 = Arc::new(Tabulated::new(&points, Outside::EndValue));
        let mut weights: Vec<[f64; 3]> = standard_observer()
            .iter()
            .map(|[l, x, y, z]| srgb_from_xyz([*x, *y, *z]).map(|c| c * f64::from(d65.at(*l as f32))))
            .collect();
        for c in 0..3 {
            // The integral of y-bar, but for 2e-5: sums over whole nanometres.
            let sum: f64 = weights.iter().map(|w| w[c]).sum();
            weights.iter_mut().for_each(|w| w[c] /= sum);
        }
        Colorimetry { d65, reflectance_weights: weights }
    })
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// XYZ of a radiance as films compute it.
    pub fn xyz(radiance: impl Fn(f32) -> f32) -> [f64; 3] {
        let observer = standard_observer();
        let total: f64 = observer.iter().map(|o| o[2]).sum();
        std::array::from_fn(|c| observer.iter().map(|o| o[c + 1] * f64::from(radiance(o[0] as f32))).sum::<f64>() / total)
    }

    #[test]
    fn d65_has_its_chromaticity_and_is_white() {
        let [x, y, z] = xyz(|l| colorimetry().d65.at(l));
        let sum = x + y + z;
        assert!((x / sum - 0.3127).abs() < 5e-5 && (y / sum - 0.3290).abs() < 5e-5, "x {} y {}", x / sum, y / sum);
        assert!((y - 1.0).abs() < 1e-5, "{y}");
        let rgb = srgb_from_xyz([x, y, z]);
        assert!(rgb.iter().all(|c| (c - 1.0).abs() < 2e-5), "{rgb:?}");
    }
}
