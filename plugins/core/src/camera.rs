//! Cameras, filters and films: from a picture's pixels to rays, and back from radiance to pixels.

use crate::diagnostics::shorten;
use crate::motion::{FindMotion, Motion, read_motion};
use crate::params::Params;
use crate::spacetime::Side;
use crate::spectrum::{SampledSpectrum, SampledWavelengths};
use glam::{DAffine3, DMat4, DVec2, DVec3, Vec2};
use std::sync::Arc;

/// A ray that a camera looks along. The direction is what the observer at the camera measures; the program turns it into
/// the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// Start, render space.
    pub origin: DVec3,
    /// Unit direction in the local frame of the observer at `origin`.
    pub direction: DVec3,
}

/// On which side of a wormhole a camera is, and how it moves.
#[derive(Clone, Debug, Default)]
pub struct Viewpoint {
    /// The side; the near one in all other spacetimes.
    pub side: Side,
    /// How it moves; `None`: at rest.
    pub motion: Option<Arc<dyn Motion>>,
}

impl Viewpoint {
    /// What the parameters of a camera's directive state; `None` if something is wrong with the side.
    pub fn read(p: &Params, find: FindMotion) -> Option<Self> {
        let side = p.get("side", "near".to_owned(), "", "side of a wormhole on which the camera is: `near` or `far`");
        let motion = read_motion(p, find).map(Arc::from);
        let side = match side.as_str() {
            "near" => Side::Near,
            "far" => Side::Far,
            _ => {
                p.reject("side", format!("unknown side `{}`", shorten(&side)), "expected `near` or `far`");
                return None;
            }
        };
        Some(Self { side, motion })
    }
}

/// How a camera maps points where light is straight: as if there were no hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// From render space to camera space: x to the right, y up, z into the picture.
    pub camera_from_render: DAffine3,
    /// From camera space to the picture, after division by the fourth coordinate: x from 0 at its left edge to 1 at its right one, y from 0
    /// at the top to 1 at the bottom (normalized device coordinates of OpenEXR and RenderMan). `None` for cameras that no matrix describes.
    pub screen_from_camera: Option<DMat4>,
}

/// Turns points of the film into rays.
pub trait Camera: Send + Sync {
    /// The ray through the point `raster` of the film (pixels; x to the right, y down, pixel centres at halves); `lens` is
    /// two numbers in [0,1).
    fn ray(&self, raster: DVec2, lens: Vec2) -> CameraRay;

    /// Where the camera stands, render space; the middle of the places that its rays start from, if there are several.
    fn position(&self) -> DVec3;

    /// The place nearest to `point` that a ray may start from, render space.
    fn nearest_origin(&self, _point: DVec3) -> DVec3 {
        self.position()
    }

    /// Width of what one pixel in the middle of the picture covers at `distance`, along its shorter side (scene units, both).
    fn pixel_width(&self, distance: f64) -> f64;

    /// Its matrices, for those who put other pictures on top of this one. `None`: it does not tell.
    fn matrices(&self) -> Option<CameraMatrices> {
        None
    }

    /// Where its picture shows light from far away. `None`: its rays start in several places, and no single one of them shows a star.
    fn projection(&self) -> Option<&dyn Projection> {
        None
    }

    /// Moves the camera by `-origin`, from world space to render space. Called once, before anything else.
    fn rebase(&mut self, origin: DVec3);
}

/// The inverse of a camera all of whose rays start in [`Camera::position`].
pub trait Projection: Send + Sync {
    /// Calls `at` with each point of the film (pixels) at which [`Camera::ray`] has the unit local direction `direction`, up to `margin` pixels
    /// outside of the picture, and with the solid angle that the camera sees there per area of the film [sr/pixel^2].
    fn project(&self, direction: DVec3, margin: f64, at: &mut dyn FnMut(DVec2, f64));
}

/// Whether `raster` lies on a film of the given size, or at most `margin` outside of it (pixels, all of them).
pub fn is_near_film(raster: DVec2, resolution: DVec2, margin: f64) -> bool {
    raster.cmpge(DVec2::splat(-margin)).all() && raster.cmple(resolution + margin).all()
}

/// A pixel's reconstruction filter, applied by choosing where samples go, so that each sample touches its own pixel only.
pub trait Filter: Send + Sync {
    /// Offset from the pixel's centre (pixels) and weight of a sample, from two numbers in [0,1).
    fn sample(&self, u: Vec2) -> (Vec2, f32);

    /// Half width and half height (pixels).
    fn radius(&self) -> DVec2;

    /// Its value at `offset` from the pixel's centre (pixels), in units of its own; 0 outside of the radius.
    fn value(&self, offset: DVec2) -> f64;
}

/// Turns spectral samples into the numbers of a pixel.
pub trait Film: Send + Sync {
    /// Width and height (pixels).
    fn resolution(&self) -> [u32; 2];

    /// The part of the picture that is rendered: x0, x1, y0, y1 (pixels), x1 and y1 excluded.
    fn crop(&self) -> [u32; 4];

    /// File to write, unless the command line names one; empty if it is called after the scene.
    fn filename(&self) -> &str;

    /// Least and greatest recorded wavelength (nm).
    fn lambda_range(&self) -> [f32; 2];

    /// Names of the channels, as in the EXR file.
    fn channels(&self) -> Vec<String>;

    /// Adds one sample of `radiance` (not yet divided by the wavelengths' densities) to a pixel's sums, one for each channel. There may be
    /// three of them only, for who asks for the colour alone: films begin with red, green and blue.
    fn add(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths, sums: &mut [f64]);

    /// How its picture is shown.
    fn look(&self) -> Look;

    /// The sample of `radiance` as far as the film takes it, before it is weighted.
    fn limited(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> SampledSpectrum;

    /// Radius of the glare around what is bright in the picture that is displayed (pixels, at 550 nm); 0: none.
    fn bloom(&self) -> f64 {
        self.look().bloom
    }
}

/// How a film's colours become those of a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Brightness (stops: powers of two).
    pub exposure: f64,
    /// The tone curve, by its name: what becomes of what is brighter than a screen.
    pub curve: &'static str,
    /// Radius of the glare of an aperture (pixels, at 550 nm); 0: none.
    pub bloom: f64,
}

impl Default for Look {
    fn default() -> Self {
        Self { exposure: 0.0, curve: "clip", bloom: 0.0 }
    }
}
