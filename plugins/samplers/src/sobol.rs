//! `sobol`: Owen-scrambled Sobol points, another scrambling for each pixel.
//!
//! Samples of one pixel are well distributed in each dimension and over each set of four dimensions; sets are independent of one
//! another, and so are pixels (Burley 2020, "Practical Hash-based Owen Scrambling").
//! Wavelengths are spread over a pixel's samples and its neighbours. Best with a power of two of samples.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `pixelsamples` | integer | 16 | | samples per pixel |
//!
//! ```bhs
//! Sampler "sobol" "integer pixelsamples" 64
//! WorldBegin
//! ```

use crate::{hash, pixel_samples_and_seed, wavelengths};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::sampling::{ONE_MINUS_EPSILON, SET, Sampler};
use sobol_burley::parts::{Int4, hash as hash_u32, hash_int4, owen_scramble_int4_rev, owen_scramble_rev, sobol_rev};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Sampler> =
    Plugin { name: "sobol", summary: "Owen-scrambled Sobol points, another scrambling for each pixel", build };

/// Points of one sequence; beyond, the next sequence begins.
const SEQUENCE: u32 = 1 << 16;

pub(crate) struct Sobol {
    samples: u32,
    seed: u64,
    points: Points,
}

impl Sobol {
    pub fn new(samples: u32, seed: u64) -> Self {
        Self { samples, seed, points: Points::new() }
    }
}

fn build(p: &Params) -> Option<Box<dyn Sampler>> {
    let (samples, seed) = pixel_samples_and_seed(p);
    Some(Box::new(Sobol::new(samples, seed)))
}

/// The first four dimensions of the first [`SEQUENCE`] points, not scrambled, with reversed bits. A point is the sum without carries of
/// those of the two bytes of its number: looking both up takes a third of the time of `sobol_burley::sample_4d`, which adds up the bits.
struct Points([[[u32; 4]; 256]; 2]);

impl Points {
    fn new() -> Self {
        let of = |index: u32| std::array::from_fn(|dimension| sobol_rev(index, dimension as u32));
        Self([24, 16].map(|shift| std::array::from_fn(|byte| of((byte as u32) << shift))))
    }

    /// `sobol_burley::sample_4d(index, 0, seed)`, to the bit: an Owen-scrambled point of the sequence that `seed` shuffles.
    #[inline]
    fn scrambled(&self, index: u32, seed: u32) -> [f32; 4] {
        let [first, second, ..] = owen_scramble_rev(index.reverse_bits(), hash_u32(seed ^ 0x79c6_8e4a)).to_be_bytes();
        let point = Int4::from(self.0[0][first as usize]) ^ self.0[1][second as usize].into();
        let seeds = Int4::from([seed.wrapping_mul(0x9c8f_2d3b); 4]) ^ [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8].into();
        owen_scramble_int4_rev(point, hash_int4(seeds)).reverse_bits().to_f32_norm()
    }
}

impl Sampler for Sobol {
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET] {
        // All sets are the same four-dimensional sequence, each shuffled and scrambled by its own seed.
        let seed = hash(self.seed ^ u64::from(index / SEQUENCE), pixel, set);
        self.points.scrambled(index % SEQUENCE, seed as u32).map(|x| x.min(ONE_MINUS_EPSILON))
    }

    fn wavelengths(&self, pixel: [u32; 2], index: u32) -> f32 {
        wavelengths::progressive(self.seed, pixel, index)
    }

    fn samples_per_pixel(&self) -> u32 {
        self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_the_crate() {
        let points = Points::new();
        for i in 0..20_000u32 {
            let (index, seed) = (i.wrapping_mul(40_503) % SEQUENCE, i.wrapping_mul(2_654_435_761));
            assert_eq!(points.scrambled(index, seed), sobol_burley::sample_4d(index, 0, seed), "{index} {seed}");
        }
    }
}
