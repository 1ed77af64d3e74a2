//! `infinite`: a sky all around, infinitely far away; of one radiance, or a picture of it.
//!
//! The light of every ray that leaves the scene. The radiance is that which an observer at rest far from any hole sees. A picture is
//! equirectangular, or square and of equal areas (`mapping`; pbrt-v4's are). In the space of the light, +z is up: the top row of
//! an equirectangular picture is +z, its left edge +x, and it goes on towards +y; one of equal areas has +z in its middle. A red,
//! green and blue of 1 is D65 of luminance 1, which is also the sky of which nothing is said. Light sampling draws
//! directions of a picture by its luminance; the sky of one radiance is found by BSDF sampling.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `L` | spectrum | D65 | W m^-2 sr^-1 nm^-1 | spectral radiance |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `filename` | string | none | | a picture of the sky, instead of `L` |
//! | `mapping` | string | "equirectangular" | | how a picture is laid out: `equirectangular`, or `equalarea` |
//! | `illuminance` | float | none | | irradiance from the upper half (+z), weighted by the eye, to which it is scaled |
//!
//! ```bhs
//! WorldBegin
//! LightSource "infinite" "spectrum L" 0.5
//! ```

use crate::picture;
use crate::sky_map::{Layout, SkyMap};
use crate::{factor, factor_of, rescale_to, scale, sky_from_chart};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::image::Image;
use bhs_core::light::{Light, SkySample};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use bhs_spectra::{d65, luminance, rgb_emission, white};
use glam::{DMat3, DVec3, Vec2};
use std::f64::consts::PI;
use std::sync::Arc;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> =
    Plugin { name: "infinite", summary: "a sky all around, of one radiance or a picture of it", build };

/// The sky of which nothing is said: D65 of luminance 1, which films show as white (1, 1, 1), as in pbrt.
const WHITE: &str = "D65";

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let radiance = p
        .optional_spectrum("L", WHITE.to_owned(), SpectrumRole::Emission, "W m^-2 sr^-1 nm^-1", "spectral radiance")
        .unwrap_or_else(white);
    let scale = scale(p);
    let filename = p.optional::<String>("filename", "", "a picture of the sky, instead of `L`");
    let about = "irradiance from the upper half (+z), weighted by the eye, to which it is scaled";
    let about_mapping = "how a picture is laid out: `equirectangular`, or `equalarea`";
    let mapping = p.get("mapping", "equirectangular".to_owned(), "", about_mapping);
    let Some(filename) = filename else {
        let scale = scale * rescale_to(p, "illuminance", about, || PI * luminance(radiance.as_ref()));
        let scale = factor(p, "L", radiance.as_ref(), scale);
        return Some(Box::new(Uniform { radiance, scale }));
    };
    if p.is_given("L") {
        p.reject("L", "`L` and `filename` exclude each other", "the picture says how bright the sky is");
    }
    let image = picture::read(p, filename);
    let layout = layout(p, &mapping, image.as_deref());
    let map = image.map(|image| SkyMap::new(image, layout));
    let scale = scale * rescale_to(p, "illuminance", about, || map.as_ref().map_or(1.0, SkyMap::illuminance));
    let [lo, hi] = p.context().lambda_range;
    let greatest = map.as_ref().map_or(0.0, |m| f64::from(m.greatest()) * f64::from(d65().max(lo, hi)));
    let scale = factor_of(p, "filename", greatest, scale);
    let map_from_chart = sky_from_chart(p)?;
    Some(Box::new(Pictured { map: map?, map_from_chart, scale }))
}

/// How the picture `image` is laid out. One of equal areas is square.
fn layout(p: &Params, mapping: &str, image: Option<&Image>) -> Layout {
    match mapping {
        "equirectangular" => {}
        "equalarea" if image.is_none_or(|i| i.width == i.height) => return Layout::EqualArea,
        "equalarea" => {
            let size = image.map_or([0; 2], |i| [i.width, i.height]);
            p.report(
                Diagnostic::warning("sky-layout", "this sky is read as equirectangular: one of equal areas is square")
                    .at(p.span_of("filename"), format!("it has {} x {} pixels", size[0], size[1]))
                    .help("pbrt's `imgtool makeequiarea` makes a square one of it"),
            );
        }
        _ => p.reject("mapping", "unknown mapping", "expected `equirectangular` or `equalarea`"),
    }
    Layout::Equirectangular
}

/// A sky of one radiance.
struct Uniform {
    radiance: Arc<dyn Spectrum>,
    scale: f32,
}

impl Light for Uniform {
    fn sky_radiance(&self, _: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        self.radiance.sample(lambda_nm) * self.scale
    }
}

/// A sky as in a picture.
struct Pictured {
    map: SkyMap,
    map_from_chart: DMat3,
    scale: f32,
}

impl Light for Pictured {
    fn sky_radiance(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        rgb_emission(self.map.colour(self.map_from_chart * direction), lambda_nm) * self.scale
    }

    fn sample_sky(&self, u: Vec2) -> Option<SkySample> {
        let (direction, pdf) = self.map.sample(u)?;
        Some(SkySample { direction: self.map_from_chart.transpose() * direction, pdf, is_parallel: false })
    }

    fn sky_pdf(&self, direction: DVec3) -> f64 {
        self.map.pdf(self.map_from_chart * direction)
    }

    fn power(&self, lo: f32, hi: f32, radius: f64) -> f64 {
        PI * radius * radius * self.map.total() * crate::mean(d65(), lo, hi) * f64::from(self.scale)
    }
}
