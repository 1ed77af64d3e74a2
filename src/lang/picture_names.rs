//! What the pictures of a scene are made from by name, without building it.

use crate::lang::resolve::resolve_with;
use crate::lang::source::SourceMap;
use crate::lang::variables::Variables;
use bhs_core::value::Values;
use std::path::Path;

/// The film's `filename`, empty if there is none, and the names of the cameras, of which there is one at least. `None` if the scene cannot be
/// read.
pub fn picture_names(scene: &Path, given: &Variables, sources: &mut SourceMap) -> Option<(String, Vec<Option<String>>)> {
    let file = sources.open(scene).ok()?;
    let (description, found) = resolve_with(sources, file, given);
    if crate::lang::has_errors(&found) {
        return None;
    }
    let params = description.film.as_ref().map(|film| &film.params[..]).unwrap_or_default();
    let filename = match params.iter().find(|p| p.name.value == "filename").map(|p| &p.values) {
        Some(Values::Strings(names)) => names.first().map(|name| name.value.clone()),
        _ => None,
    };
    let mut cameras: Vec<_> = description.cameras.iter().map(|c| c.name.as_ref().map(|name| name.value.clone())).collect();
    if cameras.is_empty() {
        cameras.push(None);
    }
    Some((filename.unwrap_or_default(), cameras))
}
