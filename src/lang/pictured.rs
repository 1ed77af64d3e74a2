//! Meshes that have no texture coordinates, under a picture that needs them.

use crate::lang::description::{Entity, SceneDescription, ShapeEntity};
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::WorldGeometry;
use bhs_core::value::{Param, ParamType, Values};
use std::collections::HashMap;

/// Which materials and area lights of a scene show a picture, and the meshes that lack what it takes.
pub(super) struct Pictured {
    materials: Vec<bool>,
    area_lights: Vec<bool>,
    /// The first mesh without texture coordinates under one of them, and how many there are.
    first: Option<Span>,
    count: usize,
}

/// What is known of things by name: `None` while it is being found out.
type Known<'s> = HashMap<&'s str, Option<bool>>;

/// The texts of a parameter.
fn texts(param: &Param) -> impl Iterator<Item = &str> {
    let texts = if let Values::Strings(texts) = &param.values { texts.as_slice() } else { &[] };
    texts.iter().map(|text| text.value.as_str())
}

/// Finds the pictures behind the names of a scene.
struct Finder<'s> {
    textures: HashMap<&'s str, Vec<&'s Entity>>,
    materials: HashMap<&'s str, &'s Entity>,
    known_textures: Known<'s>,
    known_materials: Known<'s>,
}

impl<'s> Finder<'s> {
    fn texture(&mut self, name: &'s str) -> bool {
        if let Some(known) = self.known_textures.get(name) {
            return known.unwrap_or(false);
        }
        self.known_textures.insert(name, None);
        let of_name = self.textures.get(name).cloned().unwrap_or_default();
        let found = of_name.into_iter().any(|texture| texture.name.value == "imagemap" || self.uses(texture));
        self.known_textures.insert(name, Some(found));
        found
    }

    fn material(&mut self, name: &'s str) -> bool {
        if let Some(known) = self.known_materials.get(name) {
            return known.unwrap_or(false);
        }
        self.known_materials.insert(name, None);
        let found = self.materials.get(name).copied().is_some_and(|material| self.uses(material));
        self.known_materials.insert(name, Some(found));
        found
    }

    /// Whether any part of a thing is a picture.
    fn uses(&mut self, entity: &'s Entity) -> bool {
        entity.params.iter().any(|param| match param.ty.value {
            ParamType::Texture => texts(param).any(|name| self.texture(name)),
            ParamType::String if param.name.value == "materials" => texts(param).any(|name| self.material(name)),
            _ => false,
        })
    }
}

impl Pictured {
    pub fn new(scene: &SceneDescription) -> Self {
        let mut textures: HashMap<&str, Vec<&Entity>> = HashMap::new();
        scene.textures.iter().for_each(|t| textures.entry(&t.name.value).or_default().push(&t.entity));
        let named = scene.materials.iter().filter_map(|m| Some((m.name.as_ref()?.value.as_str(), &m.entity)));
        let has_pictures = scene.textures.iter().any(|t| t.entity.name.value == "imagemap");
        let mut finder =
            Finder { textures, materials: named.collect(), known_textures: Known::new(), known_materials: Known::new() };
        let shows_file = |e: &Entity| e.params.iter().any(|p| p.name.value == "filename");
        Self {
            materials: scene.materials.iter().map(|m| has_pictures && finder.uses(&m.entity)).collect(),
            area_lights: scene.area_lights.iter().map(|l| shows_file(&l.entity) || finder.uses(&l.entity)).collect(),
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
