//! Gradient noise of two and of three coordinates, and sums of it in octaves: what the noisy textures have in common.
//!
//! Perlin 2002, "Improving Noise"; in two dimensions with gradients of all directions. Sums as in pbrt-v4, but with an exact factor of 2 from
//! octave to octave, so that a pattern can go round.

use crate::mapping::{Mapping, Named, read};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::sampling::mix64;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::Texture;
use bhs_elementary::Elementary;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Octaves, each half as large as the one before and `roughness` times as strong.
#[derive(Clone, Copy, Debug)]
pub struct Octaves {
    /// How many there are.
    pub octaves: u32,
    /// What an octave has of the one before.
    pub roughness: f64,
}

impl Octaves {
    /// Reads the parameters.
    pub fn read(p: &Params) -> Self {
        let octaves = p.get_in("octaves", 8, 1..=32, "", "how many sizes of noise are added, each half of the one before") as u32;
        let roughness = p.get_in("roughness", 0.5, 0.0..=1.0, "", "strength of each over that of the one before");
        Self { octaves, roughness }
    }

    /// The sum of what `of` says of each octave: its number and its factor of places.
    fn sum(self, of: impl Fn(u32, f64) -> f64) -> f64 {
        let (mut scale, mut strength, mut sum) = (1.0, 1.0, 0.0);
        for octave in 0..self.octaves {
            sum += strength * of(octave, scale);
            scale *= 2.0;
            strength *= self.roughness;
        }
        sum
    }

    /// Noise of points of space.
    pub fn in_space(self, p: DVec3) -> f64 {
        self.sum(|octave, scale| noise3(p * scale, u64::from(octave)))
    }
}

/// A texture of such a sum, of the noise as a function changes it.
pub struct Fractal {
    octaves: Octaves,
    offset: f64,
    mapping: Named,
    of: fn(f64) -> f64,
}

impl Fractal {
    /// That which the parameters ask for.
    pub fn read(p: &Params, of: fn(f64) -> f64) -> Self {
        let octaves = Octaves::read(p);
        let offset = p.get_in("offset", 0.0, -1e6..=1e6, "", "added to the sum");
        let about = "what the noise is of: `uv`, `spherical`, `cylindrical`, `planar` places, or points of `space`";
        let mapping = read(p, &["uv", "spherical", "cylindrical", "planar", "space"], about);
        Self { octaves, offset, mapping, of }
    }

    fn plane(&self, mapping: &Mapping, at: &Shading) -> f64 {
        let place = mapping.place(at).as_dvec2();
        let period = mapping.turns();
        self.octaves.sum(|octave, scale| {
            let period = period.map(|p| p << octave);
            (self.of)(noise(place * scale, u64::from(octave), period))
        })
    }
}

impl Texture for Fractal {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        SampledSpectrum::splat(self.float(at))
    }

    fn float(&self, at: &Shading) -> f32 {
        let sum = match &self.mapping {
            Named::Plane(mapping) => self.plane(mapping, at),
            Named::Space(space) => {
                let place = space.place(at);
                self.octaves.sum(|octave, scale| (self.of)(noise3(place * scale, u64::from(octave))))
            }
        };
        (sum + self.offset) as f32
    }
}

/// Perlin's curve of the fifth degree.
fn fade(f: f64) -> f64 {
    f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
}

/// Noise of points of space, between -1 and 1, 0 at whole coordinates.
pub fn noise3(p: DVec3, seed: u64) -> f64 {
    let (corner, f) = (p.floor(), p - p.floor());
    let corner_at = |i: u32| {
        let d = DVec3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from(i >> 2));
        let cell = (corner + d).to_array().map(|c| c as i64 as u64);
        let hash = mix64(mix64(mix64(mix64(cell[0]) ^ cell[1]) ^ cell[2]) ^ seed) >> 32;
        // Towards the middle of one of the twelve edges of a cube.
        let (a, b) = (if hash & 1 == 0 { 1.0 } else { -1.0 }, if hash & 2 == 0 { 1.0 } else { -1.0 });
        let gradient = match (hash >> 2) % 3 {
            0 => DVec3::new(a, b, 0.0),
            1 => DVec3::new(a, 0.0, b),
            _ => DVec3::new(0.0, a, b),
        };
        gradient.dot(f - d)
    };
    let t = f.to_array().map(fade);
    let along_x = |i: u32| corner_at(i) * (1.0 - t[0]) + corner_at(i + 1) * t[0];
    let along_y = |i: u32| along_x(i) * (1.0 - t[1]) + along_x(i + 2) * t[1];
    along_y(0) * (1.0 - t[2]) + along_y(4) * t[2]
}

/// Noise between -1 and 1, 0 at whole coordinates. With a period it repeats after so many units of the first.
pub fn noise(p: DVec2, seed: u64, period: Option<i64>) -> f64 {
    let (corner, f) = (p.floor(), p - p.floor());
    let fade = DVec2::new(fade(f.x), fade(f.y));
    let corner_at = |dx: f64, dy: f64| {
        let (x, y) = ((corner.x + dx) as i64, (corner.y + dy) as i64);
        let x = period.map_or(x, |period| x.rem_euclid(period));
        let hash = mix64(mix64(mix64(x as u64) ^ y as u64) ^ seed);
        let (sin, cos) = ((hash >> 11) as f64 / (1u64 << 53) as f64 * TAU).sine_cosine();
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

    #[test]
    fn noise_of_space_is_smooth_and_bounded() {
        let (mut sum, mut square, n) = (0.0, 0.0, 20_000);
        for i in 0..n {
            let p = DVec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2)) * 60.0 - 30.0;
            let value = noise3(p, 2);
            assert!(value.abs() <= 1.1, "{value}");
            assert!((noise3(p + DVec3::splat(1e-5), 2) - value).abs() < 3e-4);
            sum += value;
            square += value * value;
        }
        assert_eq!(noise3(DVec3::new(2.0, -3.0, 5.0), 1), 0.0);
        let (mean, variance) = (sum / n as f64, square / n as f64);
        assert!(mean.abs() < 0.02 && (0.03..0.3).contains(&variance), "{mean} {variance}");
    }
}
