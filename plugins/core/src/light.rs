//! What emits light.

use crate::spectrum::{N_LAMBDA, SampledSpectrum};
use glam::{DVec3, Vec2};

/// The emission of a surface, in the frame of the observer at its place.
pub trait AreaLight: Send + Sync {
    /// Spectral radiance [W m^-2 sr^-1 nm^-1] that leaves the surface at the given wavelengths [nm, at the surface], in a
    /// direction at `cos_theta` from the outer normal.
    fn radiance(&self, uv: Vec2, cos_theta: f32, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum;

    /// Exitance averaged over `lo..=hi` (nm), all sides: what lights are chosen by.
    fn exitance(&self, lo: f32, hi: f32) -> f32;
}

/// A light that is not a surface.
pub trait Light: Send + Sync {
    /// Spectral radiance that arrives from infinitely far away, from the unit chart direction `direction` (pointing out of
    /// the scene), at the given wavelengths [nm, far from the hole].
    fn sky_radiance(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum;
}
