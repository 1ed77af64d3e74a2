//! Objects and where they stand: from their shapes to geometry that is kept once.

use crate::lang::description::{Entity, InstanceEntity, ShapeEntity};
use crate::lang::parts::{LoadCounters, MeshPart, ObjectPart, Part};
use bhs_core::diagnostics::{Diagnostic, Severity, Span};
use bhs_core::geometry::instance::{Instance, Object};
use bhs_core::geometry::{Aabb, Geometry, Shape, WorldGeometry};
use bhs_core::spacetime::Side;
use bhs_elementary::Elementary;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The objects without their shapes.
pub(super) fn places(count: usize, instances: &[InstanceEntity]) -> Vec<ObjectPart> {
    let mut objects: Vec<ObjectPart> = std::iter::repeat_with(ObjectPart::default).take(count).collect();
    for instance in instances {
        if let Some(object) = instance.object.and_then(|o| objects.get_mut(o)) {
            object.places.push((instance.name.span, instance.world_from_object, instance.side));
        }
    }
    objects
}

/// Adds a shape to its object, of which `made` is the geometry. Meshes are kept once; surfaces given by a formula, which take no room, are made
/// anew for every place by `make`, and returned.
pub(super) fn add_shape(
    object: &mut ObjectPart,
    shape: &ShapeEntity,
    index: u32,
    made: Vec<WorldGeometry>,
    make: impl Fn(&Entity, &mut Vec<Diagnostic>) -> Option<Box<dyn Shape>>,
    found: &mut Vec<Diagnostic>,
) -> Vec<Part> {
    let span = shape.entity.name.span;
    let mut parts = Vec::new();
    let mut formulas = false;
    for surface in made {
        match surface {
            WorldGeometry::Mesh(mesh) => {
                object.meshes.push(mesh);
                object.parts.push(MeshPart { span, index, material: shape.material });
            }
            WorldGeometry::Analytic(_) => formulas = true,
        }
    }
    if !formulas {
        return parts;
    }
    for (_, place, side) in &object.places {
        let mut said = Vec::new();
        let mut entity = shape.entity.clone();
        entity.world_from_object = Arc::new(*place * *entity.world_from_object);
        let Some(made) = make(&entity, &mut said) else {
            // Nothing was wrong with it where it was defined. What is wrong at one place may be so at many.
            found.extend(said.into_iter().filter(|d| d.severity == Severity::Error));
            break;
        };
        let surfaces = made.into_geometry().into_iter().filter(|g| matches!(g, WorldGeometry::Analytic(_)));
        parts.extend(surfaces.map(|geometry| Part {
            geometry,
            side: *side,
            span,
            index,
            material: shape.material,
            area_light: None,
            motion: None,
        }));
    }
    parts
}

/// Largest coordinate, as for all shapes.
const LARGEST: f64 = 1e15;

/// An object and its instances in world space.
pub(super) struct Placed {
    object: Arc<Object>,
    parts: Vec<MeshPart>,
    places: Vec<(Span, DAffine3, Side)>,
    bounds: Aabb,
}

impl Placed {
    /// `None` if there is nothing of it in the scene.
    pub(super) fn new(part: ObjectPart, load: &mut LoadCounters, found: &mut Vec<Diagnostic>) -> Option<Self> {
        load.shapes += part.parts.len() as u64;
        load.instances += part.places.len() as u64;
        let (_, first, _) = part.places.first()?;
        if part.meshes.is_empty() {
            return None;
        }
        let object = Arc::new(Object::new(part.meshes, first.matrix3.determinant().abs().cube_root()));
        load.zero_area_triangles += object.dropped_triangles() as u64;
        for (mesh, made) in object.meshes().iter().zip(&part.parts) {
            load.triangles += mesh.triangles.len() as u64;
            if mesh.triangles.is_empty() {
                let message = "this shape has no surface: it has no triangle with an area";
                found.push(Diagnostic::warning("empty-shape", message).at(made.span, ""));
            }
            if !mesh.positions.iter().flatten().all(|x| f64::from(*x).abs() <= LARGEST) {
                found.push(too_far(made.span));
            }
        }
        let mut placed = Self { object, parts: part.parts, places: part.places, bounds: Aabb::EMPTY };
        for (span, place, _) in &placed.places {
            let fits = |b: &Aabb| b.is_empty() || b.min.abs().max(b.max.abs()).cmple(DVec3::splat(LARGEST)).all();
            match placed.object.place(*place, DVec3::ZERO) {
                Some(instances) if instances.iter().all(|i| fits(&i.bounds())) => {
                    placed.bounds = instances.iter().fold(placed.bounds, |b, i| b.union(i.bounds()));
                }
                Some(_) => found.push(too_far(*span)),
                None => found.push(
                    Diagnostic::error("bad-transform", "the transform of this instance is out of range")
                        .at(*span, "single precision cannot take the object there")
                        .help("instances of one object may differ in size by a factor of about 1e12"),
                ),
            }
        }
        Some(placed)
    }

    /// The sides on which it stands, with the places of the names in the text.
    pub(super) fn sides(&self) -> impl Iterator<Item = (Side, Span)> {
        self.places.iter().map(|(span, _, side)| (*side, *span))
    }

    /// A box around all of its instances, world space.
    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Its instances on a side in render space, mesh after mesh, with what they are made of.
    pub(super) fn geometries(&self, origin: DVec3, side: Side) -> impl Iterator<Item = (Geometry, &MeshPart)> {
        let places = self.places.iter().filter(move |(.., on)| *on == side);
        let instances = places.flat_map(move |(_, place, _)| self.object.place(*place, origin).unwrap_or_default());
        instances.map(|i: Instance| {
            let part = &self.parts[i.part() as usize];
            (Geometry::Instance(i), part)
        })
    }
}

fn too_far(span: Span) -> Diagnostic {
    Diagnostic::error("out-of-range", "this shape reaches too far out")
        .at(span, format!("coordinates are at most {LARGEST:e}"))
        .help("use a smaller scale for the whole scene")
}
