//! `sobol`: Owen-scrambled Sobol points, another scrambling for each pixel.
//!
//! Samples of one pixel are well distributed in each dimension and over each set of four dimensions; sets are independent of one
//! another, and so are pixels (Burley 2020, "Practical Hash-based Owen Scrambling").
//! Best with a power of two of samples.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `pixelsamples` | integer | 16 | | samples per pixel |
//!
//! ```bhs
//! Sampler "sobol" "integer pixelsamples" 64
//! WorldBegin
//! ```

use crate::{hash, pixel_samples_and_seed};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::sampling::{ONE_MINUS_EPSILON, SET, Sampler};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Sampler> =
    Plugin { name: "sobol", summary: "Owen-scrambled Sobol points, another scrambling for each pixel", build };

/// Points of one sequence; beyond, the next sequence begins.
const SEQUENCE: u32 = 1 << 16;

pub(crate) struct Sobol {
    pub samples: u32,
    pub seed: u64,
}

fn build(p: &Params) -> Option<Box<dyn Sampler>> {
    let (samples, seed) = pixel_samples_and_seed(p);
    Some(Box::new(Sobol { samples, seed }))
}

impl Sampler for Sobol {
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET] {
        // All sets are the same four-dimensional sequence, each shuffled and scrambled by its own seed.
        let seed = hash(self.seed ^ u64::from(index / SEQUENCE), pixel, set);
        sobol_burley::sample_4d(index % SEQUENCE, 0, seed as u32).map(|x| x.min(ONE_MINUS_EPSILON))
    }

    fn samples_per_pixel(&self) -> u32 {
        self.samples
    }
}
