//! What the pictures of a scene are made from by name, and what it reads, without building it.

use crate::lang::description::{Entity, SceneDescription};
use crate::lang::resolve::resolve_with;
use crate::lang::source::SourceMap;
use crate::lang::variables::Variables;
use bhs_core::value::{Param, Values};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What a scene says of the files that it reads and that are made of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureNames {
    /// The film's `filename`, empty if there is none.
    pub filename: String,
    /// The film's layers.
    pub layers: Vec<String>,
    /// The names of the cameras, of which there is one at least.
    pub cameras: Vec<Option<String>>,
    /// Its texts, and whatever else it names that may be a file.
    pub reads: BTreeSet<PathBuf>,
}

/// The names of a scene. `None` if it cannot be read.
pub fn picture_names(scene: &Path, given: &Variables, sources: &mut SourceMap) -> Option<PictureNames> {
    let file = sources.open(scene).ok()?;
    let (description, found) = resolve_with(sources, file, given);
    if crate::lang::has_errors(&found) {
        return None;
    }
    let of_film = |name: &str| {
        let params = description.film.as_ref().map(|film| &film.params[..]).unwrap_or_default();
        params.iter().find(|p| p.name.value == name).into_iter().flat_map(strings).map(|(text, _)| text.to_owned())
    };
    let mut cameras: Vec<_> = description.cameras.iter().map(|c| c.name.as_ref().map(|name| name.value.clone())).collect();
    if cameras.is_empty() {
        cameras.push(None);
    }
    let mut reads: BTreeSet<PathBuf> = sources.stamps().into_iter().map(|(path, _)| path).collect();
    // What has no ending is called neither as pictures are nor as their checkpoints.
    let named = params(&description).flat_map(strings).filter(|(text, _)| text.contains('.'));
    reads.extend(named.map(|(text, span)| sources.locate(text, span)));
    Some(PictureNames {
        filename: of_film("filename").next().unwrap_or_default(),
        layers: of_film("layers").collect(),
        cameras,
        reads,
    })
}

/// The texts of a parameter, and where they stand.
fn strings(param: &Param) -> impl Iterator<Item = (&str, bhs_core::diagnostics::Span)> {
    let texts = if let Values::Strings(texts) = &param.values { texts.as_slice() } else { &[] };
    texts.iter().map(|text| (text.value.as_str(), text.span))
}

/// All parameters of a scene by which it may read files: those of the film name what is written.
fn params(scene: &SceneDescription) -> impl Iterator<Item = &Param> {
    let single = [&scene.integrator, &scene.transport, &scene.sampler, &scene.filter, &scene.spacetime];
    let entities = single
        .into_iter()
        .flatten()
        .chain(scene.cameras.iter().map(|c| &c.entity))
        .chain(scene.textures.iter().map(|t| &t.entity))
        .chain(scene.materials.iter().map(|m| &m.entity))
        .chain(scene.area_lights.iter().map(|l| &l.entity))
        .chain(&scene.lights)
        .chain(scene.shapes.iter().map(|s| &s.entity));
    entities.flat_map(|entity: &Entity| &entity.params).chain(&scene.options).chain(scene.attributes.iter().map(|a| &a.param))
}
