//! Parameters that may be textures.

use super::{Constant, FromParam, ParamInfo, Params};
use crate::diagnostics::Diagnostic;
use crate::material::Shading;
use crate::spectrum::{N_LAMBDA, Spectrum, SpectrumRole};
use crate::texture::{FloatParameter, SpectrumParameter, Texture, TextureInput, TextureKind, TripleParameter};
use crate::value::{Param, ParamType, Values};
use glam::Vec2;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// The type word of a spectrum that may be a texture.
const SPECTRUM_OR_TEXTURE: &str = "spectrum, texture";

impl Params<'_> {
    /// The spectrum or texture `name`; where the scene does not give it, `default` at all wavelengths.
    pub fn spectrum_parameter(
        &self,
        name: &'static str,
        default: f32,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> SpectrumParameter {
        let texture = self.texture_parameter(name, || default.to_string(), role, unit, about);
        texture.unwrap_or_else(|| self.untextured(self.spectrum(name, default, role, unit, about)))
    }

    /// The spectrum or texture `name`; where the scene does not give it, the built-in spectrum called `default`.
    pub fn named_spectrum_parameter(
        &self,
        name: &'static str,
        default: &'static str,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> SpectrumParameter {
        let texture = self.texture_parameter(name, || format!("\"{default}\""), role, unit, about);
        texture.unwrap_or_else(|| self.untextured(self.named_spectrum(name, default, role, unit, about)))
    }

    /// The spectrum or texture `name`, if the scene gives it; `shown` is the default for the parameter table.
    pub fn optional_spectrum_parameter(
        &self,
        name: &'static str,
        shown: String,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Option<SpectrumParameter> {
        let texture = self.texture_parameter(name, || shown.clone(), role, unit, about);
        texture.or_else(|| {
            let spectrum = self.optional_spectrum(name, shown, role, unit, about);
            self.relabel(SPECTRUM_OR_TEXTURE);
            spectrum.map(SpectrumParameter::Spectrum)
        })
    }

    /// The texture `name`, if the scene gives one; black, if it is at fault and has been reported.
    fn texture_parameter(
        &self,
        name: &'static str,
        shown: impl FnOnce() -> String,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Option<SpectrumParameter> {
        let texture = self.texture(name, TextureKind::Spectrum(role))?;
        self.ask(ParamInfo { name, ty: SPECTRUM_OR_TEXTURE, default: shown(), unit, about });
        let max = if role == SpectrumRole::Reflectance { 1.0 } else { f32::MAX };
        Some(match texture {
            Some(texture) => SpectrumParameter::Texture { texture, max },
            None => SpectrumParameter::Spectrum(Arc::new(Constant(0.0))),
        })
    }

    /// The spectrum that has been read last, which might have been a texture.
    fn untextured(&self, spectrum: Arc<dyn Spectrum>) -> SpectrumParameter {
        self.relabel(SPECTRUM_OR_TEXTURE);
        SpectrumParameter::Spectrum(spectrum)
    }

    /// The number or texture `name`, which must lie in `range`; of a texture, what lies outside is moved to the range's end.
    pub fn float_parameter(
        &self,
        name: &'static str,
        default: f64,
        range: RangeInclusive<f64>,
        unit: &'static str,
        about: &'static str,
    ) -> FloatParameter {
        let given = self.given_float(name, default.to_string(), range, unit, about);
        given.unwrap_or(FloatParameter::Constant(default as f32))
    }

    /// The number or texture `name` as [`Params::float_parameter`] reads it, if the scene gives it.
    pub fn optional_float_parameter(
        &self,
        name: &'static str,
        range: RangeInclusive<f64>,
        unit: &'static str,
        about: &'static str,
    ) -> Option<FloatParameter> {
        self.given_float(name, "none".into(), range, unit, about)
    }

    fn given_float(
        &self,
        name: &'static str,
        shown: String,
        range: RangeInclusive<f64>,
        unit: &'static str,
        about: &'static str,
    ) -> Option<FloatParameter> {
        let (lo, hi) = (*range.start(), *range.end());
        let ty = "float, texture";
        if let Some(texture) = self.texture(name, TextureKind::Float) {
            self.ask(ParamInfo { name, ty, default: shown, unit, about });
            return texture.map(|texture| FloatParameter::Texture { texture, range: [lo as f32, hi as f32] });
        }
        self.ask(ParamInfo { name, ty, default: shown, unit, about });
        let value = self.lookup::<f64>(name)?;
        if !range.contains(&value) {
            let cause = format!("expected a value from {} to {}, found {}", lo.show(), hi.show(), value.show());
            self.reject(name, format!("`{name}` is out of range"), cause);
            return None;
        }
        Some(FloatParameter::Constant(value as f32))
    }

    /// What `name` says of a picture of three numbers: the name of a texture, or the file of a picture, which is left to the caller.
    pub fn triple_parameter(&self, name: &'static str, about: &'static str) -> Option<TripleParameter> {
        const TEXT_OR_TEXTURE: &str = "string, texture";
        let Some(texture) = self.texture(name, TextureKind::Triple) else {
            let file = self.optional::<String>(name, "", about);
            self.relabel(TEXT_OR_TEXTURE);
            return file.map(TripleParameter::File);
        };
        self.ask(ParamInfo { name, ty: TEXT_OR_TEXTURE, default: "none".into(), unit: "", about });
        let texture = texture?;
        if texture.triple(&Shading::at_uv(Vec2::ZERO, [550.0; N_LAMBDA])).is_none() {
            self.reject(name, format!("`{name}` needs a picture"), "this texture is none: it has the plugin \"imagemap\"");
            return None;
        }
        Some(TripleParameter::Texture(texture))
    }

    /// The part `name` of a texture, of the kind that is being made.
    pub fn texture_input(&self, name: &'static str, default: f32, about: &'static str) -> TextureInput {
        self.texture_input_as(self.context().named.kind(), name, default, about)
    }

    /// The same for a part that something else is multiplied with: of light it is no light itself, lest the illuminant count twice.
    pub fn texture_factor(&self, name: &'static str, default: f32, about: &'static str) -> TextureInput {
        let kind = match self.context().named.kind() {
            TextureKind::Spectrum(SpectrumRole::Emission) => TextureKind::Spectrum(SpectrumRole::Unbounded),
            kind => kind,
        };
        self.texture_input_as(kind, name, default, about)
    }

    fn texture_input_as(&self, kind: TextureKind, name: &'static str, default: f32, about: &'static str) -> TextureInput {
        let ty = match kind {
            TextureKind::Spectrum(_) => SPECTRUM_OR_TEXTURE,
            TextureKind::Float | TextureKind::Triple => "float, texture",
        };
        if let Some(texture) = self.texture(name, kind) {
            self.ask(ParamInfo { name, ty, default: default.to_string(), unit: "", about });
            return texture.map_or(TextureInput::Number(default), TextureInput::Texture);
        }
        let input = match kind {
            TextureKind::Spectrum(role) => {
                let given = self.optional_spectrum(name, default.to_string(), role, "", about);
                given.map_or(TextureInput::Number(default), TextureInput::Spectrum)
            }
            TextureKind::Float | TextureKind::Triple => {
                let largest = f64::from(f32::MAX);
                TextureInput::Number(self.get_in(name, f64::from(default), -largest..=largest, "", about) as f32)
            }
        };
        self.relabel(ty);
        input
    }

    /// The texture that the parameter `name` names. `None`: it names none; `Some(None)`: it does, and is at fault.
    fn texture(&self, name: &str, kind: TextureKind) -> Option<Option<Arc<dyn Texture>>> {
        let param = self.find(name).filter(|p| p.ty.value == ParamType::Texture)?;
        let Param { values: Values::Strings(texts), .. } = param else {
            return Some(self.not_a_name(param));
        };
        let [text] = texts.as_slice() else { return Some(self.not_a_name(param)) };
        match self.context().named.texture(text, kind, self.context()) {
            Ok(texture) => Some(Some(texture)),
            Err(fault) => {
                self.report(*fault);
                Some(None)
            }
        }
    }

    fn not_a_name(&self, param: &Param) -> Option<Arc<dyn Texture>> {
        let message = format!("`{}` expects the name of a texture", param.name.value);
        let found = format!("found {}", param.values.describe());
        self.report(Diagnostic::error("wrong-value", message).at(param.span, found));
        None
    }
}
