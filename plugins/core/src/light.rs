//! What emits light.

use crate::spectrum::{N_LAMBDA, SampledSpectrum};
use glam::{DVec3, Vec2};

/// Where and how light leaves a surface, as the observer at that place sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Cosine of the angle to the outer normal.
    pub cos_theta: f32,
    /// Wavelengths at the surface (nm).
    pub lambda_nm: [f32; N_LAMBDA],
    /// Rate of the observer's clock over that of one far from the hole: `sqrt(f(r))`; 1 where nothing shifts.
    pub lapse: f32,
}

/// The emission of a surface, in the frame of the observer at its place.
pub trait AreaLight: Send + Sync {
    /// Spectral radiance [W m^-2 sr^-1 nm^-1] that leaves the surface.
    fn radiance(&self, at: &Emission) -> SampledSpectrum;

    /// Exitance averaged over `lo..=hi` (nm), all sides: what lights are chosen by.
    fn exitance(&self, lo: f32, hi: f32) -> f32;
}

/// A light that is not a surface.
pub trait Light: Send + Sync {
    /// Spectral radiance that arrives from infinitely far away, from the unit chart direction `direction` (pointing out of
    /// the scene), at the given wavelengths [nm, far from the hole].
    fn sky_radiance(&self, _direction: DVec3, _lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    /// The point that it shines from, if it does: render space. Such a light is found by light sampling alone.
    fn position(&self) -> Option<DVec3> {
        None
    }

    /// Spectral intensity [W sr^-1 nm^-1] of a light that shines from a point, in the unit direction `direction` of the observer
    /// there, at the given wavelengths [nm, at that point].
    fn intensity(&self, _direction: DVec3, _lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    /// Power averaged over `lo..=hi` (nm) of a light that shines from a point [W nm^-1]: what lights are chosen by.
    fn power(&self, _lo: f32, _hi: f32) -> f32 {
        0.0
    }

    /// Moves the light by `-origin`, from world space to render space. Called once, before anything else.
    fn rebase(&mut self, _origin: DVec3) {}
}
