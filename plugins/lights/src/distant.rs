//! `distant`: light from one direction, infinitely far away, like that of a sun without size.
//!
//! `L` is the irradiance on a surface at right angles to the light (pbrt-v4's name), as an observer at rest far from any hole measures it.
//! Around a hole the light comes along all geodesics that start parallel far away and reach the surface; that focuses it behind the hole.
//! BSDF sampling does not find it: it takes a light transport that samples lights.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `L` | spectrum | 1 | W m^-2 nm^-1 | spectral irradiance at right angles to the light |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `from` | point3 | 0 0 0 | scene | a point on the way of the light, under the current transform |
//! | `to` | point3 | 0 0 1 | scene | a point farther on the way of the light |
//! | `illuminance` | float | none | | instead of the strength of `L`: irradiance weighted by the eye, `integral(L ybar) / integral(ybar)` |
//!
//! ```bhs
//! WorldBegin
//! LightSource "distant" "spectrum L" 3 "point3 from" [1 2 -1] "point3 to" [0 0 0]
//! ```

use crate::{aim, factor, mean, rescale, scale};
use bhs_core::light::{Light, SkySample};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use glam::{DVec3, Vec2};
use std::f64::consts::PI;
use std::sync::Arc;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> = Plugin { name: "distant", summary: "light from one direction, infinitely far away", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let about = "spectral irradiance at right angles to the light";
    let irradiance = p.spectrum("L", 1.0, SpectrumRole::Emission, "W m^-2 nm^-1", about);
    let scale = scale(p);
    let aim = aim(p, ["a point on the way of the light, under the current transform", "a point farther on the way of the light"]);
    let about = "instead of the strength of `L`: irradiance weighted by the eye, integral(L ybar) / integral(ybar)";
    let scale = scale * rescale(p, "illuminance", about, irradiance.as_ref(), 1.0);
    let scale = factor(p, "L", irradiance.as_ref(), scale);
    let (_, onwards) = aim?;
    Some(Box::new(Distant { irradiance, scale, direction: -onwards }))
}

struct Distant {
    irradiance: Arc<dyn Spectrum>,
    scale: f32,
    /// Unit chart direction towards the light.
    direction: DVec3,
}

impl Light for Distant {
    fn sample_sky(&self, _: Vec2) -> Option<SkySample> {
        Some(SkySample { direction: self.direction, pdf: 1.0, is_parallel: true })
    }

    fn irradiance(&self, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        self.irradiance.sample(lambda_nm) * self.scale
    }

    fn power(&self, lo: f32, hi: f32, radius: f64) -> f64 {
        PI * radius * radius * mean(self.irradiance.as_ref(), lo, hi) * f64::from(self.scale)
    }
}
