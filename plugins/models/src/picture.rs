//! The pictures of a file.

use crate::model::{Model, ReadFile, data, decoded_path};
use bhs_core::image::Image;
use std::sync::Arc;

/// Where a picture is.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// In the file itself, or in a buffer of it.
    Within,
    /// In a file of this path.
    File(String),
}

/// Where picture number `index` is; `None` if there is none.
pub fn place(model: &Model, index: usize) -> Option<Place> {
    let image = model.document.as_json().images.get(index)?;
    match &image.uri {
        Some(uri) if image.buffer_view.is_none() && data(uri).is_none() => Some(Place::File(decoded_path(uri))),
        _ => Some(Place::Within),
    }
}

/// The bytes of picture number `index`, as of a file of its own.
///
/// # Errors
/// What is wrong with it, in words that can follow "cannot read `file`: ".
pub fn bytes(model: &Model, index: usize, read: ReadFile) -> Result<Vec<u8>, String> {
    let images = &model.document.as_json().images;
    let Some(image) = images.get(index) else {
        return Err(format!("it has no picture {index}: it has {}, counted from 0", images.len()));
    };
    match (&image.buffer_view, &image.uri) {
        (Some(view), _) => {
            let view = model.document.views().nth(view.value()).ok_or("its picture names a buffer view that it does not have")?;
            let (bytes, range) = model.view(&view, read)?;
            Ok(bytes[range].to_vec())
        }
        (None, Some(uri)) => match data(uri) {
            Some(bytes) => bytes,
            None => read(&decoded_path(uri)).map(|bytes| bytes.to_vec()),
        },
        (None, None) => Err(format!("its picture {index} has no content")),
    }
}

/// Picture number `index`, made once of its bytes by `decode`.
///
/// # Errors
/// As [`bytes`], and what `decode` finds.
pub fn decoded(
    model: &Model,
    index: usize,
    read: ReadFile,
    decode: impl FnOnce(&[u8]) -> Result<Image, String>,
) -> Result<Arc<Image>, String> {
    let make = || {
        let made = decode(&bytes(model, index, read)?);
        made.map(Arc::new).map_err(|why| format!("its picture {index} cannot be read: {why}"))
    };
    match model.pictures.get(index) {
        Some(slot) => slot.get_or_init(make).clone(),
        None => make(),
    }
}
