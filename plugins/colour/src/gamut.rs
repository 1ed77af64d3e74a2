//! Colours that no screen shows, and the nearest ones of the same hue and lightness that it does.
//!
//! In Ottosson's Oklab (2020, "A perceptual color space for image processing", bottosson.github.io/posts/oklab) a colour loses chroma, at the same lightness
//! and hue, until red, green and blue are not negative. Colours that are k times as bright have coordinates that are the cube root of k as large, so that
//! what is mapped does not depend on the exposure.

use crate::matrix::{inverse, times};
use bhs_elementary::Elementary;

/// From linear sRGB to the responses whose cube roots are mixed (Ottosson's M1 of 2021, for linear sRGB). Its rows add up to 1.
const RESPONSES: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];
const FROM_RESPONSES: [[f64; 3]; 3] = inverse(RESPONSES);

/// From the cube roots to lightness, a and b.
const LAB: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];
const FROM_LAB: [[f64; 3]; 3] = inverse(LAB);

/// Oklab of a linear sRGB colour, which may lie outside of the gamut.
pub fn oklab(rgb: [f64; 3]) -> [f64; 3] {
    times(LAB, times(RESPONSES, rgb).map(Elementary::cube_root))
}

/// The linear sRGB colour of an Oklab one.
pub fn from_oklab(lab: [f64; 3]) -> [f64; 3] {
    times(FROM_RESPONSES, times(FROM_LAB, lab).map(|x| x * x * x))
}

/// The linear sRGB colour of the hue and lightness of `rgb`, and of as much of its chroma as leaves every part between 0 and `ceiling`: `rgb` itself where
/// they are. Black for what is darker than black, white for what is lighter than the ceiling.
pub fn into_gamut(rgb: [f64; 3], ceiling: f64) -> [f64; 3] {
    let is_in = |rgb: [f64; 3]| rgb.iter().all(|x| (0.0..=ceiling).contains(x));
    if is_in(rgb) {
        return rgb;
    }
    let [lightness, a, b] = oklab(rgb);
    // Greys have the cube of their lightness in all parts.
    let grey = lightness.powi(3);
    if lightness <= 0.0 || !grey.is_finite() {
        return [0.0; 3];
    }
    if grey >= ceiling {
        return [ceiling; 3];
    }
    let (mut inside, mut outside) = (0.0, 1.0);
    // To less than single precision tells.
    for _ in 0..32 {
        let middle = 0.5 * (inside + outside);
        match is_in(from_oklab([lightness, middle * a, middle * b])) {
            true => inside = middle,
            false => outside = middle,
        }
    }
    from_oklab([lightness, inside * a, inside * b])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_is_the_published_one() {
        // Ottosson's table: white, and red, green, blue of sRGB as CSS Color 4 has them.
        for (rgb, lab) in [
            ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.62796, 0.22486, 0.12585]),
            ([0.0, 1.0, 0.0], [0.86644, -0.23389, 0.17950]),
            ([0.0, 0.0, 1.0], [0.45201, -0.03246, -0.31153]),
        ] {
            let found = oklab(rgb);
            assert!(found.iter().zip(lab).all(|(a, b): (&f64, f64)| (a - b).abs() < 2e-4), "{rgb:?}: {found:?}");
            let back = from_oklab(found);
            assert!(back.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-9), "{rgb:?}: {back:?}");
        }
    }

    #[test]
    fn hue_and_lightness_stay_whatever_the_exposure() {
        for i in 0..2000u32 {
            let x = |k: u32| f64::from(i.wrapping_mul(2_654_435_761).wrapping_add(k.wrapping_mul(40_503)) % 1009) / 1009.0;
            let rgb = [1.4 * x(1) - 0.4, 1.4 * x(17) - 0.4, 1.4 * x(39) - 0.4];
            let mapped = into_gamut(rgb, f64::INFINITY);
            assert!(mapped.iter().all(|x| *x >= 0.0), "{rgb:?}: {mapped:?}");
            let ([l, a, b], [m, c, d]) = (oklab(rgb), oklab(mapped));
            if l <= 0.0 {
                assert_eq!(mapped, [0.0; 3]);
                continue;
            }
            assert!((l - m).abs() < 1e-6 && (a * d - b * c).abs() < 1e-6 && a * c + b * d >= -1e-9, "{rgb:?}: {mapped:?}");
            assert!(c.hypot(d) <= a.hypot(b) + 1e-6);
            let brighter = into_gamut(rgb.map(|x| 1000.0 * x), f64::INFINITY);
            assert!(brighter.iter().zip(mapped).all(|(a, b)| (a / 1000.0 - b).abs() < 1e-6), "{rgb:?}: {mapped:?} {brighter:?}");
            // No more than it has to.
            if rgb.iter().any(|x| *x < 0.0) {
                assert!(mapped.iter().any(|x| *x < 1e-6), "{rgb:?}: {mapped:?}");
            } else {
                assert_eq!(mapped, rgb);
            }
        }
    }

    #[test]
    fn a_ceiling_is_kept() {
        let mapped = into_gamut([1.3, 0.4, 0.1], 1.0);
        assert!(mapped.iter().all(|x| (0.0..=1.0).contains(x)) && mapped[0] > 0.99 && mapped[1] > 0.4, "{mapped:?}");
        assert_eq!(into_gamut([5.0, 5.0, 5.0], 1.0), [1.0; 3]);
        assert_eq!(into_gamut([-0.1, -0.2, 0.01], 1.0), [0.0; 3]);
    }
}
