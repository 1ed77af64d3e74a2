//! `interface`: a surface that light passes straight on, or a share of it. Nothing is reflected.
//!
//! With an area light it is an optically thin layer that emits, a veil or a gas: what lies behind shows through it. Where nothing is taken away, it is
//! pbrt-v4's material of this name. What is left is absorbed; the share is the same at all angles.
//!
//! Light behind it is found as behind smooth glass: by paths that go on through it, and not by light sampling, to which it is opaque. So a light that
//! has no size is not seen through it. Each passage counts as a bounce of `maxdepth`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `transmits` | spectrum, texture | 1 | | share of the light that goes on |
//!
//! ```bhs
//! WorldBegin
//! Material "interface" "float transmits" 0.6
//! AreaLightSource "diffuse" "spectrum L" 0.4 "bool twosided" true
//! Shape "disk" "float radius" 2
//! ```

use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::SpectrumParameter;
use glam::{Vec2, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "interface", summary: "a surface that light passes straight on, or a share of it", build };

struct Interface {
    transmits: SpectrumParameter,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let about = "share of the light that goes on";
    let transmits = p.spectrum_parameter("transmits", 1.0, SpectrumRole::Reflectance, "", about);
    Some(Box::new(Interface { transmits }))
}

impl Material for Interface {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, at: &Shading, wo: Vec3, _: f32, _: Vec2) -> Option<BsdfSample> {
        let weight = self.transmits.sample(at);
        Some(BsdfSample { wi: -wo, weight, pdf: 1.0, specular: true, drops_wavelengths: false, eta: 1.0 })
    }

    fn reflectance(&self, at: &Shading, _: Vec3) -> SampledSpectrum {
        self.transmits.sample(at)
    }

    fn is_uniform(&self) -> bool {
        self.transmits.is_uniform()
    }

    fn is_specular(&self) -> bool {
        true
    }
}
