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

use crate::amount::Amount;
use crate::{hash, wavelengths};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::sampling::{NoiseTarget, ONE_MINUS_EPSILON, SET, Sampler};
use sobol_burley::parts::{Int4, hash as hash_u32, hash_int4, owen_scramble_int4_rev, owen_scramble_rev, sobol_rev};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Sampler> =
    Plugin { name: "sobol", summary: "Owen-scrambled Sobol points, another scrambling for each pixel", build };

/// Points of one sequence; beyond, the next sequence begins.
const SEQUENCE: u32 = 1 << 16;

pub(crate) struct Sobol {
    amount: Amount,
    seed: u64,
    points: Points,
}

impl Sobol {
    pub fn new(amount: Amount, seed: u64) -> Self {
        Self { amount, seed, points: Points::new() }
    }
}

fn build(p: &Params) -> Option<Box<dyn Sampler>> {
    Some(Box::new(Sobol::new(Amount::read(p), p.context().seed)))
}

/// The set whose dimensions wavelengths are spread over: places in the pixel and on the lens.
const FIRST_SET: u32 = 0;
/// The dimension of wavelengths, beside the four of the first set.
const WAVELENGTHS: u32 = 4;

/// The first four dimensions of the first [`SEQUENCE`] points, and apart from them that of wavelengths, not scrambled, with reversed bits. A
/// point is the sum without carries of those of the two bytes of its number: looking both up takes a third of the time of
/// `sobol_burley::sample_4d`, which adds up the bits.
struct Points([[[u32; 4]; 256]; 2], [[u32; 256]; 2]);

/// The number of the sample `index` in the sequence that `seed` shuffles, with reversed bits, as its two bytes that count.
#[inline]
fn shuffled(index: u32, seed: u32) -> [usize; 2] {
    let [first, second, ..] = owen_scramble_rev(index.reverse_bits(), hash_u32(seed ^ 0x79c6_8e4a)).to_be_bytes();
    [first.into(), second.into()]
}

impl Points {
    fn new() -> Self {
        let of = |index: u32| std::array::from_fn(|dimension| sobol_rev(index, dimension as u32));
        let points = [24, 16].map(|shift| std::array::from_fn(|byte| of((byte as u32) << shift)));
        Self(points, [24, 16].map(|shift| std::array::from_fn(|byte| sobol_rev((byte as u32) << shift, WAVELENGTHS))))
    }

    /// The place of a sample among wavelengths: a permutation of the numbers below each power of two. Together with the four dimensions of
    /// the set that `seed` shuffles it makes a sequence of five, so that every part of the pixel gets all wavelengths.
    #[inline]
    fn wavelength(&self, index: u32, seed: u32) -> u32 {
        let at = |[first, second]: [usize; 2]| self.1[0][first] ^ self.1[1][second];
        at(shuffled(index, seed)) ^ at(shuffled(0, seed))
    }

    /// `sobol_burley::sample_4d(index, 0, seed)`, to the bit: an Owen-scrambled point of the sequence that `seed` shuffles.
    #[inline]
    fn scrambled(&self, index: u32, seed: u32) -> [f32; 4] {
        let [first, second] = shuffled(index, seed);
        let point = Int4::from(self.0[0][first]) ^ self.0[1][second].into();
        let seeds = Int4::from([seed.wrapping_mul(0x9c8f_2d3b); 4]) ^ [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8].into();
        owen_scramble_int4_rev(point, hash_int4(seeds)).reverse_bits().to_f32_norm()
    }
}

impl Sobol {
    /// What shuffles and scrambles a set of dimensions: all are the same four-dimensional sequence.
    #[inline]
    fn seed_of(&self, pixel: [u32; 2], index: u32, set: u32) -> u32 {
        hash(self.seed ^ u64::from(index / SEQUENCE), pixel, set) as u32
    }
}

impl Sampler for Sobol {
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET] {
        self.points.scrambled(index % SEQUENCE, self.seed_of(pixel, index, set)).map(|x| x.min(ONE_MINUS_EPSILON))
    }

    fn wavelengths(&self, pixel: [u32; 2], index: u32) -> f32 {
        let place = self.points.wavelength(index % SEQUENCE, self.seed_of(pixel, index, FIRST_SET)) % SEQUENCE;
        // Each sequence lies between the wavelengths of those before it.
        wavelengths::progressive(self.seed, pixel, place + (index / SEQUENCE) * SEQUENCE)
    }

    fn samples_per_pixel(&self) -> u32 {
        self.amount.samples
    }

    fn noise_target(&self) -> Option<NoiseTarget> {
        self.amount.target
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the wavelengths of the samples in their own order, which follow the same bits as places in the pixel, a pixel never
    /// converged: red light came from its left half.
    #[test]
    fn every_part_of_a_pixel_gets_all_wavelengths() {
        let sobol = Sobol::new(Amount::fixed(1 << 12), 3);
        let (mut worst, mut sum) = (0_u32, 0);
        for pixel in (0..16).map(|i| [i % 4, i / 4]) {
            let mut cells = [[0_u32; 16]; 16];
            for index in 0..1 << 12 {
                let [x, ..] = sobol.numbers(pixel, index, FIRST_SET);
                let w = sobol.wavelengths(pixel, index) * 4.0 % 1.0;
                cells[(x * 16.0) as usize][(w * 16.0) as usize] += 1;
            }
            let off = cells.iter().flatten().map(|n| n.abs_diff(16)).max().expect("cells");
            (worst, sum) = (worst.max(off), sum + off);
        }
        // Independent numbers leave some 12 at the worst.
        assert!(worst <= 2, "{worst} {sum}");
    }

    #[test]
    fn places_among_wavelengths_are_a_permutation_of_any_power_of_two() {
        let points = Points::new();
        for seed in 0..64_u32 {
            for m in 0..=12 {
                let mut places: Vec<u32> =
                    (0..1 << m).map(|i| points.wavelength(i, seed.wrapping_mul(2_654_435_761)) % SEQUENCE).collect();
                places.sort_unstable();
                assert!(places.into_iter().eq(0..1 << m), "{seed} {m}");
            }
        }
    }

    #[test]
    fn points_are_those_of_the_crate() {
        let points = Points::new();
        for i in 0..20_000u32 {
            let (index, seed) = (i.wrapping_mul(40_503) % SEQUENCE, i.wrapping_mul(2_654_435_761));
            assert_eq!(points.scrambled(index, seed), sobol_burley::sample_4d(index, 0, seed), "{index} {seed}");
        }
    }
}
