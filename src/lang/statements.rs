//! Where the parts of a scene stand in its text: kept with the built scene, for who has something to say of them when the text is gone.

use crate::lang::description::{CameraEntity, Entity, LookAt, SceneDescription};
use crate::lang::overrides::Settings;
use crate::lang::source::SourceMap;
use bhs_core::diagnostics::Span;
use bhs_core::value::{Param, Values};
use std::collections::HashMap;

/// A place in the text, with its line and column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextPlace {
    /// The bytes.
    pub span: Span,
    line: u32,
    column: u32,
}

/// A directive that makes a plugin.
#[derive(Clone, Debug)]
pub struct Statement {
    /// Name of the plugin.
    pub plugin: String,
    /// Where that stands.
    pub at: TextPlace,
    /// Its parameters: name, place of the values, and the first number if there is one.
    params: Vec<(String, TextPlace, Option<f64>)>,
}

impl Statement {
    /// Where the values of a parameter stand, if the directive states it.
    pub fn param(&self, name: &str) -> Option<TextPlace> {
        self.params.iter().find(|p| p.0 == name).map(|p| p.1)
    }

    /// The first number of a parameter, if the directive states it.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.params.iter().find(|p| p.0 == name).and_then(|p| p.2)
    }
}

/// A camera, and what turns it.
#[derive(Clone, Debug)]
pub struct CameraStatement {
    /// The directive.
    pub camera: Statement,
    /// The place of the numbers of its `LookAt`, and the target (world space).
    pub look_at: Option<(TextPlace, LookAt)>,
}

/// A `Shape`, of which there may be very many.
#[derive(Clone, Copy, Debug)]
struct ShapeStatement {
    at: TextPlace,
    /// Index in [`Statements::shape_plugins`].
    plugin: u16,
    area_light: Option<u32>,
}

/// The directives of a scene that something may be said of.
#[derive(Clone, Debug)]
pub struct Statements {
    /// The texts.
    files: Vec<String>,
    /// The cameras in their order.
    pub cameras: Vec<CameraStatement>,
    /// The film.
    pub film: Statement,
    /// The light transport.
    pub transport: Statement,
    /// What light moves through, if the scene says.
    pub spacetime: Option<Statement>,
    /// The lights that are no surfaces, in their order.
    pub lights: Vec<Statement>,
    area_lights: Vec<Statement>,
    shapes: Vec<ShapeStatement>,
    shape_plugins: Vec<String>,
}

impl Statements {
    pub(super) fn of(scene: &SceneDescription, settings: &Settings, sources: &SourceMap) -> Self {
        let place = |span: Span| {
            let (line, column) = sources.line_column(span.file, span.start);
            TextPlace { span, line: line as u32, column: column as u32 }
        };
        let param = |p: &Param| {
            let number = match &p.values {
                Values::Numbers { values, .. } => values.first().copied(),
                _ => None,
            };
            (p.name.value.clone(), place(p.span), number)
        };
        let statement = |e: &Entity| Statement {
            plugin: e.name.value.clone(),
            at: place(e.name.span),
            params: e.params.iter().map(param).collect(),
        };
        let camera = |c: &CameraEntity| CameraStatement {
            camera: statement(&c.entity),
            look_at: c.look_at.map(|look_at| (place(look_at.span), look_at)),
        };
        let (mut shape_plugins, mut numbers) = (Vec::new(), HashMap::new());
        let shapes = scene.shapes.iter().map(|s| {
            let name = s.entity.name.value.as_str();
            let plugin = *numbers.entry(name).or_insert_with(|| {
                shape_plugins.push(name.to_owned());
                (shape_plugins.len() - 1).min(usize::from(u16::MAX)) as u16
            });
            ShapeStatement { at: place(s.entity.name.span), plugin, area_light: s.area_light.map(|l| l as u32) }
        });
        let shapes = shapes.collect();
        Self {
            files: sources.iter().map(|s| s.name.clone()).collect(),
            cameras: settings.cameras.iter().map(camera).collect(),
            film: statement(&settings.film),
            transport: statement(&settings.transport),
            spacetime: scene.spacetime.as_ref().map(statement),
            lights: scene.lights.iter().map(statement).collect(),
            area_lights: scene.area_lights.iter().map(|l| statement(&l.entity)).collect(),
            shapes,
            shape_plugins,
        }
    }

    /// File, line and column as messages write them; `None` of what is not in the scene's text but by default.
    pub fn place(&self, at: TextPlace) -> Option<String> {
        let file = self.files.get(usize::from(at.span.file)).filter(|name| *name != "<defaults>")?;
        Some(format!("{file}:{}:{}", at.line, at.column))
    }

    /// Plugin and place of the `Shape` directive number `index`, counted from 0.
    pub fn shape(&self, index: u32) -> Option<(&str, TextPlace)> {
        let shape = self.shapes.get(index as usize)?;
        Some((self.shape_plugins.get(usize::from(shape.plugin))?, shape.at))
    }

    /// The places of all `Shape` directives, in their order.
    pub fn shape_places(&self) -> Vec<String> {
        self.shapes.iter().map(|shape| self.place(shape.at).unwrap_or_default()).collect()
    }

    /// What makes the shape number `index` emit, if something does.
    pub fn area_light(&self, index: u32) -> Option<&Statement> {
        self.area_lights.get(self.shapes.get(index as usize)?.area_light? as usize)
    }
}
