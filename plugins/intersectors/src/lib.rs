//! Acceleration structures over the geometry of a scene: what finds the first surface along a straight segment.
//!
//! [`embree`] is the fast one and the only file of the project with `unsafe` code; [`reference`](mod@reference) is the
//! oracle of its tests. Without the feature `embree` (on by default) the latter is all there is.

use bhs_core::Plugin;
use bhs_core::geometry::instance::{Instance, Object};
use bhs_core::geometry::{Geometry, TriangleMesh};
use bhs_core::intersector::IntersectorBuilder;
use std::collections::HashSet;
use std::sync::Arc;

#[cfg(feature = "embree")]
mod cells;
#[cfg(feature = "embree")]
mod contacts;
#[cfg(feature = "embree")]
mod crowds;
#[cfg(feature = "embree")]
pub mod embree;
mod exact;
#[cfg(feature = "embree")]
mod query;
pub mod reference;
#[cfg(feature = "embree")]
mod single;
mod tree;
#[cfg(feature = "embree")]
mod zone;

/// All intersectors; the first is the default.
pub const ALL: &[Plugin<dyn IntersectorBuilder>] = &[
    #[cfg(feature = "embree")]
    embree::PLUGIN,
    reference::PLUGIN,
];

/// Whether all triangles name vertices that exist, and the meshes of an instance follow one another: what comes after reads memory
/// by these numbers.
fn check(geometries: &[Geometry]) -> Result<(), String> {
    let mut before = None;
    for (number, geometry) in geometries.iter().enumerate() {
        match geometry {
            Geometry::Mesh(mesh) => check_mesh(number, mesh)?,
            Geometry::Analytic(_) => {}
            Geometry::Instance(instance) => {
                let follows = before.is_some_and(|b: &Instance| b.stands_with(instance) && b.part() + 1 == instance.part());
                if instance.part() != 0 && !follows {
                    return Err(format!("geometry {number} does not follow the meshes of its object that come before it"));
                }
                before = Some(instance);
                continue;
            }
        }
        before = None;
    }
    for (number, object) in objects(geometries) {
        object.meshes().iter().try_for_each(|mesh| check_mesh(number, mesh))?;
    }
    Ok(())
}

fn check_mesh(number: usize, mesh: &TriangleMesh) -> Result<(), String> {
    let vertices = mesh.positions.len();
    if u32::try_from(mesh.triangles.len()).is_err() || u32::try_from(vertices).is_err() {
        return Err(format!("mesh {number} has more than 2^32 vertices or triangles"));
    }
    match mesh.triangles.iter().flatten().find(|vertex| **vertex as usize >= vertices) {
        Some(vertex) => Err(format!("mesh {number} uses vertex {vertex}, but has only {vertices}")),
        None => Ok(()),
    }
}

/// The distinct objects, each with the number of the first geometry that is an instance of it.
fn objects(geometries: &[Geometry]) -> Vec<(usize, &Arc<Object>)> {
    let mut seen = HashSet::new();
    let instances = geometries.iter().enumerate().filter_map(|(i, g)| match g {
        Geometry::Instance(instance) => Some((i, instance.object())),
        _ => None,
    });
    instances.filter(|(_, object)| seen.insert(Arc::as_ptr(object))).collect()
}

#[cfg(all(test, feature = "embree"))]
bhs_core::every_file_is_listed!([ALL], helpers: ["cells", "contacts", "crowds", "exact", "query", "single", "tree", "zone"]);
