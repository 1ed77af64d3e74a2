//! A film by itself, without a scene.

use crate::lang::resolve::resolve;
use crate::lang::source::SourceMap;
use crate::registry::{Registry, bare_context};
use bhs_core::camera::Film;
use bhs_engine::layer::NamedLayer;

/// The film that a directive makes, and its layers; `None` if it makes none. Whatever else `text` holds is not made.
pub fn film_alone(text: &str, registry: &Registry, sources: &mut SourceMap) -> Option<(Box<dyn Film>, Vec<NamedLayer>)> {
    let file = sources.add("a film", text);
    let entity = resolve(sources, file).0.film?;
    let mut found = Vec::new();
    let (film, layers) = registry.create_film(&entity, bare_context(sources, registry.spectra()), &mut found);
    film.filter(|_| !crate::lang::has_errors(&found)).map(|film| (film, layers))
}
