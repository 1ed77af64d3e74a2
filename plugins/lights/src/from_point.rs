//! What lights that shine from a point have in common: a place, and a spectrum of which each direction gets a share.

use crate::{factor, mean, rescale};
use bhs_core::params::Params;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum};
use glam::DVec3;
use std::sync::Arc;

/// The spectral intensity of a light that shines from a point, where a direction gets the whole of it.
pub struct FromPoint {
    spectrum: Arc<dyn Spectrum>,
    scale: f32,
    /// The integral over all directions of their shares (sr).
    solid_angle: f64,
    /// Render space.
    pub position: DVec3,
}

impl FromPoint {
    /// Of the parameter `I`, which is `spectrum`, times `scale`, so strong that it has the `power` that the scene may ask for.
    pub fn read(p: &Params, (spectrum, scale): (Arc<dyn Spectrum>, f64), solid_angle: f64, position: DVec3) -> Self {
        let about = "instead of the strength of `I`: power weighted by the eye, over all directions";
        let scale = scale * rescale(p, "power", about, spectrum.as_ref(), solid_angle);
        let scale = factor(p, "I", spectrum.as_ref(), scale);
        Self { spectrum, scale, solid_angle, position }
    }

    /// What a direction gets whose share is `share`.
    pub fn intensity(&self, share: f32, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        match share {
            0.0 => SampledSpectrum::ZERO,
            share => self.spectrum.sample(lambda_nm) * (self.scale * share),
        }
    }

    /// The mean power over `lo..=hi` (nm).
    pub fn power(&self, lo: f32, hi: f32) -> f64 {
        self.solid_angle * mean(self.spectrum.as_ref(), lo, hi) * f64::from(self.scale)
    }
}
