//! `independent`: independent uniform numbers, from a hash of seed, pixel, sample and dimension.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `pixelsamples` | integer | 16 | | samples per pixel |
//!
//! ```bhs
//! Sampler "independent" "integer pixelsamples" 64
//! WorldBegin
//! ```

use crate::amount::Amount;
use crate::hash;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::sampling::{NoiseTarget, SET, Sampler, mix64, unit_f32};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Sampler> = Plugin { name: "independent", summary: "independent uniform numbers", build };

pub(crate) struct Independent {
    pub amount: Amount,
    pub seed: u64,
}

fn build(p: &Params) -> Option<Box<dyn Sampler>> {
    Some(Box::new(Independent { amount: Amount::read(p), seed: p.context().seed }))
}

impl Sampler for Independent {
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET] {
        let first = mix64(hash(self.seed, pixel, set) ^ u64::from(index));
        let second = mix64(first);
        [(first >> 32) as u32, first as u32, (second >> 32) as u32, second as u32].map(unit_f32)
    }

    fn samples_per_pixel(&self) -> u32 {
        self.amount.samples
    }

    fn noise_target(&self) -> Option<NoiseTarget> {
        self.amount.target
    }
}
