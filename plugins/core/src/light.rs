//! What emits light.

use crate::spacetime::Spacetime;
use crate::spectrum::{N_LAMBDA, SampledSpectrum};
use glam::{DVec3, Vec2};
use std::sync::Arc;

/// Where and how light leaves a surface, as the observer at that place sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Texture coordinates; of a light that depends on time, those of [`AreaLight::at_time_zero`].
    pub uv: Vec2,
    /// The place, render space.
    pub point: DVec3,
    /// When the light leaves, in coordinate time (scene units, c = 1): 0 is when it arrives at the camera, so it is not above 0. Known only to a
    /// light that depends on it; else 0.
    pub time: f64,
    /// Cosine of the angle to the outer normal.
    pub cos_theta: f32,
    /// Wavelengths at the surface (nm).
    pub lambda_nm: [f32; N_LAMBDA],
    /// Rate of the observer's clock over that of one far away; 1 where nothing shifts.
    pub clock_rate: f32,
}

/// A point of a surface that emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionPoint {
    /// Texture coordinates.
    pub uv: Vec2,
    /// The place, render space.
    pub point: DVec3,
}

/// The matter that an emission supposes at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matter {
    /// Any.
    Any,
    /// Matter that moves with this dx/dt (chart, units of c).
    Moving(DVec3),
    /// There is none at this place: nothing emits there.
    Elsewhere,
}

/// The emission of a surface, in the frame of the observer at its place.
pub trait AreaLight: Send + Sync {
    /// Spectral radiance [W m^-2 sr^-1 nm^-1] that leaves the surface.
    fn radiance(&self, at: &Emission) -> SampledSpectrum;

    /// Exitance at a point, averaged over `lo..=hi` (nm), all sides: what lights are chosen by.
    fn exitance(&self, at: &EmissionPoint, lo: f32, hi: f32) -> f64;

    /// Whether [`AreaLight::exitance`] is the same at all points.
    fn is_uniform(&self) -> bool {
        true
    }

    /// Tells it once, before anything else, what light moves through, in coordinates of render space; flat space where the scene states nothing.
    ///
    /// # Errors
    /// Why it cannot emit there, in words that stand under its name.
    fn bind(&mut self, _spacetime: &dyn Spacetime) -> Result<(), String> {
        Ok(())
    }

    /// The matter that it supposes at `point` (render space): a surface that is elsewhere or moves otherwise is warned of. Known after
    /// [`AreaLight::bind`].
    fn matter(&self, _point: DVec3) -> Matter {
        Matter::Any
    }

    /// How far from its own centre a disk with this emission begins where the scene does not say (chart, scene units). Known after
    /// [`AreaLight::bind`].
    fn inner_edge(&self) -> Option<f64> {
        None
    }

    /// The same light on a shape of the given area (chart, scene units squared), if what it emits depends on that.
    fn of_area(&self, _area: f64) -> Option<Arc<dyn AreaLight>> {
        None
    }

    /// Whether what it emits depends on the time: then light sampling leaves it out.
    fn depends_on_time(&self) -> bool {
        false
    }

    /// Where what is at `point` (render space) at the coordinate time `time` was at time 0: the place whose texture coordinates count.
    fn at_time_zero(&self, point: DVec3, _time: f64) -> DVec3 {
        point
    }
}

/// A direction drawn for sampling the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySample {
    /// Unit chart direction, pointing out of the scene.
    pub direction: DVec3,
    /// Its density per solid angle, far from the hole; 1 for a light that shines from one direction.
    pub pdf: f64,
    /// Whether the light shines from one direction: BSDF sampling does not find it.
    pub is_parallel: bool,
}

/// A light that is not a surface.
pub trait Light: Send + Sync {
    /// Spectral radiance that arrives from infinitely far away, from the unit chart direction `direction` (pointing out of
    /// the scene), at the given wavelengths [nm, far from the hole].
    fn sky_radiance(&self, _direction: DVec3, _lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    /// A direction in which to look for this light of the sky, drawn from two numbers in [0,1). `None` for a light that only BSDF sampling finds:
    /// one that shines alike from everywhere, or not from the sky at all.
    fn sample_sky(&self, _u: Vec2) -> Option<SkySample> {
        None
    }

    /// The density with which [`Light::sample_sky`] draws the unit chart direction `direction`, per solid angle far from the hole;
    /// 0 for a light that shines from one direction.
    fn sky_pdf(&self, _direction: DVec3) -> f64 {
        0.0
    }

    /// Spectral irradiance [W m^-2 nm^-1] of a light that shines from one direction of the sky, on a surface at right angles to it far
    /// from any hole, at the given wavelengths there (nm).
    fn irradiance(&self, _lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
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

    /// Power averaged over `lo..=hi` (nm) of a light that can be sampled [W nm^-1]: what lights are chosen by. Of a light of the sky it
    /// is what falls on a sphere of the given radius, which is that of the scene (scene units).
    fn power(&self, _lo: f32, _hi: f32, _radius: f64) -> f64 {
        0.0
    }

    /// The unit chart directions of its points, if it is made of points of the sky: stars. A picture draws each of them where its light arrives
    /// at the camera; all other rays see small discs in their places, by [`Light::sky_radiance`].
    fn points(&self) -> &[DVec3] {
        &[]
    }

    /// Spectral irradiance [W m^-2 nm^-1] of the point `number` of [`Light::points`], on a surface at right angles to its light far from any
    /// hole, at the given wavelengths there (nm).
    fn point_irradiance(&self, _number: usize, _lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    /// Moves the light by `-origin`, from world space to render space. Called once, before anything else.
    fn rebase(&mut self, _origin: DVec3) {}
}
