//! `thindielectric`: a pane of glass whose thickness does not matter: it mirrors, and lets the rest pass straight on.
//!
//! Light goes to and fro between the two sides of the pane: with Fresnel's share R of one side, the pane reflects `R + (1-R)^2 R / (1-R^2)`. Nothing is
//! absorbed. Names and defaults of pbrt-v4.
//!
//! Source: Stokes 1862, "On the intensity of the light reflected from or transmitted through a pile of plates".
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `eta` | spectrum | 1.5 | | refractive index of the pane over what is around it, 0.001 to 1000 |
//!
//! ```bhs
//! Material "thindielectric" "float eta" 1.5
//! ```

use crate::fresnel;
use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "thindielectric", summary: "a thin pane of glass: mirrors, and lets the rest pass straight on", build };

struct ThinDielectric {
    eta: Arc<dyn Spectrum>,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let about = "refractive index of the pane over what is around it, 0.001 to 1000";
    let eta = p.spectrum("eta", 1.5, SpectrumRole::Unbounded, "", about);
    let [lo, hi] = p.context().lambda_range;
    let wavelengths = (0..=64).map(|i| lo + (hi - lo) * i as f32 / 64.0);
    if let Some(bad) = wavelengths.map(|l| eta.at(l)).find(|eta| !(1e-3..=1e3).contains(eta)) {
        p.reject("eta", format!("`eta` is {bad:?}"), "a refractive index lies between 0.001 and 1000");
    }
    Some(Box::new(ThinDielectric { eta }))
}

impl ThinDielectric {
    /// The share of the light that the whole pane reflects.
    fn reflected(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        self.eta.sample(at.lambda_nm).map(|eta| {
            let (one, _) = fresnel::dielectric(wo.z.abs().min(1.0), eta.clamp(1e-3, 1e3));
            // R + (1-R)^2 R / (1-R^2), without the pole at 1.
            if one < 1.0 { 2.0 * one / (1.0 + one) } else { 1.0 }
        })
    }
}

impl Material for ThinDielectric {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, _: Vec2) -> Option<BsdfSample> {
        let reflected = self.reflected(at, wo);
        let mean = reflected.mean();
        let (wi, weight, pdf) = if choice < mean {
            (Vec3::new(-wo.x, -wo.y, wo.z), reflected * (1.0 / mean), mean)
        } else {
            (-wo, reflected.map(|r| 1.0 - r) * (1.0 / (1.0 - mean)), 1.0 - mean)
        };
        weight.is_finite().then_some(BsdfSample { wi, weight, pdf, specular: true, drops_wavelengths: false, eta: 1.0 })
    }

    fn reflectance(&self, _: &Shading, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ONE
    }

    fn is_uniform(&self) -> bool {
        true
    }

    fn is_specular(&self) -> bool {
        true
    }

    fn chooses_directions(&self) -> bool {
        true
    }
}
