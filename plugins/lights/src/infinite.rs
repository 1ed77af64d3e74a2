//! `infinite`: a sky of the same radiance in all directions, infinitely far away.
//!
//! The light of every ray that leaves the scene. The radiance is that which an observer at rest far from any hole sees.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `L` | spectrum | 1 | W m^-2 sr^-1 nm^-1 | spectral radiance |
//! | `scale` | float | 1 | | multiplies L |
//!
//! ```bhs
//! WorldBegin
//! LightSource "infinite" "spectrum L" 0.5
//! ```

use crate::scale;
use bhs_core::light::Light;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use glam::DVec3;
use std::sync::Arc;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> = Plugin { name: "infinite", summary: "a sky of the same radiance in all directions", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let radiance = p.spectrum("L", 1.0, SpectrumRole::Emission, "W m^-2 sr^-1 nm^-1", "spectral radiance");
    let scale = scale(p);
    Some(Box::new(Infinite { radiance, scale }))
}

struct Infinite {
    radiance: Arc<dyn Spectrum>,
    scale: f32,
}

impl Light for Infinite {
    fn sky_radiance(&self, _: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        self.radiance.sample(lambda_nm) * self.scale
    }
}
