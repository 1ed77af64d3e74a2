//! Textures made of textures, and what it takes to evaluate them in time that grows with their number.
//!
//! A scene may name a part in several places: 40 textures, each made of the one before it twice, are a tree of 2^40 leaves.
//! Where the tree is much larger than that, each part is evaluated once at a point, and its value is kept for the others that
//! have it too. How deep textures may be nested is limited by who makes them (the program's `names`).

use crate::material::Shading;
use crate::spectrum::SampledSpectrum;
use crate::texture::{FloatParameter, Texture, TextureInput};
use std::collections::HashMap;
use std::sync::Arc;

/// Evaluations of parts up to which it costs less to repeat them than to keep their values.
const REPEATED: u64 = 64;

/// A texture that is made of others: it asks its parts by [`TextureInput::spectrum_with`] and its like. All that a [`Texture`] says follows.
pub trait Composite: Send + Sync {
    /// Evaluations of textures that one of this makes if none is kept: [`evaluations`] of its parts.
    fn evaluations(&self) -> u64;

    /// As [`Texture::spectrum`], with what is known of the parts at this very point.
    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum;

    /// As [`Texture::float`], with what is known of the parts at this very point.
    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32;
}

impl<T: Composite> Texture for T {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        self.spectrum_with(at, &mut KnownParts::new(self.evaluations()))
    }

    fn float(&self, at: &Shading) -> f32 {
        self.float_with(at, &mut KnownParts::new(self.evaluations()))
    }

    fn composite(&self) -> Option<&dyn Composite> {
        Some(self)
    }
}

/// Evaluations that a texture makes which is made of parts that make so many; as many as there are numbers, if there are more.
pub fn evaluations(parts: impl IntoIterator<Item = u64>) -> u64 {
    parts.into_iter().fold(1, u64::saturating_add)
}

/// Values of the parts of a texture at one point, by the address of the part.
#[derive(Debug, Default)]
pub struct KnownParts {
    /// `None`: nothing is kept.
    kept: Option<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    spectra: HashMap<usize, SampledSpectrum>,
    floats: HashMap<usize, f32>,
}

fn address(texture: &Arc<dyn Texture>) -> usize {
    Arc::as_ptr(texture).cast::<()>() as usize
}

impl KnownParts {
    /// Nothing is known yet of the parts of a texture that makes so many [`evaluations`].
    #[inline]
    pub fn new(evaluations: u64) -> Self {
        Self { kept: (evaluations > REPEATED).then(Kept::default) }
    }

    /// The spectrum of a part.
    fn spectrum(&mut self, part: &Arc<dyn Texture>, at: &Shading) -> SampledSpectrum {
        let Some(composite) = part.composite() else { return part.spectrum(at) };
        let Some(kept) = &self.kept else { return composite.spectrum_with(at, self) };
        if let Some(value) = kept.spectra.get(&address(part)) {
            return *value;
        }
        let value = composite.spectrum_with(at, self);
        if let Some(kept) = &mut self.kept {
            kept.spectra.insert(address(part), value);
        }
        value
    }

    /// The number of a part.
    fn float(&mut self, part: &Arc<dyn Texture>, at: &Shading) -> f32 {
        let Some(composite) = part.composite() else { return part.float(at) };
        let Some(kept) = &self.kept else { return composite.float_with(at, self) };
        if let Some(value) = kept.floats.get(&address(part)) {
            return *value;
        }
        let value = composite.float_with(at, self);
        if let Some(kept) = &mut self.kept {
            kept.floats.insert(address(part), value);
        }
        value
    }
}

impl TextureInput {
    /// As [`TextureInput::spectrum`], for a part of a texture.
    #[inline]
    pub fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        match self {
            Self::Texture(texture) => known.spectrum(texture, at),
            plain => plain.spectrum(at),
        }
    }

    /// As [`TextureInput::float`], for a part of a texture.
    #[inline]
    pub fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        match self {
            Self::Texture(texture) => known.float(texture, at),
            plain => plain.float(at),
        }
    }

    /// [`Composite::evaluations`] of a part.
    pub fn evaluations(&self) -> u64 {
        match self {
            Self::Texture(texture) => texture.composite().map_or(1, |c| c.evaluations()),
            _ => 0,
        }
    }
}

impl FloatParameter {
    /// As [`FloatParameter::at`], for a part of a texture.
    #[inline]
    pub fn at_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        match self {
            Self::Constant(value) => *value,
            Self::Texture { texture, range: [lo, hi] } => known.float(texture, at).clamp(*lo, *hi),
        }
    }

    /// [`Composite::evaluations`] of a part.
    pub fn evaluations(&self) -> u64 {
        match self {
            Self::Constant(_) => 0,
            Self::Texture { texture, .. } => texture.composite().map_or(1, |c| c.evaluations()),
        }
    }
}
