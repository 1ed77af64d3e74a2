//! `projection`: a point that throws a picture, like a slide projector.
//!
//! The light shines along the +z of its space, the picture upright with its upper edge towards +y and its left one towards -x. Its shorter side
//! fills the angle `fov`. A red, green and blue of 1 is D65 with an intensity of luminance 1; beyond the edges there is no light. Names and
//! conventions are pbrt-v4's.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | the picture |
//! | `fov` | float | 90 | deg | the angle of its shorter side |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `power` | float | none | | instead of the strength of the picture: power weighted by the eye |
//!
//! ```text
//! LightSource "projection" "string filename" "slide.png" "float fov" 40 "float scale" 20
//! ```

use crate::picture::{self, Picture};
use crate::{factor_of, mean, rescale_to, scale, turn_to_light};
use bhs_core::light::Light;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum};
use bhs_elementary::Elementary;
use bhs_spectra::{d65, rgb_emission};
use glam::{DMat3, DVec2, DVec3};

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> = Plugin { name: "projection", summary: "a point that throws a picture", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let filename = p.require::<String>("filename", "", "the picture");
    let fov = p.get_in("fov", 90.0, 1e-3..=179.999, "deg", "the angle of its shorter side");
    let scale = scale(p);
    let picture = filename.and_then(|f| picture::read(p, f)).map(Picture::new);
    let mut light = picture.as_ref().map(|picture| {
        let [width, height] = picture.size().map(|n| n as f64);
        let shorter = (fov.to_radians() / 2.0).tangent();
        Screen { half: DVec2::new(width, height) / width.min(height) * shorter }
    });
    let flux = match (&picture, &light) {
        (Some(picture), Some(screen)) => screen.flux(picture),
        _ => 1.0,
    };
    let about = "instead of the strength of the picture: power weighted by the eye";
    let scale = scale * rescale_to(p, "power", about, || flux);
    let [lo, hi] = p.context().lambda_range;
    let greatest = picture.as_ref().map_or(0.0, |p| f64::from(p.greatest()) * f64::from(d65().max(lo, hi)));
    let scale = factor_of(p, "filename", greatest, scale);
    let position = p.context().world_from_object.translation;
    let light_from_chart = turn_to_light(p);
    Some(Box::new(Projection { picture: picture?, screen: light.take()?, flux, scale, position, light_from_chart }))
}

/// The picture in the plane at z = 1.
struct Screen {
    /// Half its width and height.
    half: DVec2,
}

impl Screen {
    /// The luminous flux of a picture: the integral of its luminance over solid angle.
    fn flux(&self, picture: &Picture) -> f64 {
        let [width, height] = picture.size();
        let texel = |x: usize, y: usize| {
            let at = DVec2::new((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
            let place = (2.0 * at - 1.0) * self.half;
            // The area's solid angle falls off with the cube of the cosine.
            bhs_colour::luminance(picture.texel(x, y)) * (1.0 + place.length_squared()).power(-1.5)
        };
        let sum: f64 = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).sum();
        4.0 * self.half.x * self.half.y * sum / (width * height) as f64
    }
}

struct Projection {
    picture: Picture,
    screen: Screen,
    flux: f64,
    scale: f32,
    /// Render space.
    position: DVec3,
    light_from_chart: DMat3,
}

impl Light for Projection {
    fn position(&self) -> Option<DVec3> {
        Some(self.position)
    }

    fn intensity(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let w = (self.light_from_chart * direction).normalize_or_zero();
        if w.z < 1e-3 {
            return SampledSpectrum::ZERO;
        }
        let place = DVec2::new(w.x, -w.y) / w.z / self.screen.half;
        if place.abs().max_element() > 1.0 {
            return SampledSpectrum::ZERO;
        }
        let [width, height] = self.picture.size();
        let at = |v: f64, n: usize| ((0.5 * (v + 1.0) * n as f64).max(0.0) as usize).min(n - 1);
        rgb_emission(self.picture.texel(at(place.x, width), at(place.y, height)), lambda_nm) * self.scale
    }

    fn power(&self, lo: f32, hi: f32, _: f64) -> f64 {
        self.flux * mean(d65(), lo, hi) * f64::from(self.scale)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.position -= origin;
    }
}
