//! Light transport: what pbrt calls an integrator.

use crate::integrator::Ray;
use crate::sampling::SampleStream;
use crate::scene::Scene;
use crate::spectrum::{SampledSpectrum, SampledWavelengths};
use crate::stats::TraceLog;

/// A path of light to be followed: what it begins with, and what it finds.
pub struct PathSample<'a> {
    /// What the camera sees along (chart).
    pub ray: Ray,
    /// Wavelengths at E = 1: those at a camera far from all mass.
    pub lambda: SampledWavelengths,
    /// Where its random numbers come from.
    pub stream: SampleStream<'a>,
    /// Spectral radiance seen, at E = 1: written by the transport.
    pub radiance: SampledSpectrum,
}

/// Paths that are followed together at most.
pub const BATCH: usize = 64;

/// Estimates the light that arrives at the camera along a ray. Knows neither orbits nor intersectors.
pub trait LightTransport: Send + Sync {
    /// Spectral radiance that arrives along `ray` (chart), at the wavelengths `lambda` at E = 1 and as it is there. What only the first of them
    /// brings, after dispersion, is in the first place, and counts for the others too.
    fn radiance(
        &self,
        scene: &Scene,
        ray: Ray,
        lambda: &SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum;

    /// The same for each of `paths`, with its own ray, wavelengths and numbers; the result is its `radiance`. For transports that follow several
    /// paths faster than one after the other. What a path finds does not depend on the others.
    fn radiance_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut TraceLog) {
        for path in paths {
            path.radiance = self.radiance(scene, path.ray, &path.lambda, &mut path.stream, log);
        }
    }

    /// The same method with a memory of its own, for one render of `scene`: what it finds may depend on what it found in the waves before
    /// ([`LightTransport::end_wave`]), but on nothing else. `None`: it has no memory, and is used as it is.
    fn for_render(&self, _scene: &Scene) -> Option<Box<dyn LightTransport>> {
        None
    }

    /// Whether it has such a memory: what a pixel shows then depends on which others are rendered.
    fn learns(&self) -> bool {
        false
    }

    /// Says that all samples so far are done, and that others follow: what has been found so far may be used from now on.
    fn end_wave(&mut self) {}

    /// What it has found so far, as bytes that [`LightTransport::restore`] understands: a render that is broken off and resumed goes on with
    /// it, and has to end with the same picture. So everything that later samples depend on is in there, exactly, including what the
    /// current wave has added. Called between samples, while no other thread uses it. Empty for a method without memory.
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Takes over what [`LightTransport::save`] of the same method, in a render of the same scene, has returned. Called once, before the first
    /// sample.
    ///
    /// # Errors
    /// What is wrong with `saved`, which comes from a file and may be anything.
    fn restore(&mut self, saved: &[u8]) -> Result<(), String> {
        if saved.is_empty() { Ok(()) } else { Err("the light transport has no memory, and some was saved".to_owned()) }
    }

    /// Whether it aims at lights: one that does not cannot find a light that shines from a point.
    fn samples_lights(&self) -> bool {
        false
    }
}
