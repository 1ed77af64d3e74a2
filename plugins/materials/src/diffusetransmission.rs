//! `diffusetransmission`: paper, cloth, leaves: matt on both sides, and light shines through.
//!
//! The BSDF is `reflectance / pi` on the side of the light and `transmittance / pi` on the other.
//!
//! Names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `reflectance` | spectrum, texture | 0.25 | | share of the light that is reflected |
//! | `transmittance` | spectrum, texture | 0.25 | | share of the light that shines through |
//! | `scale` | float | 1 | | factor of both; together they are at most 1 |
//!
//! ```bhs
//! Material "diffusetransmission" "rgb reflectance" [0.2 0.3 0.1] "rgb transmittance" [0.1 0.2 0.05]
//! ```

use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading, same_hemisphere};
use bhs_core::params::Params;
use bhs_core::sampling::cosine_hemisphere;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::SpectrumParameter;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "diffusetransmission", summary: "a matt sheet that light shines through, such as paper", build };

struct DiffuseTransmission {
    reflectance: SpectrumParameter,
    transmittance: SpectrumParameter,
    scale: f32,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let role = SpectrumRole::Reflectance;
    let reflectance = p.spectrum_parameter("reflectance", 0.25, role, "", "share of the light that is reflected");
    let transmittance = p.spectrum_parameter("transmittance", 0.25, role, "", "share of the light that shines through");
    let scale = p.get_in("scale", 1.0, 0.0..=1.0, "", "factor of both; together they are at most 1") as f32;
    Some(Box::new(DiffuseTransmission { reflectance, transmittance, scale }))
}

impl DiffuseTransmission {
    /// What is reflected and what shines through; together never more than comes in.
    fn shares(&self, at: &Shading) -> [SampledSpectrum; 2] {
        let [r, t] = [&self.reflectance, &self.transmittance].map(|s| s.sample(at) * self.scale);
        let whole = r.zip(t, |r, t| (r + t).max(1.0));
        [r.zip(whole, |r, w| r / w), t.zip(whole, |t, w| t / w)]
    }

    /// Probability of the side of the light.
    fn reflects(shares: &[SampledSpectrum; 2]) -> f32 {
        let [r, t] = shares.map(SampledSpectrum::max);
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }
}

impl Material for DiffuseTransmission {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        self.shares(at)[usize::from(!same_hemisphere(wo, wi))] * (wi.z.abs() * FRAC_1_PI)
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        let reflects = Self::reflects(&self.shares(at));
        let side = if same_hemisphere(wo, wi) { reflects } else { 1.0 - reflects };
        side * wi.z.abs() * FRAC_1_PI
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let shares = self.shares(at);
        let reflects = Self::reflects(&shares);
        let through = choice >= reflects;
        let side = if through { 1.0 - reflects } else { reflects };
        let mut wi = cosine_hemisphere(u);
        let pdf = side * wi.z * FRAC_1_PI;
        wi.z *= if through { -wo.z.signum() } else { wo.z.signum() };
        let weight = shares[usize::from(through)] * (1.0 / side);
        (pdf > 0.0).then_some(BsdfSample { wi, weight, pdf, specular: false, drops_wavelengths: false, eta: 1.0 })
    }

    fn is_specular(&self) -> bool {
        false
    }

    fn chooses_directions(&self) -> bool {
        true
    }
}
