//! `rgb`: a colour in linear sRGB, raised to a smooth spectrum.
//!
//! A reflectance is the smooth spectrum whose colour under the illuminant D65 is the given one; equal components give a
//! constant. Emission (r, g, b) is `2 m s(lambda) D65(lambda)`, m the largest component, s the reflectance of colour
//! (r, g, b)/(2 m) and D65 scaled to luminance 1: a film shows it as (r, g, b). Other values are `2 m s(lambda)`.
//! Outside 360..830 nm the spectrum keeps its end value. All colours of the gamut, its edges included, come back from a film to
//! within 2e-5 of the largest component.
//!
//! Source: Jakob and Hanika 2019; the use for emission as in pbrt-v4 (Pharr, Jakob and Humphreys 2023, section 4.6.6).
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | three numbers | `rgb` | that of the parameter | red, green, blue; 0 to 1 for a reflectance |
//!
//! ```bhs
//! Material "diffuse" "rgb reflectance" [0.8 0.1 0.1]
//! ```

use crate::colorimetry::colorimetry;
use crate::tabulated::Tabulated;
use crate::upsample::Sigmoid;
use crate::{Built, Maker, check_role, numbers, wrong_value};
use bhs_core::Plugin;
use bhs_core::params::{Constant, Context, SpectrumMaker};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::Param;
use std::fmt;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "rgb",
    summary: "a colour in linear sRGB, raised to a smooth spectrum",
    build: |_| Some(Box::new(Maker(make))),
};

/// `scale` times a smooth spectrum, times an illuminant if there is one.
struct Rgb {
    scale: f32,
    shape: Sigmoid,
    illuminant: Option<&'static Tabulated>,
}

fn make(param: &Param, role: SpectrumRole, _: &Context) -> Built {
    let &[r, g, b] = numbers(param) else {
        return Err(vec![wrong_value(param, "three numbers: red, green and blue")]);
    };
    let channels = [(r, " in red".to_owned()), (g, " in green".to_owned()), (b, " in blue".to_owned())];
    check_role(param, param.span, role, channels)?;
    let largest = r.max(g).max(b);
    let grey = r == g && g == b;
    if largest == 0.0 || (grey && role != SpectrumRole::Emission) {
        return Ok(Arc::new(Constant(largest as f32)));
    }
    let scale = if role == SpectrumRole::Reflectance { 1.0 } else { 2.0 * largest };
    let illuminant = (role == SpectrumRole::Emission).then(|| &*colorimetry().d65);
    Ok(Arc::new(Rgb { scale: scale as f32, shape: Sigmoid::fit([r, g, b].map(|c| c / scale)), illuminant }))
}

impl Spectrum for Rgb {
    fn at(&self, lambda_nm: f32) -> f32 {
        self.scale * self.shape.at(lambda_nm) * self.illuminant.map_or(1.0, |i| i.at(lambda_nm))
    }

    fn max(&self, lo: f32, hi: f32) -> f32 {
        self.scale * self.shape.max(lo, hi) * self.illuminant.map_or(1.0, |i| i.max(lo, hi))
    }
}

impl fmt::Debug for Rgb {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Rgb").field("scale", &self.scale).field("shape", &self.shape).finish_non_exhaustive()
    }
}
