//! `diffuse`: an area light that sends the same radiance in all directions.
//!
//! The light leaves on the outer side of the shape (which `ReverseOrientation` turns), or on both. The exitance of a side is
//! pi L. The radiance is that which an observer who rests on the surface sees. It may be a texture, or a picture: its lower left corner
//! has the texture coordinates (0, 0), and a red, green and blue of 1 is D65 of luminance 1.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `L` | spectrum, texture | 1 | W m^-2 sr^-1 nm^-1 | emitted spectral radiance |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `filename` | string | none | | a picture of the radiance, instead of `L` |
//! | `twosided` | bool | false | | whether both sides emit |
//! | `luminance` | float | none | | instead of the strength of `L`: radiance weighted by the eye, `integral(L ybar) / integral(ybar)` |
//! | `power` | float | none | | instead of the strength of `L`: power of each shape weighted by the eye, over all directions and both sides |
//!
//! ```bhs
//! WorldBegin
//! AreaLightSource "diffuse" "spectrum L" 10 "bool twosided" true
//! Shape "sphere" "float radius" 0.1
//! ```

use crate::picture::{self, Picture};
use crate::{factor, factor_of, luminance_of, mean, mean_of, rescale_to, scale};
use bhs_core::light::{AreaLight, Emission, EmissionPoint};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use bhs_core::texture::{SpectrumParameter, Texture};
use bhs_spectra::{d65, rgb_emission};
use glam::Vec2;
use std::f64::consts::PI;
use std::sync::Arc;

/// The entry in the list of area lights.
pub const PLUGIN: Plugin<dyn AreaLight> =
    Plugin { name: "diffuse", summary: "an area light with the same radiance in all directions", build };

fn build(p: &Params) -> Option<Box<dyn AreaLight>> {
    let about = "emitted spectral radiance";
    let radiance = p.spectrum_parameter("L", 1.0, SpectrumRole::Emission, "W m^-2 sr^-1 nm^-1", about);
    let scale = scale(p);
    let filename = p.optional::<String>("filename", "", "a picture of the radiance, instead of `L`");
    let two_sided = p.get("twosided", false, "", "whether both sides emit");
    let about = "instead of the strength of `L`: radiance weighted by the eye, integral(L ybar) / integral(ybar)";
    let luminance = rescale_to(p, "luminance", about, || match &radiance {
        SpectrumParameter::Spectrum(spectrum) => bhs_spectra::luminance(spectrum.as_ref()),
        SpectrumParameter::Texture { .. } => 1.0,
    });
    let power = p.optional::<f64>(
        "power",
        "",
        "instead of the strength of `L`: power of each shape weighted by the eye, over all directions and both sides",
    );
    let is_spectrum = filename.is_none() && matches!(radiance, SpectrumParameter::Spectrum(_));
    if p.is_given("luminance") && !is_spectrum {
        p.reject("luminance", "`luminance` needs a spectrum `L`", "a picture or a texture says how bright it is");
    }
    if p.is_given("luminance") && p.is_given("power") {
        p.reject("luminance", "`luminance` and `power` exclude each other", "each says how bright the light is");
    }
    if power.is_some_and(|power| power <= 0.0) {
        p.reject("power", "`power` must be above 0", "");
    }
    let scale = scale * luminance;
    let (radiance, scale) = match (filename, radiance) {
        (Some(filename), _) => {
            if p.is_given("L") {
                p.reject("L", "`L` and `filename` exclude each other", "the picture says how bright the light is");
            }
            let picture = picture::read(p, filename).map(Picture::new);
            let [lo, hi] = p.context().lambda_range;
            let greatest = picture.as_ref().map_or(0.0, |p| f64::from(p.greatest()) * f64::from(d65().max(lo, hi)));
            let scale = factor_of(p, "filename", greatest, scale);
            (Radiance::Picture(Arc::new(picture?)), scale)
        }
        (None, SpectrumParameter::Spectrum(spectrum)) => {
            let scale = factor(p, "L", spectrum.as_ref(), scale);
            (Radiance::Spectrum(spectrum), scale)
        }
        (None, SpectrumParameter::Texture { texture, .. }) => (Radiance::Texture(texture), factor_of(p, "L", 1.0, scale)),
    };
    Some(Box::new(Diffuse { radiance, scale, two_sided, power }))
}

/// Spectral radiance.
#[derive(Clone)]
enum Radiance {
    /// The same at all points.
    Spectrum(Arc<dyn Spectrum>),
    Texture(Arc<dyn Texture>),
    Picture(Arc<Picture>),
}

struct Diffuse {
    radiance: Radiance,
    scale: f32,
    two_sided: bool,
    /// Of each shape, weighted by the eye, times `scale`.
    power: Option<f64>,
}

impl Diffuse {
    /// The mean luminance of a side, before `scale`, of textures at even places.
    fn mean_luminance(&self) -> f64 {
        const N: u32 = 32;
        let cell = |i: u32| (i as f32 + 0.5) / N as f32;
        let at = |uv| luminance_of(|lambda_nm| self.at(uv, lambda_nm, 1.0));
        match &self.radiance {
            Radiance::Spectrum(spectrum) => bhs_spectra::luminance(spectrum.as_ref()),
            Radiance::Picture(picture) => picture.mean_luminance(),
            Radiance::Texture(_) => (0..N * N).map(|i| at(Vec2::new(cell(i % N), cell(i / N)))).sum::<f64>() / f64::from(N * N),
        }
    }

    /// The radiance of a side that emits, before `scale`.
    #[inline]
    fn at(&self, uv: Vec2, lambda_nm: [f32; N_LAMBDA], clock_rate: f32) -> SampledSpectrum {
        match &self.radiance {
            Radiance::Spectrum(spectrum) => spectrum.sample_at(lambda_nm, clock_rate),
            Radiance::Texture(texture) => texture.spectrum(&Shading::at_uv(uv, lambda_nm)).map(|v| v.max(0.0)),
            Radiance::Picture(picture) => rgb_emission(picture.at(uv), lambda_nm),
        }
    }
}

impl AreaLight for Diffuse {
    fn radiance(&self, at: &Emission) -> SampledSpectrum {
        if at.cos_theta > 0.0 || (self.two_sided && at.cos_theta < 0.0) {
            self.at(at.uv, at.lambda_nm, at.clock_rate) * self.scale
        } else {
            SampledSpectrum::ZERO
        }
    }

    fn exitance(&self, at: &EmissionPoint, lo: f32, hi: f32) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        let mean = match &self.radiance {
            Radiance::Spectrum(spectrum) => mean(spectrum.as_ref(), lo, hi),
            _ => mean_of(|lambda_nm| self.at(at.uv, lambda_nm, 1.0), lo, hi),
        };
        PI * mean * f64::from(self.scale) * sides
    }

    fn is_uniform(&self) -> bool {
        matches!(self.radiance, Radiance::Spectrum(_))
    }

    fn of_area(&self, area: f64) -> Option<Arc<dyn AreaLight>> {
        let power = self.power?;
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        let factor = power / (PI * area * sides * self.mean_luminance());
        let scale = (f64::from(self.scale) * factor) as f32;
        let scale = if scale.is_finite() { scale } else { 0.0 };
        Some(Arc::new(Self { radiance: self.radiance.clone(), scale, two_sided: self.two_sided, power: None }))
    }
}
