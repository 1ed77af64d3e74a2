//! The scene language: from text to a scene that can be rendered.
//!
//! 1. [`source`] opens files and remembers where each came from;
//! 2. [`parse`] turns text into directives ([`ast`]) and knows neither directives nor plugins;
//! 3. [`resolve`] runs the directives (includes, transforms, attributes) and yields a [`description::SceneDescription`], plain
//!    data that knows no plugin;
//! 4. [`build`](mod@build) makes the plugins and joins them to a [`build::BuiltScene`].
//!
//! [`format`](mod@format) prints a scene's directives again.
//!
//! Every step yields its result *and* all faults that it found, with their places in the text.

mod assemble;
pub mod ast;
pub mod build;
mod coplanar;
mod create;
pub mod defaults;
pub mod description;
mod emitters;
mod errors;
mod faulty;
mod film;
mod foreign;
pub mod format;
mod frame_check;
mod gltf_scene;
mod instances;
mod labels;
mod lines;
mod method;
mod models;
mod moving;
mod names;
mod options;
pub mod overrides;
mod params;
pub mod parse;
mod parts;
mod pbrt;
mod picture_names;
mod pictured;
pub mod resolve;
mod seed;
mod shapes;
mod sky_points;
pub mod source;
mod spacetime;
mod statements;
mod strands;
#[cfg(test)]
mod tests;
pub mod transform;
pub mod variables;

pub use build::{BuiltScene, build};
pub use description::SceneDescription;
pub use film::film_alone;
pub use format::format;
pub use frame_check::FrameCheck;
pub use labels::{Label, Labels, load_labelled};
pub use method::{Method, load_method};
pub use options::option_params;
pub use overrides::Overrides;
pub use picture_names::{PictureNames, picture_names};
pub use seed::LARGEST_SEED;
pub use source::SourceMap;
pub use statements::{CameraStatement, Statement, Statements, TextPlace};
pub use variables::Variables;

use crate::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Severity};
use std::path::Path;

/// Opens, reads and builds the scene `path` (`-` is standard input).
///
/// # Errors
/// Everything that is wrong with the scene, with warnings between; at least one of them is an error.
pub fn load(
    path: impl AsRef<Path>,
    registry: &Registry,
    overrides: &Overrides,
    sources: &mut SourceMap,
) -> Result<BuiltScene, Vec<Diagnostic>> {
    let file = sources.open(path).map_err(|d| vec![*d])?;
    let (description, found) = resolve::resolve_with(sources, file, &overrides.variables);
    build(description, found, registry, overrides, sources)
}

/// Builds the scene `text`; `name` stands for its file in messages, and relative paths start at the current folder.
///
/// # Errors
/// As [`load`].
pub fn load_text(
    name: &str,
    text: &str,
    registry: &Registry,
    overrides: &Overrides,
    sources: &mut SourceMap,
) -> Result<BuiltScene, Vec<Diagnostic>> {
    let file = sources.add(name, text);
    let (description, found) = resolve::resolve_with(sources, file, &overrides.variables);
    build(description, found, registry, overrides, sources)
}

/// The scene `path` as one text in our own terms, printed neatly, for a file in `folder`; with what is to be said of it.
///
/// # Errors
/// Everything that is wrong with its text and its included files. Plugins are not made.
pub fn convert(
    path: impl AsRef<Path>,
    sources: &mut SourceMap,
    variables: &Variables,
    folder: &Path,
) -> Result<(String, Vec<Diagnostic>), Vec<Diagnostic>> {
    let file = sources.open(path).map_err(|d| vec![*d])?;
    let (_, mut found) = resolve::resolve_with(sources, file, variables);
    if has_errors(&found) {
        return Err(found);
    }
    let text = pbrt::convert(sources, file, variables, folder)?;
    // What it says of variables and of unused things is about the scene, not about its conversion.
    found.retain(|d| d.code == "pbrt");
    Ok((format(&text, sources.add("<converted>", &text))?, found))
}

/// The words of all directives, in alphabetical order.
pub fn keywords() -> impl Iterator<Item = &'static str> {
    resolve::directives::KEYWORDS.iter().copied()
}

/// Whether one of the findings stops the program.
pub fn has_errors(found: &[Diagnostic]) -> bool {
    found.iter().any(|d| d.severity == Severity::Error)
}
