//! What a scene gives a name: textures, materials, pictures.

use super::Context;
use crate::diagnostics::{Diagnostic, Spanned};
use crate::image::Image;
use crate::material::Material;
use crate::spectrum::SpectrumRole;
use crate::texture::{Texture, TextureKind};
use std::sync::Arc;

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

    /// Says that the texture that is being made looks at [`Shading::beside`](crate::material::Shading::beside), which is found in scenes with such
    /// textures only.
    fn wants_patches(&self) {}

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
