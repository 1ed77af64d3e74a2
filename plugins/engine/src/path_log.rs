//! What becomes of one path of light, for those who want to see it step by step.

use bhs_core::ray::{Ray, RayEnd};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum};
use glam::DVec3;

/// One thing that happens to a path that is followed back from the camera. Places are in render space, directions those of the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathEvent {
    /// A ray of it has been followed.
    Traced {
        /// From where.
        ray: Ray,
        /// To where.
        end: RayEnd,
        /// Weight of the light that it finds there.
        throughput: SampledSpectrum,
        /// The wavelengths that it has, at E = 1 (nm).
        lambda_nm: [f32; N_LAMBDA],
    },
    /// It has met light: of a surface, or of the sky. The radiance is that at E = 1, weighted against light sampling.
    Found(SampledSpectrum),
    /// Light sampling has traced a shadow ray to a point or a direction.
    Sampled {
        /// Number of the light as in [`crate::light_sampling::LightSampler::choice`]: first the surfaces that emit, then the others.
        light: u32,
        /// Its point, or its direction in the sky.
        place: LightPlace,
        /// What it contributes to the path if it is not occluded, at E = 1.
        radiance: SampledSpectrum,
        /// Whether it is not.
        visible: bool,
    },
    /// It has been given another direction by a surface.
    Scattered {
        /// The unit direction in which it goes on.
        direction: DVec3,
        /// BSDF times cosine over density.
        weight: SampledSpectrum,
        /// Density of the direction per solid angle of the observer there; 1 for a mirror's.
        pdf: f32,
        /// Whether there was only this direction.
        specular: bool,
    },
    /// It has ended at a surface.
    Ended(&'static str),
}

/// Where sampled light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightPlace {
    /// A point.
    Point(DVec3),
    /// A direction of the sky, as it leaves the surface.
    Sky(DVec3),
}
