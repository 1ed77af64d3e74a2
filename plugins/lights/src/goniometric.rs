//! `goniometric`: a point that shines as a picture of all directions says, such as one of a lamp that was measured.
//!
//! The picture is square and has equal solid angles (octahedral, Clarberg 2008); the mean of its channels multiplies `I`. In its own space +z is in
//! the middle; that is the +y of the light's space, whose y and z are exchanged before the picture is looked up, as in pbrt-v4. Without a picture
//! it is a `point`. Numbers of 8 and 16 bits are encoded in sRGB.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `I` | spectrum | 1 | W sr^-1 nm^-1 | spectral intensity where the picture has 1 |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `filename` | string | none | | the picture |
//! | `luminance` | float | none | | instead of the strength of `I`: intensity weighted by the eye where the picture has 1 |
//! | `power` | float | none | | instead of the strength of `I`: power weighted by the eye, over all directions |
//!
//! ```text
//! LightSource "goniometric" "rgb I" [5 5 5] "string filename" "lamp.exr"
//! ```

use crate::from_point::FromPoint;
use crate::picture::{self, Picture};
use crate::{rescale, scale, turn_to_light};
use bhs_core::equal_area::equal_area_point;
use bhs_core::light::Light;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SpectrumRole};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> =
    Plugin { name: "goniometric", summary: "a point that shines as a picture of all directions says", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let intensity = p.spectrum("I", 1.0, SpectrumRole::Emission, "W sr^-1 nm^-1", "spectral intensity where the picture has 1");
    let scale = scale(p);
    let filename = p.optional::<String>("filename", "", "the picture");
    let picture = match filename {
        Some(filename) => Some(Picture::new(picture::read(p, filename)?)),
        None => None,
    };
    if let Some([width, height]) = picture.as_ref().map(Picture::size)
        && width != height
    {
        p.reject("filename", "a picture of all directions is square", format!("it has {width} x {height} pixels"));
    }
    let mean_share = picture.as_ref().map_or(1.0, mean_share);
    let about = "instead of the strength of `I`: intensity weighted by the eye where the picture has 1";
    let luminance = rescale(p, "luminance", about, intensity.as_ref(), 1.0);
    let position = p.context().world_from_object.translation;
    let source = FromPoint::read(p, (intensity, scale * luminance), 4.0 * PI * mean_share, position);
    if p.is_given("luminance") && p.is_given("power") {
        p.reject("luminance", "`luminance` and `power` exclude each other", "each says how bright the light is");
    }
    Some(Box::new(Goniometric { source, picture, light_from_chart: turn_to_light(p) }))
}

/// The share of a picture at a pixel: the mean of its channels.
fn share(picture: &Picture, x: usize, y: usize) -> f32 {
    picture.texel(x, y).iter().sum::<f32>() / 3.0
}

fn mean_share(picture: &Picture) -> f64 {
    let [width, height] = picture.size();
    let sum: f64 = (0..height).flat_map(|y| (0..width).map(move |x| f64::from(share(picture, x, y)))).sum();
    sum / (width * height) as f64
}

struct Goniometric {
    source: FromPoint,
    picture: Option<Picture>,
    light_from_chart: DMat3,
}

impl Light for Goniometric {
    fn position(&self) -> Option<DVec3> {
        Some(self.source.position)
    }

    fn intensity(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let share = self.picture.as_ref().map_or(1.0, |picture| {
            let w = (self.light_from_chart * direction).normalize_or_zero();
            let p = equal_area_point(DVec3::new(w.x, w.z, w.y));
            let [width, height] = picture.size();
            let at = |share: f64, n: usize| ((share.max(0.0) * n as f64) as usize).min(n - 1);
            share(picture, at(p.x, width), at(p.y, height))
        });
        self.source.intensity(share, lambda_nm)
    }

    fn power(&self, lo: f32, hi: f32, _: f64) -> f64 {
        self.source.power(lo, hi)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.source.position -= origin;
    }
}
