//! Colours of smooth spectra as sums over wavelengths, with their derivatives: all that the fit of a spectrum spends time on.

use crate::colorimetry::colorimetry;
use glam::{DMat3, DVec3};
use std::sync::OnceLock;

/// So many wavelengths are worked on at once.
const LANES: usize = 8;

/// Every so many of the observer's wavelengths enter a coarse sum.
const STRIDE: usize = 10;

/// Equally spaced wavelengths over the observer's range, and what a reflectance of 1 at each adds to red, green and blue.
pub(crate) struct Quadrature {
    groups: Vec<Group>,
}

/// Wavelengths side by side; the last ones of the last group have no weight.
struct Group {
    /// From -1 to 1 over the observer's range.
    t: [f64; LANES],
    weights: [[f64; LANES]; 3],
}

impl Quadrature {
    /// All of the observer's wavelengths; an immutable cache.
    pub fn fine() -> &'static Self {
        static CACHE: OnceLock<Quadrature> = OnceLock::new();
        CACHE.get_or_init(|| Self::new(&colorimetry().reflectance_weights))
    }

    /// Every tenth wavelength; an immutable cache.
    pub fn coarse() -> &'static Self {
        static CACHE: OnceLock<Quadrature> = OnceLock::new();
        CACHE.get_or_init(|| Self::new(&coarse_weights()))
    }

    fn new(weights: &[[f64; 3]]) -> Self {
        let scale = 2.0 / (weights.len() - 1) as f64;
        let group = |(g, rows): (usize, &[[f64; 3]])| Group {
            t: std::array::from_fn(|l| (g * LANES + l) as f64 * scale - 1.0),
            weights: std::array::from_fn(|k| std::array::from_fn(|l| rows.get(l).map_or(0.0, |row| row[k]))),
        };
        Self { groups: weights.chunks(LANES).enumerate().map(group).collect() }
    }

    /// The colour of the spectrum `s(c.x t^2 + c.y t + c.z)`, s the sigmoid, and its derivative by `c`.
    pub fn colour(&self, c: DVec3) -> (DVec3, DMat3) {
        // Sums of colour, and of its derivatives by the three coefficients, for each channel.
        let mut sums = [[[0.0; LANES]; 4]; 3];
        for Group { t, weights } in &self.groups {
            let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let x = (c.x * t[l] + c.y) * t[l] + c.z;
                let inverse_root = 1.0 / (1.0 + x * x).sqrt();
                value[l] = 0.5 + 0.5 * x * inverse_root;
                slope[l] = 0.5 * inverse_root * inverse_root * inverse_root;
            }
            for (sums, weights) in sums.iter_mut().zip(weights) {
                for l in 0..LANES {
                    let by_constant = weights[l] * slope[l];
                    let by_linear = by_constant * t[l];
                    sums[0][l] += weights[l] * value[l];
                    sums[1][l] += by_linear * t[l];
                    sums[2][l] += by_linear;
                    sums[3][l] += by_constant;
                }
            }
        }
        let [colour, square, linear, constant] =
            std::array::from_fn(|i| DVec3::from_array(std::array::from_fn(|channel| sums[channel][i].iter().sum())));
        (colour, DMat3::from_cols(square, linear, constant))
    }
}

/// The weights of every tenth wavelength, such that cubics between them are integrated as all the wavelengths do.
fn coarse_weights() -> Vec<[f64; 3]> {
    let fine = &colorimetry().reflectance_weights;
    let last = (fine.len() - 1) / STRIDE;
    let mut coarse = vec![[0.0; 3]; last + 1];
    for (i, weight) in fine.iter().enumerate() {
        let first = (i / STRIDE).saturating_sub(1).min(last - 3);
        let t = i as f64 / STRIDE as f64 - first as f64;
        for k in 0..4 {
            let others = (0..4).filter(|j| *j != k);
            let lagrange: f64 = others.map(|j| (t - j as f64) / (k as f64 - j as f64)).product();
            coarse[first + k].iter_mut().zip(weight).for_each(|(sum, w)| *sum += w * lagrange);
        }
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of spectra with a slope, a hump and a trough.
    const SPECTRA: [[f64; 3]; 3] = [[0.0, 1.5, 0.3], [-4.0, 1.0, 0.5], [3.0, -0.5, -1.0]];

    #[test]
    fn colours_are_plain_sums_and_derivatives_their_differences() {
        for c in SPECTRA.map(DVec3::from_array) {
            let (colour, jacobian) = Quadrature::fine().colour(c);
            let mut plain = DVec3::ZERO;
            for (i, w) in colorimetry().reflectance_weights.iter().enumerate() {
                let t = f64::from(i as u32) / 235.0 - 1.0;
                let x = c.dot(DVec3::new(t * t, t, 1.0));
                plain += DVec3::from_array(*w) * (0.5 + 0.5 * x / x.hypot(1.0));
            }
            assert!((colour - plain).abs().max_element() < 1e-12, "{colour} {plain}");
            for (k, step) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                let [above, below] = [1e-5, -1e-5].map(|h| Quadrature::fine().colour(c + h * step).0);
                assert!(((above - below) / 2e-5 - jacobian.col(k)).abs().max_element() < 1e-8);
            }
        }
    }

    #[test]
    fn coarse_sums_are_near_fine_ones() {
        for c in SPECTRA.map(DVec3::from_array) {
            let [coarse, fine] = [Quadrature::coarse(), Quadrature::fine()].map(|q| q.colour(c).0);
            assert!((coarse - fine).abs().max_element() < 1e-4, "{coarse} {fine}");
        }
    }
}
