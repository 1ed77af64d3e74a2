//! A random sky: as many stars of each brightness and colour as there are in ours, in places of their own.
//!
//! Sources: docs/physics.md, section 16.

use super::{Star, irradiance_of};
use bhs_core::sampling::mix64;
use bhs_elementary::Elementary;
use glam::DVec3;
use std::f64::consts::TAU;

/// Number of stars of our sky that are brighter than the magnitudes -1, 0, 1, ... (Cox 2000, chapter 19).
const BRIGHTER: [f64; 14] =
    [1.0, 4.0, 15.0, 48.0, 171.0, 513.0, 1602.0, 4800.0, 14_000.0, 42_000.0, 121_000.0, 340_000.0, 926_000.0, 2_460_000.0];

/// Nothing but the sun is brighter (mag): Sirius.
const BRIGHTEST: f64 = -1.46;

/// Spectral classes B, A, F, G, K, M: their shares of the stars of the Henry Draper catalogue (Allen 1973, section 118), and the temperatures at
/// their hotter and cooler ends (K).
const CLASSES: [(f64, f64, f64); 6] = [
    (0.11, 25_000.0, 10_000.0),
    (0.22, 10_000.0, 7500.0),
    (0.19, 7500.0, 6000.0),
    (0.14, 6000.0, 5200.0),
    (0.31, 5200.0, 3900.0),
    (0.03, 3900.0, 3000.0),
];

/// The `number` brightest stars of a random sky, in the space of the light; `concentration`: density in the plane z = 0 over that at the poles.
pub fn sky(number: usize, seed: u64, concentration: f64) -> Vec<Star> {
    let star = |i: usize| {
        let state = mix64(mix64(seed) ^ i as u64);
        let u: [f64; 5] = std::array::from_fn(|k| unit(mix64(state.wrapping_add(k as u64 + 1))));
        Star {
            direction: direction(u[0], u[1], concentration),
            irradiance: irradiance_of(magnitude(number as f64 * u[2])),
            temperature: Some(temperature(u[3], u[4])),
        }
    };
    (0..number).map(star).collect()
}

/// A number in (0,1) from random bits.
fn unit(bits: u64) -> f64 {
    ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// The magnitude to which there are `count` stars.
fn magnitude(count: f64) -> f64 {
    // Straight lines between the logarithms, the last of which go on.
    let i = BRIGHTER.partition_point(|n| *n <= count).clamp(1, BRIGHTER.len() - 1) - 1;
    let [a, b] = [BRIGHTER[i], BRIGHTER[i + 1]].map(Elementary::logarithm);
    (i as f64 - 1.0 + (count.logarithm() - a) / (b - a)).max(BRIGHTEST)
}

/// A direction whose density falls off with the height s = |sin b| above the plane as 1/(s + s0): what a thick sheet of stars shows to one within.
fn direction(u: f64, v: f64, concentration: f64) -> DVec3 {
    let signed = 2.0 * u - 1.0;
    let s = if concentration - 1.0 < 1e-6 {
        signed.abs()
    } else {
        let s0 = 1.0 / (concentration - 1.0);
        (s0 * (concentration.power(signed.abs()) - 1.0)).min(1.0)
    };
    let (sin, cos) = (TAU * v).sine_cosine();
    let across = (1.0 - s * s).max(0.0).sqrt();
    DVec3::new(across * cos, across * sin, s.copysign(signed)).normalize()
}

/// A temperature (K): the class by its share, and within it evenly in the logarithm.
fn temperature(u: f64, v: f64) -> f64 {
    let mut rest = u * CLASSES.iter().map(|(share, ..)| share).sum::<f64>();
    let class = CLASSES.iter().find(|(share, ..)| {
        rest -= share;
        rest < 0.0
    });
    let (_, hot, cool) = class.unwrap_or(&CLASSES[CLASSES.len() - 1]);
    hot * (cool / hot).power(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_stars_of_each_magnitude_as_in_the_sky() {
        let stars = sky(42_000, 7, 4.0);
        for (m, count) in [(4.0, 513.0), (6.0, 4800.0), (7.0, 14_000.0)] {
            let brighter = stars.iter().filter(|s| s.irradiance > irradiance_of(m)).count() as f64;
            // Five standard deviations of a count.
            assert!((brighter - count).abs() < 5.0 * f64::sqrt(count), "{m}: {brighter} {count}");
        }
        assert!(stars.iter().all(|s| s.irradiance >= irradiance_of(8.0 + 1e-9) && s.irradiance <= irradiance_of(-1.46 - 1e-9)));
        assert_eq!(stars, sky(42_000, 7, 4.0));
        assert_ne!(stars[0], sky(42_000, 8, 4.0)[0]);
    }

    #[test]
    fn stars_crowd_towards_the_plane() {
        for concentration in [1.0, 4.0, 20.0] {
            let stars = sky(200_000, 1, concentration);
            // Bands of equal solid angle at the plane and at both poles.
            let within = |lo: f64, hi: f64| stars.iter().filter(|s| (lo..hi).contains(&s.direction.z.abs())).count() as f64;
            // The integral of 1/(s + s0) over each band.
            let share = |lo: f64, hi: f64| {
                if concentration == 1.0 {
                    return hi - lo;
                }
                let s0 = 1.0 / (concentration - 1.0);
                ((hi + s0) / (lo + s0)).ln() / concentration.ln()
            };
            for (lo, hi) in [(0.0, 0.05), (0.45, 0.5), (0.95, 1.1)] {
                let expected = 200_000.0 * share(lo, f64::min(hi, 1.0));
                assert!((within(lo, hi) - expected).abs() < 5.0 * expected.sqrt(), "{concentration} {lo}");
            }
            let mean = stars.iter().map(|s| s.direction).sum::<DVec3>() / 200_000.0;
            assert!(mean.length() < 0.01, "{mean}");
        }
    }

    #[test]
    fn temperatures_have_the_shares_of_their_classes() {
        let stars = sky(100_000, 3, 1.0);
        let share = |lo: f64, hi: f64| {
            stars.iter().filter_map(|s| s.temperature).filter(|t| (lo..hi).contains(t)).count() as f64 / 100_000.0
        };
        assert!((share(3900.0, 5200.0) - 0.31).abs() < 0.01 && (share(7500.0, 10_000.0) - 0.22).abs() < 0.01);
        assert!(share(3000.0, 25_000.1) > 0.99999);
    }
}
