//! Gradient noise of two coordinates, and sums of it in octaves: what `fbm` and `wrinkled` have in common.
//!
//! Perlin 2002, "Improving Noise", in two dimensions, with gradients of all directions; sums as in pbrt-v4, but with an exact factor of 2 from
//! octave to octave, so that a pattern can go round.

use crate::mapping::UvMapping;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::sampling::mix64;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::Texture;
use glam::DVec2;
use std::f64::consts::TAU;

/// A sum of octaves of noise, as the parameters of a texture ask for it.
struct Octaves {
    octaves: u32,
    /// What an octave has of the one before.
    roughness: f64,
    offset: f64,
    mapping: UvMapping,
}

impl Octaves {
    /// Reads the parameters.
    fn read(p: &Params) -> Self {
        let octaves = p.get_in("octaves", 8, 1..=32, "", "how many sizes of noise are added, each half of the one before") as u32;
        let roughness = p.get_in("roughness", 0.5, 0.0..=1.0, "", "strength of each over that of the one before");
        let offset = p.get_in("offset", 0.0, -1e6..=1e6, "", "added to the sum");
        Self { octaves, roughness, offset, mapping: UvMapping::read(p) }
    }

    /// The sum at a point, of the noise as `of` changes it.
    fn at(&self, at: &Shading, of: impl Fn(f64) -> f64) -> f32 {
        let place = self.mapping.place(at).as_dvec2();
        let mut period = self.mapping.turns();
        let (mut scale, mut strength, mut sum) = (1.0, 1.0, 0.0);
        for octave in 0..self.octaves {
            sum += strength * of(noise(place * scale, u64::from(octave), period));
            scale *= 2.0;
            strength *= self.roughness;
            period = period.map(|p| 2 * p);
        }
        (sum + self.offset) as f32
    }
}

/// A texture of such a sum, of the noise as a function changes it.
pub struct Fractal {
    octaves: Octaves,
    of: fn(f64) -> f64,
}

impl Fractal {
    /// That which the parameters ask for.
    pub fn read(p: &Params, of: fn(f64) -> f64) -> Self {
        Self { octaves: Octaves::read(p), of }
    }
}

impl Texture for Fractal {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        SampledSpectrum::splat(self.float(at))
    }

    fn float(&self, at: &Shading) -> f32 {
        self.octaves.at(at, self.of)
    }
}

/// Noise between -1 and 1, 0 at whole coordinates. With a period it repeats after so many units of the first.
fn noise(p: DVec2, seed: u64, period: Option<i64>) -> f64 {
    let (corner, f) = (p.floor(), p - p.floor());
    // Perlin's curve of the fifth degree.
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner_at = |dx: f64, dy: f64| {
        let (x, y) = ((corner.x + dx) as i64, (corner.y + dy) as i64);
        let x = period.map_or(x, |period| x.rem_euclid(period));
        let hash = mix64(mix64(mix64(x as u64) ^ y as u64) ^ seed);
        let (sin, cos) = ((hash >> 11) as f64 / (1u64 << 53) as f64 * TAU).sin_cos();
        DVec2::new(cos, sin).dot(f - DVec2::new(dx, dy))
    };
    let row = |dy: f64| corner_at(0.0, dy) * (1.0 - fade.x) + corner_at(1.0, dy) * fade.x;
    std::f64::consts::SQRT_2 * (row(0.0) * (1.0 - fade.y) + row(1.0) * fade.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(i: u64) -> f64 {
        (mix64(i) >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn noise_is_smooth_bounded_and_goes_round() {
        let (mut sum, mut square, n) = (0.0, 0.0, 20_000);
        for i in 0..n {
            let p = DVec2::new(number(2 * i) * 7.0, number(2 * i + 1) * 100.0 - 50.0);
            let value = noise(p, 3, Some(7));
            assert!(value.abs() <= 1.0);
            assert!((noise(p + DVec2::new(7.0, 0.0), 3, Some(7)) - value).abs() < 1e-12);
            // The slope of unit gradients, blended by a curve of slope 1.875, is below some 8.
            assert!((noise(p + DVec2::splat(1e-5), 3, Some(7)) - value).abs() < 2e-4);
            sum += value;
            square += value * value;
        }
        assert_eq!(noise(DVec2::new(2.0, -3.0), 1, None), 0.0);
        // It varies, about 0.
        let (mean, variance) = (sum / n as f64, square / n as f64);
        assert!(mean.abs() < 0.02 && (0.05..0.3).contains(&variance), "{mean} {variance}");
    }
}
