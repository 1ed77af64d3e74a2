//! What stands in for textures and materials that could not be made.

use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::Texture;
use glam::{Vec2, Vec3};

/// Stands in for what is at fault, which has been reported: no light.
pub(super) struct Faulty;

impl Texture for Faulty {
    fn spectrum(&self, _: &Shading) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn float(&self, _: &Shading) -> f32 {
        0.0
    }

    fn triple(&self, _: &Shading) -> Option<Vec3> {
        Some(Vec3::ZERO)
    }
}

impl Material for Faulty {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, _: &Shading, _: Vec3, _: f32, _: Vec2) -> Option<BsdfSample> {
        None
    }

    fn is_specular(&self) -> bool {
        true
    }
}
