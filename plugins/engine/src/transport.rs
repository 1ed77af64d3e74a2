//! Light transport: what pbrt calls an integrator.

use crate::patch::Patch;
use crate::scene::Scene;
use crate::stats::PathLog;
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::sampling::{SampleStream, Sampler};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use glam::Vec2;
use std::ops::Range;
use std::sync::Arc;

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
    /// The patch of a surface that its pixel sees, where textures ask for it and there is one.
    pub patch: Option<Patch>,
    /// What became of `ray`: written by the transport, for the picture's layers.
    pub first: RayEnd,
    /// What is seen in mirrors and through smooth glass, where the ray meets such a surface: written by the transport, for the picture's layers.
    pub behind: Option<Behind>,
}

/// The end of a path that has met nothing but specular surfaces, or nearly specular ones, before.
#[derive(Clone, Copy, Debug)]
pub struct Behind {
    /// Its last ray.
    pub ray: Ray,
    /// What became of that: another surface, or what is not one.
    pub end: RayEnd,
    /// Share of the light from there that the surfaces before leave: a mean over wavelengths.
    pub share: f32,
}

impl<'a> PathSample<'a> {
    /// A path that has not been followed.
    #[inline]
    pub fn new(ray: Ray, lambda: SampledWavelengths, stream: SampleStream<'a>) -> Self {
        Self { ray, lambda, stream, radiance: SampledSpectrum::ZERO, patch: None, first: RayEnd::NONE, behind: None }
    }
}

/// Paths that are followed together at most.
pub const BATCH: usize = 64;

/// What a transport may know of a render before its first sample.
#[derive(Clone)]
pub struct RenderSetting<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Random numbers: those of a pixel that no picture has are nobody's.
    pub sampler: &'a dyn Sampler,
    /// Least and greatest wavelength at E = 1 that the film sees, within a few percent (nm).
    pub lambda_range: [f32; 2],
    /// Width and height of the whole picture (pixels).
    pub resolution: [u32; 2],
    /// Pixels that take part in the wave that begins; before the first, those of the whole picture, whatever part of it is rendered.
    pub pixels: u64,
    /// The ray of the camera through a point of the whole picture and one of the lens, both in [0,1)^2.
    pub camera_ray: Arc<dyn Fn(Vec2, Vec2) -> Ray + Send + Sync + 'a>,
    /// Whether the render is to end: what takes long before a wave asks now and then, and leaves off. No sample of that wave is made then.
    pub is_stopped: Arc<dyn Fn() -> bool + Send + Sync + 'a>,
}

impl RenderSetting<'_> {
    /// Pixels of the whole picture, whichever of them take part in a wave.
    pub fn all_pixels(&self) -> u64 {
        self.resolution.map(u64::from).iter().product()
    }
}

/// Estimates the light that arrives at the camera along a ray. Knows neither orbits nor intersectors.
pub trait LightTransport: Send + Sync {
    /// Follows `path`: writes what it finds, the spectral radiance that arrives along its ray, to its `radiance`, what became of the ray
    /// itself to its `first`, and, if it goes on from a mirror or from glass, where it comes to to its `behind`. What only the first of its wavelengths brings, after dispersion, is in the first place, and counts for the others
    /// too.
    fn follow(&self, scene: &Scene, path: &mut PathSample, log: &mut PathLog);

    /// The same for each of `paths`: for transports that follow several faster than one after the other. What a path finds does not depend on the
    /// others.
    fn follow_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut PathLog) {
        for path in paths {
            self.follow(scene, path, log);
        }
    }

    /// The same method with a memory of its own, for one render: what it finds may depend on what it makes for each wave
    /// ([`LightTransport::begin_wave`]), but on nothing else. `None`: it has no memory, and is used as it is.
    fn for_render(&self, _setting: &RenderSetting) -> Option<Box<dyn LightTransport>> {
        None
    }

    /// Says that the samples that follow are those with the numbers `samples`, all of which belong to one wave, in the render of
    /// [`LightTransport::for_render`]. What it makes for them depends on the setting and these numbers alone, not on
    /// whether it was told of the waves before: a render may begin anywhere. Runs on the current rayon pool.
    fn begin_wave(&mut self, _setting: &RenderSetting, _samples: Range<u32>) {}

    /// Whether its pictures show light: not those of normals, in which nothing shines.
    fn shows_light(&self) -> bool {
        true
    }

    /// Whether it samples lights (next-event estimation): one that does not cannot find a light that shines from a point.
    fn samples_lights(&self) -> bool {
        false
    }
}
