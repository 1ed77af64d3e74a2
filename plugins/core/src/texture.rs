//! Values that vary over surfaces, and what may be such. (How parameters are read that may be textures: [`crate::params`].)
//!
//! A material keeps a [`SpectrumParameter`] or a [`FloatParameter`] for what a scene may texture. It is evaluated at the shading
//! point and the wavelengths there; a plain spectrum costs what it costs without textures.

use crate::material::Shading;
use crate::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use glam::Vec3;
use std::sync::Arc;

pub mod composite;

use composite::Composite;

/// What a texture is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureKind {
    /// Spectra for the given use.
    Spectrum(SpectrumRole),
    /// Numbers.
    Float,
    /// Three numbers, as a picture holds them: of a normal map.
    Triple,
}

/// A value that varies over a surface. It is made for one [`TextureKind`], and answers to that.
pub trait Texture: Send + Sync {
    /// The spectrum at a point, at its wavelengths.
    fn spectrum(&self, at: &Shading) -> SampledSpectrum;

    /// The number at a point.
    fn float(&self, at: &Shading) -> f32;

    /// The three numbers at a point; `None`: it is no picture, and has none anywhere.
    fn triple(&self, _at: &Shading) -> Option<Vec3> {
        None
    }

    /// The texture as one that is made of others, if it is.
    fn composite(&self) -> Option<&dyn Composite> {
        None
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

/// Three numbers that vary over a surface.
pub enum TripleParameter {
    /// The file of a picture, as the scene writes its path.
    File(String),
    /// A texture.
    Texture(Arc<dyn Texture>),
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
