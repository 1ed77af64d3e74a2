//! `diffuse`: a matt surface, the same from all sides.
//!
//! Lambert's law: the BSDF is `reflectance / pi` on the side of the light, whichever side that is. Directions are chosen with
//! density `cos(theta) / pi`.
//!
//! Source: Lambert 1760.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `reflectance` | spectrum, texture | 0.5 | | share of the light that is reflected |
//!
//! ```bhs
//! Material "diffuse" "spectrum reflectance" "cornell-white"
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
    Plugin { name: "diffuse", summary: "a matt surface, the same from all sides (Lambert)", build };

struct Diffuse {
    reflectance: SpectrumParameter,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let about = "share of the light that is reflected";
    let reflectance = p.spectrum_parameter("reflectance", 0.5, SpectrumRole::Reflectance, "", about);
    Some(Box::new(Diffuse { reflectance }))
}

impl Material for Diffuse {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        if !same_hemisphere(wo, wi) {
            return SampledSpectrum::ZERO;
        }
        self.reflectance.sample(at) * (wi.z.abs() * FRAC_1_PI)
    }

    fn pdf(&self, _: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        if same_hemisphere(wo, wi) { wi.z.abs() * FRAC_1_PI } else { 0.0 }
    }

    fn sample(&self, at: &Shading, wo: Vec3, _: f32, u: Vec2) -> Option<BsdfSample> {
        let mut wi = cosine_hemisphere(u);
        wi.z *= wo.z.signum();
        let pdf = self.pdf(at, wo, wi);
        // At grazing angles one of the two cosines can be zero.
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.reflectance.sample(at),
            pdf,
            specular: false,
            drops_wavelengths: false,
            eta: 1.0,
        })
    }

    fn reflectance(&self, at: &Shading, _: Vec3) -> SampledSpectrum {
        self.reflectance.sample(at)
    }

    fn is_uniform(&self) -> bool {
        self.reflectance.is_uniform()
    }

    fn is_specular(&self) -> bool {
        false
    }

    fn is_matt(&self) -> bool {
        true
    }
}
