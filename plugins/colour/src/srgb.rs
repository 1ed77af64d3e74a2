//! sRGB (IEC 61966-2-1): its primaries, its matrix and its curve.

use crate::matrix::{dot, inverse, xyz_from_primaries};
use bhs_elementary::Elementary;

/// Chromaticities (CIE 1931 x, y) of red, green and blue.
pub const SRGB_PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// XYZ of linear sRGB (the rows are X, Y, Z): the primaries, in the amounts that make the white [`D65_XYZ`](crate::D65_XYZ).
pub const XYZ_FROM_SRGB: [[f64; 3]; 3] = xyz_from_primaries(SRGB_PRIMARIES);

/// Linear sRGB of XYZ (the rows are R, G, B): the inverse of [`XYZ_FROM_SRGB`], so that the illuminant D65 of luminance 1 is (1, 1, 1).
pub const SRGB_FROM_XYZ: [[f64; 3]; 3] = inverse(XYZ_FROM_SRGB);

/// Shares of red, green and blue in the luminance.
pub const LUMINANCE: [f64; 3] = XYZ_FROM_SRGB[1];

/// Linear sRGB of XYZ.
#[inline]
pub const fn srgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    [dot(SRGB_FROM_XYZ[0], xyz), dot(SRGB_FROM_XYZ[1], xyz), dot(SRGB_FROM_XYZ[2], xyz)]
}

/// Luminance of a linear sRGB colour.
#[inline]
pub fn luminance(rgb: [f32; 3]) -> f64 {
    dot(LUMINANCE, rgb.map(f64::from))
}

/// The sRGB encoding of a linear value, clipped to 0..1.
pub fn srgb_encode(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.power(1.0 / 2.4) - 0.055 }
}

/// The linear value of one encoded in sRGB, 0 to 1.
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).power(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{D65_LUMINANCE, D65_XYZ, MatchingFunctions, Y_INTEGRAL, d65};

    /// The matrix that Lindbloom publishes for sRGB and the D65 of ASTM E308, 0.95047, 1, 1.08883 (brucelindbloom.com, "RGB/XYZ Matrices").
    #[test]
    fn the_matrix_is_the_published_one() {
        let published = [
            [3.240_454_2, -1.537_138_5, -0.498_531_4],
            [-0.969_266_0, 1.876_010_8, 0.041_556_0],
            [0.055_643_4, -0.204_025_9, 1.057_225_2],
        ];
        for (a, b) in SRGB_FROM_XYZ.as_flattened().iter().zip(published.as_flattened()) {
            assert!((a - b).abs() < 4e-5, "{a} {b}");
        }
        for (a, b) in LUMINANCE.iter().zip([0.212_672_9, 0.715_152_2, 0.072_175_0]) {
            assert!((a - b).abs() < 4e-5, "{a} {b}");
        }
    }

    #[test]
    fn primaries_are_red_green_and_blue() {
        for (k, [x, y]) in SRGB_PRIMARIES.into_iter().enumerate() {
            let rgb = srgb_from_xyz([x, y, 1.0 - x - y]);
            assert!(rgb[k] > 0.0 && (0..3).all(|other| other == k || rgb[other].abs() < 1e-14), "{rgb:?}");
        }
    }

    /// By a sum of single wavelengths, a hundred a nanometre, as a film would see them.
    #[test]
    fn daylight_is_white() {
        let (functions, points) = (MatchingFunctions::cie_1931(), d65());
        let power = |lambda: f64| {
            let i = points.iter().rposition(|p| p.0 <= lambda).expect("within the table").min(points.len() - 2);
            let ((a, p), (b, q)) = (points[i], points[i + 1]);
            (p * (b - lambda) + q * (lambda - a)) / (b - a) / D65_LUMINANCE
        };
        let mut xyz = [0.0; 3];
        for i in 0..47_000 {
            let lambda = 360.005 + f64::from(i) / 100.0;
            let bar = functions.at(lambda as f32);
            xyz.iter_mut().zip(bar).for_each(|(sum, bar)| *sum += f64::from(bar) * power(lambda) / 100.0 / Y_INTEGRAL);
        }
        let rgb = srgb_from_xyz(xyz);
        assert!(rgb.iter().all(|c| (c - 1.0).abs() < 1e-6), "{rgb:?}");
        assert!(srgb_from_xyz(D65_XYZ).iter().all(|c| (c - 1.0).abs() < 1e-14));
    }

    #[test]
    fn the_curve_goes_there_and_back() {
        assert!((srgb_encode(0.214_041) - 0.5).abs() < 1e-4);
        for i in 0..=255 {
            let encoded = i as f32 / 255.0;
            assert!((srgb_encode(srgb_decode(encoded)) - encoded).abs() < 1e-6, "{encoded}");
        }
    }
}
