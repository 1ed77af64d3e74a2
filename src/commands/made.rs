//! What is written of a picture.

use crate::header::{self, Facts};
use crate::image::{Attribute, Picture};
use crate::lang::BuiltScene;
use crate::layers::LayerPicture;
use crate::output::Writer;
use crate::render::Rendered;
use anyhow::Result;

/// What is written of a picture: its channels, its layers as files have them, and what is said about it.
pub(super) struct Made {
    pub picture: Picture,
    pub layers: Vec<LayerPicture>,
    pub attributes: Vec<(String, Attribute)>,
}

impl Made {
    pub fn of(built: &BuiltScene, rendered: &Rendered) -> Self {
        let layers = rendered.frame.layers().into_iter().map(LayerPicture::as_in_files).collect();
        Self { picture: rendered.frame.picture(), layers, attributes: header::attributes(&Facts::of(built), rendered) }
    }
}

/// Writes colours and layers as EXR.
pub(super) fn write_exr(
    to: &mut Writer,
    picture: &Picture,
    layers: &[LayerPicture],
    attributes: &[(String, Attribute)],
) -> Result<()> {
    match layers.is_empty() {
        true => picture.write_exr(to, attributes),
        false => picture.clone().with_layers(layers).write_exr(to, attributes),
    }
}
