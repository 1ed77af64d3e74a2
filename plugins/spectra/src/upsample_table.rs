//! The smooth spectra of all colours, tabulated: for pictures, in which each texel has a colour of its own.
//!
//! As in Jakob and Hanika 2019, section 4: three tables, one for each channel that may be the largest; its value is one coordinate,
//! spaced more closely towards black and white, where the coefficients change fastest, and the other two channels over it are the
//! others. Coefficients are interpolated trilinearly. The table is made when it is first asked for, in a fraction of a second.

use crate::quadrature::Quadrature;
use crate::upsample::{MARGIN, Sigmoid, solve};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Entries along each coordinate.
const N: usize = 32;

/// Spectra of colours, by table.
pub struct SmoothSpectra {
    /// Coefficients by largest channel, its value, and the next two channels over it.
    coefficients: Vec<[f32; 3]>,
    /// The values of the largest channel.
    levels: Vec<f32>,
}

impl SmoothSpectra {
    /// The table; an immutable cache.
    pub fn get() -> &'static Self {
        static CACHE: OnceLock<SmoothSpectra> = OnceLock::new();
        CACHE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let step = |x: f64| x * x * (3.0 - 2.0 * x);
        let levels: Vec<f64> = (0..N).map(|i| step(step(i as f64 / (N - 1) as f64))).collect();
        // A column is a colour from black to white: each fit starts from its neighbour's, away from a middle where any start will do.
        let column = |i: usize| -> Vec<[f32; 3]> {
            let (channel, x, y) = (i / (N * N), i / N % N, i % N);
            let over = |k: usize| k as f64 / (N - 1) as f64;
            let goal = |level: f64| {
                let mut rgb = [0.0; 3];
                rgb[channel] = level;
                rgb[(channel + 1) % 3] = level * over(x);
                rgb[(channel + 2) % 3] = level * over(y);
                DVec3::from_array(rgb).clamp(DVec3::splat(MARGIN), DVec3::splat(1.0 - MARGIN))
            };
            let middle = N / 5;
            let mut column = vec![DVec3::ZERO; N];
            let mut c = DVec3::ZERO;
            for k in middle..N {
                c = solve(c, goal(levels[k]), Quadrature::coarse()).c;
                column[k] = c;
            }
            c = column[middle];
            for k in (0..middle).rev() {
                c = solve(c, goal(levels[k]), Quadrature::coarse()).c;
                column[k] = c;
            }
            column.into_iter().map(|c| c.as_vec3().to_array()).collect()
        };
        let columns: Vec<Vec<[f32; 3]>> = (0..3 * N * N).into_par_iter().map(column).collect();
        Self { coefficients: columns.concat(), levels: levels.iter().map(|l| *l as f32).collect() }
    }

    /// The function whose colour under D65 is `rgb` (linear sRGB, each between 0 and 1), to within 4e-3 (1e-3 on average).
    pub fn of(&self, rgb: [f32; 3]) -> Sigmoid {
        let [r, g, b] = rgb;
        if r == g && g == b {
            // A grey reflectance is constant: invert the sigmoid.
            let y = 2.0 * r.clamp(MARGIN as f32, 1.0 - MARGIN as f32) - 1.0;
            return Sigmoid::of_coefficients([0.0, 0.0, y / (1.0 - y * y).sqrt()]);
        }
        let channel = if r >= g && r >= b {
            0
        } else if g >= b {
            1
        } else {
            2
        };
        let largest = rgb[channel];
        let over = |k: usize| rgb[(channel + k) % 3] / largest * (N - 1) as f32;
        let cell = |x: f32| {
            let i = (x as usize).min(N - 2);
            (i, x - i as f32)
        };
        let ((x, dx), (y, dy)) = (cell(over(1)), cell(over(2)));
        let z = self.levels.partition_point(|l| *l <= largest).clamp(1, N - 1) - 1;
        let dz = (largest - self.levels[z]) / (self.levels[z + 1] - self.levels[z]);
        let mut c = [0.0f32; 3];
        for (i, wx) in [(x, 1.0 - dx), (x + 1, dx)] {
            for (j, wy) in [(y, 1.0 - dy), (y + 1, dy)] {
                let column = ((channel * N + i) * N + j) * N;
                for (k, wz) in [(z, 1.0 - dz), (z + 1, dz)] {
                    let entry = self.coefficients[column + k];
                    let w = wx * wy * wz;
                    c.iter_mut().zip(entry).for_each(|(c, e)| *c += w * e);
                }
            }
        }
        Sigmoid::of_coefficients(c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colorimetry::colorimetry;

    /// The colour of a function under D65, with all wavelengths.
    fn colour(s: &Sigmoid) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (l, w) in colorimetry().reflectance_weights.iter().enumerate() {
            rgb.iter_mut().zip(w).for_each(|(sum, w)| *sum += w * f64::from(s.at(360.0 + l as f32)));
        }
        rgb
    }

    #[test]
    fn tabulated_spectra_have_the_colour_and_the_shape_of_fitted_ones() {
        let table = SmoothSpectra::get();
        let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0);
        // Steps that meet no entry of the table; black and white, and their edges, among them.
        for i in 0..12u32.pow(3) {
            let rgb = [i % 12, i / 12 % 12, i / 144].map(|l| f64::from(l) / 11.0);
            let back = colour(&table.of(rgb.map(|c| c as f32)));
            let error = (0..3).map(|c| (back[c] - rgb[c]).abs()).fold(0.0, f64::max);
            worst = worst.max(error);
            sum += error;
            count += 1;
        }
        let mean = sum / f64::from(count);
        assert!(worst < 4e-3 && mean < 1e-3, "{worst} {mean}");
        for rgb in [[0.8, 0.4, 0.1], [0.1, 0.3, 0.7], [0.35, 0.6, 0.2]] {
            let (ours, fitted) = (table.of(rgb.map(|c| c as f32)), Sigmoid::fit(rgb));
            for l in 36..83 {
                let l = 10.0 * l as f32;
                assert!((ours.at(l) - fitted.at(l)).abs() < 0.01, "{rgb:?} {l}: {} {}", ours.at(l), fitted.at(l));
            }
        }
        for grey in [0.0, 0.2, 1.0] {
            assert!((table.of([grey; 3]).at(500.0) - grey).abs() < 2e-5);
        }
    }
}
