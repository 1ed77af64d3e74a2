//! What shapes are called when something is said of them: their plugins, places in the text and materials.

use crate::lang::description::SceneDescription;
use crate::lang::{BuiltScene, Overrides, SourceMap, build, resolve};
use crate::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Span};
use std::path::Path;

/// The names of a scene's shapes and lights.
pub struct Labels {
    /// By number of the `Shape` directive.
    shapes: Vec<ShapeLabel>,
    /// The lights that are no surfaces: name of the plugin, and where it stands.
    lights: Vec<(String, Span)>,
}

/// What a shape is called.
struct ShapeLabel {
    plugin: String,
    span: Span,
    material: String,
}

/// A thing of a scene by name and place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Name of the plugin.
    pub plugin: String,
    /// File, line and column, as messages write them.
    pub place: String,
    /// The material's own name if it has one, else that of its plugin; of a shape.
    pub material: Option<String>,
}

impl Labels {
    fn of(scene: &SceneDescription) -> Self {
        let material = |index: Option<usize>| {
            let entity = index.and_then(|i| scene.materials.get(i));
            entity.map_or("diffuse", |m| m.name.as_ref().map_or(&m.entity.name.value, |n| &n.value)).to_owned()
        };
        let shapes = scene.shapes.iter().map(|s| ShapeLabel {
            plugin: s.entity.name.value.clone(),
            span: s.entity.name.span,
            material: material(s.material),
        });
        let lights = scene.lights.iter().map(|l| (l.name.value.clone(), l.name.span));
        Self { shapes: shapes.collect(), lights: lights.collect() }
    }

    /// The plugins of the `Shape` directives, in their order.
    pub fn shape_plugins(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().map(|shape| shape.plugin.as_str())
    }

    /// The shape of the `Shape` directive number `index`, counted from 0.
    pub fn shape(&self, index: u32, sources: &SourceMap) -> Option<Label> {
        let ShapeLabel { plugin, span, material } = self.shapes.get(index as usize)?;
        Some(Label { plugin: plugin.clone(), place: place(*span, sources), material: Some(material.clone()) })
    }

    /// The light number `index` of those that are no surfaces.
    pub fn light(&self, index: u32, sources: &SourceMap) -> Option<Label> {
        let (plugin, span) = self.lights.get(index as usize)?;
        Some(Label { plugin: plugin.clone(), place: place(*span, sources), material: None })
    }
}

fn place(span: Span, sources: &SourceMap) -> String {
    if let Some(source) = sources.get(span.file).filter(|s| s.is_model) {
        return source.name.clone();
    }
    let (line, column) = sources.line_column(span.file, span.start);
    format!("{}:{line}:{column}", sources.get(span.file).map_or("", |s| &s.name))
}

/// Opens, reads and builds the scene `path` as [`crate::lang::load`] does, and keeps what its shapes are called.
///
/// # Errors
/// As [`crate::lang::load`].
pub fn load_labelled(
    path: impl AsRef<Path>,
    registry: &Registry,
    overrides: &Overrides,
    sources: &mut SourceMap,
) -> Result<(BuiltScene, Labels), Vec<Diagnostic>> {
    let file = sources.open(path).map_err(|d| vec![*d])?;
    let (description, found) = resolve::resolve_with(sources, file, &overrides.variables);
    let labels = Labels::of(&description);
    Ok((build(description, found, registry, overrides, sources)?, labels))
}
