//! Parameters that are spectra, with numbers or built-in spectra as defaults.

use super::{ParamInfo, Params};
use crate::diagnostics::Spanned;
use crate::spectrum::{Spectrum, SpectrumRole};
use crate::value::{Param, ParamType, Values};
use std::sync::Arc;

/// Parameters that are spectra.
impl Params<'_> {
    /// The spectrum `name`; where the scene does not give it, `default` at all wavelengths.
    pub fn spectrum(
        &self,
        name: &'static str,
        default: f32,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Arc<dyn Spectrum> {
        self.optional_spectrum(name, default.to_string(), role, unit, about).unwrap_or_else(|| Arc::new(Constant(default)))
    }

    /// The spectrum `name`; where the scene does not give it, the built-in spectrum called `default`.
    pub fn named_spectrum(
        &self,
        name: &'static str,
        default: &'static str,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Arc<dyn Spectrum> {
        if let Some(given) = self.optional_spectrum(name, format!("\"{default}\""), role, unit, about) {
            return given;
        }
        self.builtin_spectrum(name, default, role)
    }

    /// The built-in spectrum called `default`, in place of the parameter `name`.
    fn builtin_spectrum(&self, name: &str, default: &str, role: SpectrumRole) -> Arc<dyn Spectrum> {
        let span = self.owner.span;
        let param = Param {
            ty: Spanned::new(ParamType::Spectrum, span),
            name: Spanned::new(name.to_owned(), span),
            values: Values::Strings(vec![Spanned::new(default.to_owned(), span)]),
            span,
        };
        self.build_spectrum(&param, role).unwrap_or_else(|| Arc::new(Constant(1.0)))
    }

    /// The spectrum `name`, if the scene gives it (and it can be built); `shown` is the default for the parameter table.
    pub fn optional_spectrum(
        &self,
        name: &'static str,
        shown: String,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Option<Arc<dyn Spectrum>> {
        self.ask(ParamInfo { name, ty: "spectrum", default: shown, unit, about });
        let param = self.find(name)?;
        match param.ty.value {
            ParamType::Spectrum | ParamType::Rgb | ParamType::Blackbody | ParamType::Tolman | ParamType::Float => {
                self.build_spectrum(param, role)
            }
            other => {
                self.wrong_type(
                    param,
                    &format!("`{name}` takes a spectrum, not a value of the type `{}`", other.word()),
                    "spectrum",
                );
                None
            }
        }
    }

    fn build_spectrum(&self, param: &Param, role: SpectrumRole) -> Option<Arc<dyn Spectrum>> {
        match self.context.spectra.build(param, role, &self.context) {
            Ok(spectrum) => Some(spectrum),
            Err(found) => {
                self.found.borrow_mut().extend(found);
                None
            }
        }
    }
}

/// The same value at all wavelengths.
#[derive(Debug)]
pub struct Constant(pub f32);

impl Spectrum for Constant {
    fn at(&self, _: f32) -> f32 {
        self.0
    }
    fn max(&self, _: f32, _: f32) -> f32 {
        self.0
    }
    fn is_constant(&self) -> bool {
        true
    }
}
