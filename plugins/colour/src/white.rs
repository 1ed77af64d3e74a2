//! White: the colour of light of a temperature, and what makes it white.

use crate::matrix::{Matrix, inverse, product, times};
use crate::observer::{D65_XYZ, standard_observer};
use crate::srgb::{SRGB_FROM_XYZ, XYZ_FROM_SRGB};
use bhs_elementary::Elementary;

/// Temperatures that [`white_of`] knows (K).
pub const TEMPERATURES: [f64; 2] = [1000.0, 25_000.0];

/// The temperature of daylight whose white is that of pictures (K): CIE 15, D65.
pub const D65_KELVIN: f64 = 6504.0;

/// The least temperature of daylight (K); below it light is that of a black body.
const LEAST_DAYLIGHT: f64 = 4000.0;

/// Bradford's matrix, from CIE XYZ to the responses in which white points are adapted (Lam 1985; ICC.1:2022, annex E).
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// XYZ, at Y = 1, of light of a temperature (K): of a phase of daylight from 4000 K on (CIE 15:2018, eq. 4.7 to 4.9), below of a black body. Other
/// temperatures count as the nearest of [`TEMPERATURES`].
pub fn white_of(kelvin: f64) -> [f64; 3] {
    let kelvin = kelvin.clamp(TEMPERATURES[0], TEMPERATURES[1]);
    if kelvin < LEAST_DAYLIGHT {
        return black_body(kelvin);
    }
    let t = 1e3 / kelvin;
    let x = match kelvin <= 7000.0 {
        true => 0.244_063 + t * (0.099_11 + t * (2.9678 - t * 4.6070)),
        false => 0.237_040 + t * (0.247_48 + t * (1.9018 - t * 2.0064)),
    };
    let y = -3.000 * x * x + 2.870 * x - 0.275;
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// XYZ of a black body, at Y = 1, by the sum over the observer's table; Planck's law with c2 = 1.4388 cm K.
fn black_body(kelvin: f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for [lambda_nm, bar @ ..] in standard_observer() {
        let power = (lambda_nm / 560.0).powi(-5) / ((1.438_776_877e7 / (lambda_nm * kelvin)).exponential() - 1.0);
        xyz.iter_mut().zip(bar).for_each(|(sum, bar)| *sum += bar * power);
    }
    xyz.map(|x| x / xyz[1])
}

/// Takes XYZ under the white `from` to XYZ under the white `to`, both XYZ (von Kries in Bradford's space).
pub fn bradford(from: [f64; 3], to: [f64; 3]) -> Matrix {
    let (from, to) = (times(BRADFORD, from), times(BRADFORD, to));
    let scale = [[to[0] / from[0], 0.0, 0.0], [0.0, to[1] / from[1], 0.0], [0.0, 0.0, to[2] / from[2]]];
    product(inverse(BRADFORD), product(scale, BRADFORD))
}

/// What, applied to linear sRGB, turns light of the XYZ `from` into light of the XYZ `to`, and other colours with it. `None` where both are the same, and
/// where one is no light.
fn adaptation(from: [f64; 3], to: [f64; 3]) -> Option<Matrix> {
    let is_light = |xyz: [f64; 3]| times(BRADFORD, xyz).iter().all(|x| x.is_finite() && *x > 0.0);
    if !is_light(from) || !is_light(to) || from == to {
        return None;
    }
    Some(product(SRGB_FROM_XYZ, product(bradford(from, to), XYZ_FROM_SRGB)))
}

/// What makes linear sRGB pictures white where light of a temperature (K) falls on white; `None` for daylight of 6504 K, of which they are.
pub fn balance_of(kelvin: f64) -> Option<Matrix> {
    adaptation(white_of(kelvin), white_of(D65_KELVIN))
}

/// What makes the linear sRGB colour `rgb` grey, of the same luminance; `None` if it is grey, or no light.
pub fn balance_of_colour(rgb: [f64; 3]) -> Option<Matrix> {
    let xyz = times(XYZ_FROM_SRGB, rgb);
    adaptation(xyz.map(|x| x / xyz[1]), D65_XYZ)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whites_are_the_published_ones() {
        // CIE 15: D50, D55, D65, D75; illuminant A is a black body of 2856 K.
        for (kelvin, x, y) in [
            (5003.0, 0.3457, 0.3585),
            (5503.0, 0.3324, 0.3474),
            (6504.0, 0.3127, 0.3290),
            (7504.0, 0.2990, 0.3149),
            (2855.5, 0.4476, 0.4074),
        ] {
            let xyz = white_of(kelvin);
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[0] / sum - x).abs() < 2e-4 && (xyz[1] / sum - y).abs() < 2e-4, "{kelvin}: {xyz:?}");
        }
    }

    #[test]
    fn light_of_the_temperature_becomes_white() {
        assert_eq!(balance_of(D65_KELVIN), None);
        // The formula of daylight rounds the white of the table.
        let daylight = times(SRGB_FROM_XYZ, white_of(D65_KELVIN));
        assert!(daylight.iter().all(|x| (x - 1.0).abs() < 1e-3), "{daylight:?}");
        for kelvin in [1000.0, 2700.0, 3999.0, 4001.0, 5000.0, 9000.0, 25_000.0] {
            let m = balance_of(kelvin).expect("another white");
            let balanced = times(m, times(SRGB_FROM_XYZ, white_of(kelvin)));
            assert!(balanced.iter().zip(daylight).all(|(a, b)| (a - b).abs() < 1e-12), "{kelvin}: {balanced:?}");
        }
        // A warm lamp is made colder.
        let [r, _, b] = times(balance_of(3000.0).expect("another white"), [1.0; 3]);
        assert!(b > 1.5 * r, "{r} {b}");
    }

    #[test]
    fn a_colour_becomes_grey() {
        let [r, g, b] = times(balance_of_colour([0.8, 0.5, 0.2]).expect("a colour"), [0.8, 0.5, 0.2]);
        assert!((r - g).abs() < 1e-12 && (g - b).abs() < 1e-12, "{r} {g} {b}");
        assert_eq!(balance_of_colour([0.0; 3]), None);
    }
}
