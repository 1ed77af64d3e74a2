//! Emission of very many colours, such as the pixels of a sky: sums of a few spectra that are made once.
//!
//! A colour is white as far as it goes, then the secondary colour of its two larger components, then the primary one of its largest
//! (Smits 1999, "An RGB-to-Spectrum Conversion for Reflectances"), each with the smooth spectrum of Jakob and Hanika, times D65.
//! Colours add up, so that a film shows the sum as the colour itself; greys are D65. The one spectrum that the type `rgb` makes of a
//! colour is smoother, but has to be fitted.

use crate::colorimetry::colorimetry;
use crate::upsample::Sigmoid;
use bhs_colour::OBSERVER_RANGE;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum};
use std::sync::OnceLock;

/// White, cyan, magenta, yellow, red, green, blue; the secondary colours in the order of the component that they lack.
const BASIS: usize = 7;

/// The basis in steps of 1 nm over the observer's range; an immutable cache.
fn basis() -> &'static Vec<[f32; BASIS]> {
    static CACHE: OnceLock<Vec<[f32; BASIS]>> = OnceLock::new();
    CACHE.get_or_init(|| {
        let colours = [[0., 1., 1.], [1., 0., 1.], [1., 1., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
        let shapes: Vec<Sigmoid> = colours.into_iter().map(Sigmoid::fit).collect();
        let [lo, hi] = OBSERVER_RANGE;
        (0..=(hi - lo) as u32)
            .map(|i| {
                let lambda = lo + i as f32;
                let d65 = colorimetry().d65.at(lambda);
                std::array::from_fn(|k| d65 * if k == 0 { 1.0 } else { shapes[k - 1].at(lambda) })
            })
            .collect()
    })
}

/// The spectral radiance at the given wavelengths (nm) that a film shows as the linear sRGB colour `rgb`, whose components are not
/// negative. Outside 360..830 nm it keeps its end value.
pub fn rgb_emission(rgb: [f32; 3], lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
    let weights = weights(rgb);
    let basis = basis();
    SampledSpectrum(lambda_nm.map(|lambda| {
        let x = (lambda - OBSERVER_RANGE[0]).clamp(0.0, (basis.len() - 1) as f32);
        let i = (x as usize).min(basis.len() - 2);
        let t = x - i as f32;
        weights.iter().map(|(k, w)| w * (basis[i][*k] * (1.0 - t) + basis[i + 1][*k] * t)).sum()
    }))
}

/// The three members of the basis that a colour is made of, and how much of each.
fn weights(rgb: [f32; 3]) -> [(usize, f32); 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| rgb[*a].total_cmp(&rgb[*b]));
    let [least, middle, most] = order;
    [(0, rgb[least]), (1 + least, rgb[middle] - rgb[least]), (4 + most, rgb[most] - rgb[middle])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colorimetry::tests::xyz;
    use bhs_colour::srgb_from_xyz;

    #[test]
    fn films_show_the_colour_itself() {
        for i in 0..125u32 {
            let rgb = [i % 5, i / 5 % 5, i / 25].map(|c| c as f32 * 0.75);
            let back = srgb_from_xyz(xyz(|l| rgb_emission(rgb, [l; N_LAMBDA])[0]));
            for c in 0..3 {
                assert!((back[c] - f64::from(rgb[c])).abs() < 2e-3, "{rgb:?} {back:?}");
            }
        }
    }

    #[test]
    fn greys_are_d65_and_ends_go_on() {
        let grey = rgb_emission([2.0; 3], [450.0, 555.5, 100.0, 3000.0]);
        let d65 = colorimetry().d65.sample([450.0, 555.5, 360.0, 830.0]) * 2.0;
        assert!((grey - d65).map(f32::abs).max() < 1e-3 * d65.max(), "{grey:?} {d65:?}");
    }
}
