//! Light transport: what pbrt calls an integrator.

use crate::integrator::Ray;
use crate::sampling::SampleStream;
use crate::scene::Scene;
use crate::spectrum::{SampledSpectrum, SampledWavelengths};
use crate::stats::TraceLog;

/// Estimates the light that arrives at the camera along a ray. Knows neither orbits nor intersectors.
pub trait LightTransport: Send + Sync {
    /// Spectral radiance seen by the camera along `ray` (chart), at the wavelengths `lambda` of the camera. What only the first of them
    /// brings, after dispersion, is in the first place, and counts for the others too.
    fn radiance(
        &self,
        scene: &Scene,
        ray: Ray,
        lambda: &SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum;

    /// Whether it aims at lights: one that does not cannot find a light that shines from a point.
    fn samples_lights(&self) -> bool {
        false
    }
}
