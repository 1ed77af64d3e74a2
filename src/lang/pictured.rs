//! Meshes that have no texture coordinates, under a picture that needs them.

use crate::lang::description::{Entity, SceneDescription, ShapeEntity};
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::WorldGeometry;
use bhs_core::value::{Param, ParamType, Values};
use std::collections::{HashMap, HashSet};

/// Which materials and area lights of a scene show a picture, and the meshes that lack what it takes.
pub(super) struct Pictured {
    materials: Vec<bool>,
    area_lights: Vec<bool>,
    /// The first mesh without texture coordinates under one of them, and how many there are.
    first: Option<Span>,
    count: usize,
}

/// The texts of a parameter.
fn texts(param: &Param) -> impl Iterator<Item = &str> {
    let texts = if let Values::Strings(texts) = &param.values { texts.as_slice() } else { &[] };
    texts.iter().map(|text| text.value.as_str())
}

/// A kind of things that scenes name, as far as they are made of others.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    Texture,
    Material,
}

/// What a thing is made of, by name.
fn parts(entity: &Entity) -> impl Iterator<Item = (Kind, &str)> {
    entity.params.iter().flat_map(|param| {
        let kind = match param.ty.value {
            ParamType::Texture => Some(Kind::Texture),
            ParamType::String if param.name.value == "materials" => Some(Kind::Material),
            _ => None,
        };
        texts(param).filter_map(move |name| Some((kind?, name)))
    })
}

/// Whether a texture is placed by the texture coordinates of surfaces, as all are that name no other `mapping`.
fn asks_for_coordinates(texture: &Entity) -> bool {
    texture.params.iter().filter(|param| param.name.value == "mapping").flat_map(texts).all(|mapping| mapping == "uv")
}

/// The things that show a picture, by way of as many others as there may be.
struct Showing<'s>(HashSet<(Kind, &'s str)>);

impl<'s> Showing<'s> {
    /// Follows the names from the pictures to those that use them: round in circles or through thousands of things, each is looked at once.
    fn of(scene: &'s SceneDescription) -> Self {
        let textures = scene.textures.iter().map(|t| (Kind::Texture, t.name.value.as_str(), &t.entity));
        let materials = scene.materials.iter().filter_map(|m| Some((Kind::Material, m.name.as_ref()?.value.as_str(), &m.entity)));
        let mut users: HashMap<(Kind, &str), Vec<(Kind, &str)>> = HashMap::new();
        for (kind, name, entity) in textures.chain(materials) {
            parts(entity).for_each(|part| users.entry(part).or_default().push((kind, name)));
        }
        let pictures = scene.textures.iter().filter(|t| t.entity.name.value == "imagemap" && asks_for_coordinates(&t.entity));
        let mut left: Vec<(Kind, &str)> = pictures.map(|t| (Kind::Texture, t.name.value.as_str())).collect();
        let mut showing = HashSet::new();
        while let Some(thing) = left.pop() {
            if showing.insert(thing) {
                left.extend(users.get(&thing).into_iter().flatten());
            }
        }
        Self(showing)
    }

    /// Whether any part of a thing does.
    fn any_of(&self, entity: &'s Entity) -> bool {
        parts(entity).any(|part| self.0.contains(&part))
    }
}

impl Pictured {
    pub fn new(scene: &SceneDescription) -> Self {
        let showing = Showing::of(scene);
        let shows_file = |e: &Entity| e.params.iter().any(|p| matches!(p.name.value.as_str(), "filename" | "normalmap"));
        Self {
            materials: scene.materials.iter().map(|m| shows_file(&m.entity) || showing.any_of(&m.entity)).collect(),
            area_lights: scene.area_lights.iter().map(|l| shows_file(&l.entity) || showing.any_of(&l.entity)).collect(),
            first: None,
            count: 0,
        }
    }

    /// Looks at the surfaces of a shape.
    pub fn look_at(&mut self, shape: &ShapeEntity, surfaces: &[WorldGeometry]) {
        let has = |of: &[bool], index: Option<usize>| index.is_some_and(|index| of.get(index) == Some(&true));
        if !has(&self.materials, shape.material) && !has(&self.area_lights, shape.area_light) {
            return;
        }
        let lacks =
            |surface: &WorldGeometry| matches!(surface, WorldGeometry::Mesh(m) if m.uvs.is_empty() && !m.triangles.is_empty());
        if surfaces.iter().any(lacks) {
            self.first = self.first.or(Some(shape.entity.name.span));
            self.count += 1;
        }
    }

    /// Warns of them, once.
    pub fn report(self, found: &mut Vec<Diagnostic>) {
        let Some(span) = self.first else { return };
        let message = match self.count {
            1 => "this mesh has no texture coordinates, and its picture begins anew on every triangle".to_owned(),
            n => format!("{n} meshes have no texture coordinates, and their pictures begin anew on every triangle"),
        };
        let label = if self.count == 1 { "" } else { "this is the first of them" };
        found.push(
            Diagnostic::warning("no-texture-coordinates", message)
                .at(span, label)
                .help("give it \"point2 uv\", one pair a vertex; PLY files have `u` and `v`, OBJ files `vt`"),
        );
    }
}
