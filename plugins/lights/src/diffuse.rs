//! `diffuse`: an area light that sends the same radiance in all directions.
//!
//! The light leaves on the outer side of the shape (which `ReverseOrientation` turns), or on both. The exitance of a side is
//! pi L. The radiance is that which an observer at rest beside the surface sees.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `L` | spectrum | 1 | W m^-2 sr^-1 nm^-1 | emitted spectral radiance |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `twosided` | bool | false | | whether both sides emit |
//!
//! ```bhs
//! WorldBegin
//! AreaLightSource "diffuse" "spectrum L" 10 "bool twosided" true
//! Shape "sphere" "float radius" 0.1
//! ```

use crate::{factor, mean, scale};
use bhs_core::light::{AreaLight, Emission};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use std::f64::consts::PI;
use std::sync::Arc;

/// The entry in the list of area lights.
pub const PLUGIN: Plugin<dyn AreaLight> =
    Plugin { name: "diffuse", summary: "an area light with the same radiance in all directions", build };

fn build(p: &Params) -> Option<Box<dyn AreaLight>> {
    let radiance = p.spectrum("L", 1.0, SpectrumRole::Emission, "W m^-2 sr^-1 nm^-1", "emitted spectral radiance");
    let scale = factor(p, "L", radiance.as_ref(), scale(p));
    let two_sided = p.get("twosided", false, "", "whether both sides emit");
    Some(Box::new(Diffuse { radiance, scale, two_sided }))
}

struct Diffuse {
    radiance: Arc<dyn Spectrum>,
    scale: f32,
    two_sided: bool,
}

impl AreaLight for Diffuse {
    fn radiance(&self, at: &Emission) -> SampledSpectrum {
        if at.cos_theta > 0.0 || (self.two_sided && at.cos_theta < 0.0) {
            self.radiance.sample_at(at.lambda_nm, at.clock_rate) * self.scale
        } else {
            SampledSpectrum::ZERO
        }
    }

    fn exitance(&self, lo: f32, hi: f32) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        PI * mean(self.radiance.as_ref(), lo, hi) * f64::from(self.scale) * sides
    }
}
