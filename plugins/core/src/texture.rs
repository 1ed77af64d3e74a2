//! Values that vary over surfaces, and the parameters that may be such.
//!
//! A material keeps a [`SpectrumParameter`] or a [`FloatParameter`] for what a scene may texture. It is evaluated at the shading
//! point and the wavelengths there; a plain spectrum costs what it costs without textures.

use crate::composite::Composite;
use crate::diagnostics::{Diagnostic, Spanned};
use crate::image::Image;
use crate::material::{Material, Shading};
use crate::params::{Constant, Context, FromParam, ParamInfo, Params};
use crate::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use crate::value::{Param, ParamType, Values};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// What a texture is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureKind {
    /// Spectra for the given use.
    Spectrum(SpectrumRole),
    /// Numbers.
    Float,
}

/// A value that varies over a surface. It is made for one [`TextureKind`], and answers to that.
pub trait Texture: Send + Sync {
    /// The spectrum at a point, at its wavelengths.
    fn spectrum(&self, at: &Shading) -> SampledSpectrum;

    /// The number at a point.
    fn float(&self, at: &Shading) -> f32;

    /// The texture as one that is made of others, if it is.
    fn composite(&self) -> Option<&dyn Composite> {
        None
    }
}

/// What plugins may ask for by the name that the scene gives it; each thing is made once, when it is first asked for.
pub trait Named {
    /// The texture called `name`.
    ///
    /// # Errors
    /// If there is none of that kind.
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>>;

    /// The material called `name`.
    ///
    /// # Errors
    /// If there is none.
    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>>;

    /// The picture in the file `path`, which starts at the folder of the file that it stands in.
    ///
    /// # Errors
    /// What is wrong with the file, in words that can follow "cannot read `path`: ".
    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String>;

    /// What the texture that is being made is for.
    fn kind(&self) -> TextureKind {
        TextureKind::Spectrum(SpectrumRole::Unbounded)
    }
}

/// A scene in which nothing has a name.
#[derive(Clone, Copy, Debug)]
pub struct Nameless;

impl Named for Nameless {
    fn texture(&self, name: &Spanned<String>, _: TextureKind, _: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        Err(Diagnostic::error("unknown-texture", format!("unknown texture `{}`", name.value)).at(name.span, "").into())
    }

    fn material(&self, name: &Spanned<String>, _: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        Err(Diagnostic::error("unknown-material", format!("unknown material `{}`", name.value)).at(name.span, "").into())
    }

    fn image(&self, _: &Spanned<String>, _: &Context) -> Result<Arc<Image>, String> {
        Err("no file is read here".into())
    }
}

/// A spectrum, the same all over a surface or not.
#[derive(Clone)]
pub enum SpectrumParameter {
    /// The same everywhere.
    Spectrum(Arc<dyn Spectrum>),
    /// One that varies, at most `max`.
    Texture {
        /// The values.
        texture: Arc<dyn Texture>,
        /// Their upper bound: 1 for a reflectance.
        max: f32,
    },
}

impl SpectrumParameter {
    /// Whether it is the same all over a surface.
    pub fn is_uniform(&self) -> bool {
        matches!(self, Self::Spectrum(_))
    }

    /// The values at a point, at its wavelengths.
    #[inline]
    pub fn sample(&self, at: &Shading) -> SampledSpectrum {
        match self {
            Self::Spectrum(spectrum) => spectrum.sample(at.lambda_nm),
            Self::Texture { texture, max } => texture.spectrum(at).map(|v| v.clamp(0.0, *max)),
        }
    }
}

/// A number, the same all over a surface or not.
#[derive(Clone)]
pub enum FloatParameter {
    /// The same everywhere.
    Constant(f32),
    /// One that varies, kept in a range.
    Texture {
        /// The values.
        texture: Arc<dyn Texture>,
        /// Least and greatest value.
        range: [f32; 2],
    },
}

impl FloatParameter {
    /// The value at a point.
    #[inline]
    pub fn at(&self, at: &Shading) -> f32 {
        match self {
            Self::Constant(value) => *value,
            Self::Texture { texture, range: [lo, hi] } => texture.float(at).clamp(*lo, *hi),
        }
    }
}

/// What a texture is made of: a plain value, or another texture.
#[derive(Clone)]
pub enum TextureInput {
    /// A number.
    Number(f32),
    /// A spectrum.
    Spectrum(Arc<dyn Spectrum>),
    /// Another texture.
    Texture(Arc<dyn Texture>),
}

impl TextureInput {
    /// The spectrum at a point, at its wavelengths.
    #[inline]
    pub fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        match self {
            Self::Number(value) => SampledSpectrum::splat(*value),
            Self::Spectrum(spectrum) => spectrum.sample(at.lambda_nm),
            Self::Texture(texture) => texture.spectrum(at),
        }
    }

    /// The number at a point; 0 of a spectrum, which no texture of numbers is made of.
    #[inline]
    pub fn float(&self, at: &Shading) -> f32 {
        match self {
            Self::Number(value) => *value,
            Self::Spectrum(_) => 0.0,
            Self::Texture(texture) => texture.float(at),
        }
    }
}

/// The type word of a spectrum that may be a texture.
const SPECTRUM_OR_TEXTURE: &str = "spectrum, texture";

/// Parameters that may be textures.
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

    /// The part `name` of a texture, of the kind that is being made.
    pub fn texture_input(&self, name: &'static str, default: f32, about: &'static str) -> TextureInput {
        let kind = self.context().named.kind();
        let ty = match kind {
            TextureKind::Spectrum(_) => SPECTRUM_OR_TEXTURE,
            TextureKind::Float => "float, texture",
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
            TextureKind::Float => {
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
