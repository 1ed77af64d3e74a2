//! The light of a photon by wavelength: that of several wavelengths spread evenly over what the film sees, between which it is interpolated.

use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum};
use std::array;

/// Wavelengths of a photon.
pub const COUNT: usize = 16;
/// Sets of [`N_LAMBDA`] that these are.
pub const SETS: usize = COUNT / N_LAMBDA;

/// The wavelengths that photons are drawn from (nm, at E = 1 where they leave).
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The least.
    pub lo: f32,
    /// The greatest.
    pub hi: f32,
}

impl Range {
    /// Number `j` of the wavelengths of a photon that begin with the share `first` in [0,1) of the range.
    #[inline]
    pub fn lambda(self, first: f32, j: usize) -> f32 {
        self.lo + (first + j as f32 / COUNT as f32).fract() * (self.hi - self.lo)
    }

    /// Whether all of `lambda_nm` are within.
    #[inline]
    pub fn has(self, lambda_nm: [f32; N_LAMBDA]) -> bool {
        lambda_nm.iter().all(|l| (self.lo..=self.hi).contains(l))
    }

    /// Set `k` of the wavelengths: the first of set 0 is the one of dispersion.
    pub fn set(self, first: f32, k: usize) -> [f32; N_LAMBDA] {
        array::from_fn(|i| self.lambda(first, k + i * SETS))
    }

    /// The values at the wavelengths of a photon, from those of each set.
    pub fn of_sets(each: impl Fn(usize) -> SampledSpectrum) -> [f32; COUNT] {
        let sets: [SampledSpectrum; SETS] = array::from_fn(each);
        array::from_fn(|j| sets[j % SETS][j / SETS])
    }

    /// What is between `values` at each of `lambda_nm`, which are within.
    #[inline]
    pub fn interpolate(self, first: f32, values: &[f32; COUNT], lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum(lambda_nm.map(|l| {
            // The greatest is not the least of another turn.
            let share = ((l - self.lo) / (self.hi - self.lo)).min(1.0 - f32::EPSILON);
            let x = (share - first).rem_euclid(1.0) * COUNT as f32;
            let j = (x as usize).min(COUNT - 1);
            let (at, next) = (values[j], values[(j + 1) % COUNT]);
            let (here, there) = (self.lambda(first, j), self.lambda(first, j + 1));
            match here < there {
                true => at + (next - at) * (x - j as f32),
                // Between the last and the first.
                false if l >= here => at,
                false => next,
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_straight_stays_so_between_the_wavelengths() {
        let range = Range { lo: 400.0, hi: 700.0 };
        for first in [0.0, 0.03, 0.5, 0.97] {
            let line = |l: f32| 0.01 * l - 2.0;
            let values = Range::of_sets(|k| SampledSpectrum(range.set(first, k).map(line)));
            assert_eq!(values[0], line(range.lambda(first, 0)));
            let lambda = [430.0, 500.5, 611.0, 671.0];
            let found = range.interpolate(first, &values, lambda);
            assert!(found.0.iter().zip(lambda).all(|(f, l)| (f - line(l)).abs() < 1e-4), "{first}: {found:?}");
            let ends = range.interpolate(first, &values, [400.0, 700.0, 400.5, 699.5]);
            assert!(ends.0.iter().zip([2.0, 5.0, 2.005, 4.995]).all(|(f, l)| (f - l).abs() < 0.2), "{first}: {ends:?}");
        }
    }
}
