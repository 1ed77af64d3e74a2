//! The plugins of a scene, each made alone, in world space: what is joined to a scene.

use crate::lang::spacetime::Gravity;
use bhs_core::camera::{Camera, Viewpoint};
use bhs_core::diagnostics::Span;
use bhs_core::geometry::{WorldGeometry, WorldMesh};
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::light::{AreaLight, Light};
use bhs_core::material::Material;
use bhs_core::motion::Motion;
use bhs_core::spacetime::Side;
use bhs_engine::integrator::IntegratorBuilder;
use bhs_engine::scene::Footprints;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// All plugins of a scene, in world space. What could not be made has been reported.
pub(super) struct Parts {
    pub integrator: Option<(String, Box<dyn IntegratorBuilder>)>,
    /// With the place of its name.
    pub intersector: Option<(Span, Box<dyn IntersectorBuilder>)>,
    /// At least one.
    pub cameras: Vec<PartCamera>,
    /// What bends light.
    pub gravity: Option<Gravity>,
    pub lambda_range: [f32; 2],
    pub materials: Vec<Option<Arc<dyn Material>>>,
    /// See [`bhs_engine::scene::Scene::wants_patches`].
    pub wants_patches: bool,
    pub default_material: Option<Box<dyn Material>>,
    pub area_lights: Vec<PartAreaLight>,
    pub lights: Vec<PartLight>,
    /// Whether the light transport samples lights.
    pub samples_lights: bool,
    pub shapes: Vec<Part>,
    /// How they move, those that do.
    pub motions: Vec<Box<dyn Motion>>,
    pub objects: Vec<ObjectPart>,
}

/// A camera that has been made.
pub(super) struct PartCamera {
    /// Its own name.
    pub name: Option<String>,
    /// Place of the plugin's name, if the scene has a camera.
    pub span: Option<Span>,
    pub camera: Option<Box<dyn Camera>>,
    pub viewpoint: Viewpoint,
    /// What its `LookAt` makes it look at, world space.
    pub target: Option<DVec3>,
}

/// The emission of surfaces.
pub(super) struct PartAreaLight {
    /// Place of its name.
    pub span: Span,
    pub light: Option<Box<dyn AreaLight>>,
}

/// A light that is no surface.
pub(super) struct PartLight {
    /// Place of its name.
    pub span: Span,
    pub side: Side,
    pub light: Option<Box<dyn Light>>,
}

/// A shape that has been made.
pub(super) struct Part {
    pub geometry: WorldGeometry,
    pub side: Side,
    /// Place of its name.
    pub span: Span,
    /// Number of the directive.
    pub index: u32,
    /// Index of its material; `None` for the default one.
    pub material: Option<usize>,
    /// Index of its area light.
    pub area_light: Option<usize>,
    /// Index of how it moves; `None`: at rest.
    pub motion: Option<usize>,
}

/// An object whose meshes have been made.
#[derive(Default)]
pub(super) struct ObjectPart {
    pub meshes: Vec<WorldMesh>,
    /// What each mesh is made of.
    pub parts: Vec<MeshPart>,
    /// Where it stands, with the place of the name in the text.
    pub places: Vec<(Span, DAffine3, Side)>,
}

/// What a mesh of an object is made of.
pub(super) struct MeshPart {
    /// Place of the shape's name.
    pub span: Span,
    /// Number of the directive.
    pub index: u32,
    /// Index of its material; `None` for the default one.
    pub material: Option<usize>,
}

/// A camera, and what a scene knows of it.
pub(super) struct View {
    pub name: Option<String>,
    pub camera: Box<dyn Camera>,
    pub viewpoint: Viewpoint,
    pub footprints: Footprints,
    /// See [`bhs_engine::scene::Scene::draws_points`].
    pub draws_points: bool,
}

/// What was loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadCounters {
    /// Shapes.
    pub shapes: u64,
    /// Places where objects stand.
    pub instances: u64,
    /// Triangles, those of an object once, the dropped ones not counted.
    pub triangles: u64,
    /// Triangles without area, which were dropped.
    pub zero_area_triangles: u64,
}
