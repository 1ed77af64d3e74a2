//! A scene as plain data: what is to be built, with transforms and attributes resolved and no plugin made yet.

use crate::lang::defaults::{AttributeParam, Defaults};
use crate::lang::variables::GivenVariables;
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::spacetime::Side;
use bhs_core::value::{Param, Values};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// A plugin to be made: its name, its parameters, and the place they come from.
#[derive(Clone, Debug)]
pub struct Entity {
    /// Name of the plugin.
    pub name: Spanned<String>,
    /// Its parameters.
    pub params: Vec<Param>,
    /// Parameters that `Attribute` states for it, where it does not state them itself.
    pub defaults: Defaults,
    /// The whole directive.
    pub span: Span,
    /// The directive's first word.
    pub keyword: Span,
    /// Whether parts of it are missing here, because they were at fault and have been reported.
    pub faulty: bool,
    /// The current transform at the directive: to world space. Of a camera: from camera space. Directives share it.
    pub world_from_object: Arc<DAffine3>,
    /// The side of a wormhole on which a shape or a light is.
    pub side: Side,
}

impl Entity {
    /// It as a directive of a scene, in one line.
    pub fn to_directive(&self, keyword: &str) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        let mut text = format!("{keyword} {}", quoted(&self.name.value));
        for param in &self.params {
            let values: Vec<String> = match &param.values {
                Values::Numbers { values, .. } => values.iter().map(f64::to_string).collect(),
                Values::Strings(strings) => strings.iter().map(|s| quoted(&s.value)).collect(),
                Values::Bools(bools) => bools.iter().map(bool::to_string).collect(),
            };
            text += &format!(" \"{} {}\" [{}]", param.ty.value.word(), param.name.value, values.join(" "));
        }
        text
    }
}

/// A camera, with its name if it has one.
#[derive(Clone, Debug)]
pub struct CameraEntity {
    /// What to make.
    pub entity: Entity,
    /// The name that its parameter `name` gives it.
    pub name: Option<Spanned<String>>,
    /// The `LookAt` that turns it.
    pub look_at: Option<LookAt>,
}

/// Where a `LookAt` stands, and the point that it makes a camera look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// The nine numbers.
    pub span: Span,
    /// The point, world space.
    pub target: DVec3,
}

/// A material, with its name if it has one.
#[derive(Clone, Debug)]
pub struct MaterialEntity {
    /// What to make.
    pub entity: Entity,
    /// The name that `MakeNamedMaterial` gives it.
    pub name: Option<Spanned<String>>,
    /// Whether a shape has it.
    pub used: bool,
}

/// A texture.
#[derive(Clone, Debug)]
pub struct TextureEntity {
    /// What to make.
    pub entity: Entity,
    /// Its name.
    pub name: Spanned<String>,
    /// Whether it is a texture of numbers, not of spectra.
    pub is_float: bool,
}

/// An area light.
#[derive(Clone, Debug)]
pub struct AreaLightEntity {
    /// What to make.
    pub entity: Entity,
    /// Whether a shape has it.
    pub used: bool,
}

/// A shape with what it is made of.
#[derive(Clone, Debug)]
pub struct ShapeEntity {
    /// What to make.
    pub entity: Entity,
    /// Whether `ReverseOrientation` is in force.
    pub reverse_orientation: bool,
    /// Index of its material; `None` for the default one.
    pub material: Option<usize>,
    /// Index of its area light.
    pub area_light: Option<usize>,
    /// Index of the object that it is a part of; `None` for what stands in the scene itself.
    pub object: Option<usize>,
}

/// Shapes that are kept once and stand in many places.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectEntity {
    /// Its name.
    pub name: Spanned<String>,
    /// Whether it stands anywhere.
    pub used: bool,
}

/// A place where an object stands.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceEntity {
    /// Index of the object; `None` if there is none of that name.
    pub object: Option<usize>,
    /// Its name.
    pub name: Spanned<String>,
    /// Takes what was world space where the object was defined to world space.
    pub world_from_object: DAffine3,
    /// The side of a wormhole on which it stands.
    pub side: Side,
}

/// All of a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// How light travels.
    pub integrator: Option<Entity>,
    /// How light is gathered.
    pub transport: Option<Entity>,
    /// The cameras, in the order of the scene.
    pub cameras: Vec<CameraEntity>,
    /// The film.
    pub film: Option<Entity>,
    /// The sampler.
    pub sampler: Option<Entity>,
    /// The pixel filter.
    pub filter: Option<Entity>,
    /// The parameters of all `Option` directives, together.
    pub options: Vec<Param>,
    /// What `Attribute` states, all together.
    pub attributes: Vec<Arc<AttributeParam>>,
    /// What light moves through.
    pub spacetime: Option<Entity>,
    /// Textures in the order of the scene.
    pub textures: Vec<TextureEntity>,
    /// Materials in the order of the scene.
    pub materials: Vec<MaterialEntity>,
    /// Area lights in the order of the scene.
    pub area_lights: Vec<AreaLightEntity>,
    /// Lights that are not surfaces.
    pub lights: Vec<Entity>,
    /// Shapes in the order of the scene, those of objects among them.
    pub shapes: Vec<ShapeEntity>,
    /// Objects in the order of the scene.
    pub objects: Vec<ObjectEntity>,
    /// Where they stand, in the order of the scene.
    pub instances: Vec<InstanceEntity>,
    /// What the scene is given from outside.
    pub variables: GivenVariables,
    /// Whether an included file could not be read, so that what is missing here may be in there.
    pub incomplete: bool,
}
