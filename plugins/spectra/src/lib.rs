//! Spectra: numbers, colours, tables, files, black bodies and measured data.
//!
//! A scene does not name the plugin of a spectrum: the type word and the values of a parameter tell it, and a text that is no file is a name that
//! one of the plugins knows ([`SpectrumMaker::names`]). [`build_with`] looks at them and hands the parameter to the plugin. Type words
//! (`rgb`, `blackbody`, `tolman`) are the language's: a plugin from outside is asked for by a name.
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

use bhs_core::Plugin;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use bhs_core::params::{Context, Params, SpectrumMaker, SpectrumSource};
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

pub use planck::{HOTTEST, Planck};
pub use rgb_emission::rgb_emission;
pub use upsample::Sigmoid;
pub use upsample_table::SmoothSpectra;

/// A spectrum, or everything that is wrong with its parameter.
pub type Built = Result<Arc<dyn Spectrum>, Vec<Diagnostic>>;

/// A way to describe spectra that is a function, and has no names.
struct Maker(fn(&Param, SpectrumRole, &Context) -> Built);

impl SpectrumMaker for Maker {
    fn make(&self, param: &Param, role: SpectrumRole, context: &Context) -> Built {
        (self.0)(param, role, context)
    }
}

/// All ways to describe a spectrum.
pub const ALL: &[Plugin<dyn SpectrumMaker>] =
    &[blackbody::PLUGIN, builtin::PLUGIN, constant::PLUGIN, file::PLUGIN, rgb::PLUGIN, table::PLUGIN, tolman::PLUGIN];

/// The names of the built-in spectra, in the order of the reference.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    builtin::names()
}

/// The standard illuminant D65, scaled to luminance 1: a surface of reflectance 1 under it has the linear sRGB colour (1, 1, 1).
pub fn d65() -> &'static dyn Spectrum {
    &*colorimetry::colorimetry().d65
}

/// The same, for who keeps it.
pub fn white() -> Arc<dyn Spectrum> {
    colorimetry::colorimetry().d65.clone()
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
        build_with(ALL, param, role, context)
    }
}

/// The spectrum that `param` describes, made by one of the plugins `all`. Where several have a name, it is the last one's.
///
/// # Errors
/// Everything that is wrong with it.
pub fn build_with(all: &[Plugin<dyn SpectrumMaker>], param: &Param, role: SpectrumRole, context: &Context) -> Built {
    let wanted = match (param.ty.value, &param.values) {
        (ParamType::Rgb, _) => rgb::PLUGIN,
        (ParamType::Blackbody, _) => blackbody::PLUGIN,
        (ParamType::Tolman, _) => tolman::PLUGIN,
        (ParamType::Float, _) => constant::PLUGIN,
        (_, Values::Numbers { values, .. }) if values.len() <= 1 => constant::PLUGIN,
        (_, Values::Numbers { .. }) => table::PLUGIN,
        (_, Values::Strings(s)) if s.first().is_some_and(|s| file::is_path(&s.value)) => file::PLUGIN,
        (_, Values::Strings(s)) => return build_named(all, s.first(), param, (role, context)),
        (_, Values::Bools(_)) => return Err(vec![wrong_value(param, "a number, wavelength-value pairs or a name")]),
    };
    // One of the same name may stand in its place.
    let plugin = all.iter().rev().find(|plugin| plugin.name == wanted.name).unwrap_or(&wanted);
    match maker(plugin, context) {
        Some(maker) => maker.make(param, role, context),
        None => Err(vec![wrong_value(param, "a spectrum that can be made")]),
    }
}

/// The spectrum called `name`.
fn build_named(
    all: &[Plugin<dyn SpectrumMaker>],
    name: Option<&Spanned<String>>,
    param: &Param,
    (role, context): (SpectrumRole, &Context),
) -> Built {
    let makers: Vec<_> = all.iter().filter_map(|plugin| maker(plugin, context)).collect();
    if let Some(maker) = makers.iter().rev().find(|maker| name.is_some_and(|name| maker.names().contains(&name.value.as_str()))) {
        return maker.make(param, role, context);
    }
    let (name, _) = tabulated::name_and_outside(param)?;
    Err(vec![unknown(name, makers.iter().flat_map(|maker| maker.names()))])
}

/// What a plugin makes spectra with.
fn maker(plugin: &Plugin<dyn SpectrumMaker>, context: &Context) -> Option<Box<dyn SpectrumMaker>> {
    (plugin.build)(&Params::new(Spanned::new(plugin.name.to_owned(), Span::default()), &[], *context))
}

/// The error that none of the spectra `names` is called `name`.
fn unknown(name: &Spanned<String>, names: impl Iterator<Item = &'static str>) -> Diagnostic {
    let names: Vec<&str> = names.collect();
    let help = did_you_mean(&name.value, names.iter().copied()).map(|near| format!("did you mean `{near}`?"));
    let all = || format!("built-in are {}; a file name ends in `.spd` or contains a `/`", names.join(", "));
    Diagnostic::error("unknown-spectrum", format!("unknown spectrum `{}`", name.value))
        .at(name.span, "no built-in spectrum has this name")
        .help(help.unwrap_or_else(all))
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

/// Refuses the first of `values` that cannot be used as `role`; `place` says where it stands, such as ` at 500 nm`.
fn check_role(
    param: &Param,
    span: Span,
    role: SpectrumRole,
    values: impl IntoIterator<Item = (f64, String)>,
) -> Result<(), Vec<Diagnostic>> {
    for (value, place) in values {
        if let Some(cause) = role.fault(value) {
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
