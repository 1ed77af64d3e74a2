//! `mirror`: a perfect mirror, on both sides.
//!
//! The incoming angle is the outgoing one, and every angle reflects the same share of the light. No real surface does that:
//! see `conductor` for metals. (pbrt-v4 has no such material; Mitsuba and CS184 do.)
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `reflectance` | spectrum, texture | 1 | | share of the light that is reflected |
//!
//! ```bhs
//! Material "mirror" "spectrum reflectance" 0.95
//! ```

use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::SpectrumParameter;
use glam::{Vec2, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "mirror", summary: "a perfect mirror with the same reflectance at all angles", build };

struct Mirror {
    reflectance: SpectrumParameter,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let reflectance =
        p.spectrum_parameter("reflectance", 1.0, SpectrumRole::Reflectance, "", "share of the light that is reflected");
    Some(Box::new(Mirror { reflectance }))
}

impl Material for Mirror {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, at: &Shading, wo: Vec3, _: f32, _: Vec2) -> Option<BsdfSample> {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        Some(BsdfSample { wi, weight: self.reflectance.sample(at), pdf: 1.0, specular: true, drops_wavelengths: false, eta: 1.0 })
    }

    fn reflectance(&self, at: &Shading, _: Vec3) -> SampledSpectrum {
        self.reflectance.sample(at)
    }

    fn is_uniform(&self) -> bool {
        self.reflectance.is_uniform()
    }

    fn is_specular(&self) -> bool {
        true
    }
}
