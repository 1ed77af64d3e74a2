//! Spectra: numbers, colours, tables, files, black bodies and measured data.
//!
//! Spectra are not built like other plugins, because a scene does not name their kind: the type word and the values of a
//! parameter tell it. [`Builder`] looks at them and hands the parameter to one of [`ALL`].
//!
//! | in the scene | plugin |
//! |---|---|
//! | `"float x" 0.5`, `"spectrum x" 0.5` | `constant` |
//! | `"spectrum x" [400 0.1  500 0.8  700 0.9]` | `table` |
//! | `"spectrum x" "paint.spd"` (ends in `.spd`, or contains `/` or `.`) | `file` |
//! | `"spectrum x" "cornell-white"` | `builtin` |
//! | `"rgb x" [0.8 0.1 0.1]` | `rgb` |
//! | `"blackbody x" 5500` | `blackbody` |
//! | `"tolman x" 3000` | `tolman` |
//!
//! Outside its data a table keeps its end value. `"spectrum x" ["paint.spd" "zero-outside"]` makes it zero there, and a
//! table written in the scene may end with a step to zero (see `table`).

use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::params::{Context, SpectrumSource};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use std::sync::Arc;

mod blackbody;
mod builtin;
mod colorimetry;
mod constant;
mod file;
mod planck;
mod quadrature;
mod rgb;
mod rgb_emission;
mod sellmeier;
mod table;
mod tabulated;
mod tolman;
mod upsample;
mod upsample_table;

pub use rgb_emission::rgb_emission;
pub use upsample::Sigmoid;
pub use upsample_table::SmoothSpectra;

/// A spectrum, or everything that is wrong with its parameter.
pub type Built = Result<Arc<dyn Spectrum>, Vec<Diagnostic>>;

/// One way to describe a spectrum.
#[derive(Clone, Copy)]
pub struct SpectrumPlugin {
    /// The name in the reference; scenes do not write it.
    pub name: &'static str,
    /// One sentence for `bhs plugins`.
    pub summary: &'static str,
    /// Builds the spectrum that the parameter describes, for what it is used.
    pub build: fn(&Param, SpectrumRole, &Context) -> Built,
}

/// All ways to describe a spectrum.
pub const ALL: &[SpectrumPlugin] =
    &[blackbody::PLUGIN, builtin::PLUGIN, constant::PLUGIN, file::PLUGIN, rgb::PLUGIN, table::PLUGIN, tolman::PLUGIN];

/// The names of the built-in spectra, in the order of the reference.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    builtin::names()
}

/// The standard illuminant D65, scaled to luminance 1: a surface of reflectance 1 under it has the linear sRGB colour (1, 1, 1).
pub fn d65() -> &'static dyn Spectrum {
    &colorimetry::colorimetry().d65
}

/// What the eye sees of a spectrum, relative to one that is 1 at all wavelengths: `integral(L ybar) / integral(ybar)`.
pub fn luminance(spectrum: &dyn Spectrum) -> f64 {
    let (mut seen, mut total) = (0.0, 0.0);
    for [lambda, _, y, _] in bhs_colour::standard_observer() {
        seen += y * f64::from(spectrum.at(*lambda as f32));
        total += y;
    }
    seen / total
}

/// Makes spectra from parameters with the plugins of this crate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Builder;

impl SpectrumSource for Builder {
    fn build(&self, param: &Param, role: SpectrumRole, context: &Context) -> Built {
        let plugin = match (param.ty.value, &param.values) {
            (ParamType::Rgb, _) => rgb::PLUGIN,
            (ParamType::Blackbody, _) => blackbody::PLUGIN,
            (ParamType::Tolman, _) => tolman::PLUGIN,
            (ParamType::Float, _) => constant::PLUGIN,
            (_, Values::Numbers { values, .. }) if values.len() <= 1 => constant::PLUGIN,
            (_, Values::Numbers { .. }) => table::PLUGIN,
            (_, Values::Strings(s)) if s.first().is_some_and(|s| file::is_path(&s.value)) => file::PLUGIN,
            (_, Values::Strings(_)) => builtin::PLUGIN,
            (_, Values::Bools(_)) => return Err(vec![wrong_value(param, "a number, wavelength-value pairs or a name")]),
        };
        (plugin.build)(param, role, context)
    }
}

/// The error that the values of `param` are not what was expected.
fn wrong_value(param: &Param, expected: &str) -> Diagnostic {
    Diagnostic::error("wrong-value", format!("`{}` expects {expected}", param.name.value))
        .at(param.span, format!("found {}", param.values.describe()))
}

/// The numbers of `param`; an empty list where it has none.
fn numbers(param: &Param) -> &[f64] {
    match &param.values {
        Values::Numbers { values, .. } => values,
        _ => &[],
    }
}

/// Why `value` cannot be used as `role`, in words that stand under the underlined text.
fn fault(value: f64, role: SpectrumRole) -> Option<&'static str> {
    match role {
        SpectrumRole::Reflectance if !(0.0..=1.0).contains(&value) => Some("a reflectance lies between 0 and 1"),
        SpectrumRole::Emission if value < 0.0 => Some("emitted light is not negative"),
        SpectrumRole::Unbounded if value < 0.0 => Some("a negative value has no meaning here"),
        // Spectra are evaluated in single precision.
        _ if value > f64::from(f32::MAX) => Some("this number is too large"),
        _ => None,
    }
}

/// Refuses the first of `values` that cannot be used as `role`; `place` says where it stands, such as ` at 500 nm`.
fn check_role(
    param: &Param,
    span: Span,
    role: SpectrumRole,
    values: impl IntoIterator<Item = (f64, String)>,
) -> Result<(), Vec<Diagnostic>> {
    for (value, place) in values {
        if let Some(cause) = fault(value, role) {
            let shown = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
            let message = format!("`{}` is {shown}{place}", param.name.value);
            return Err(vec![Diagnostic::error("bad-value", message).at(span, cause)]);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    bhs_core::every_file_is_listed!([ALL], helpers: ["colorimetry", "planck", "quadrature", "rgb_emission", "sellmeier", "tabulated", "upsample", "upsample_table"]);
}
