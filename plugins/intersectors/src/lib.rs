//! Acceleration structures over the geometry of a scene: what finds the first surface along a straight segment.
//!
//! [`embree`] is the fast one and the only file of the project with `unsafe` code; [`reference`](mod@reference) is the
//! oracle of its tests. Without the feature `embree` (on by default) the latter is all there is.

use bhs_core::Plugin;
use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;

#[cfg(feature = "embree")]
pub mod embree;
pub mod reference;
#[cfg(feature = "embree")]
mod single;

/// All intersectors; the first is the default.
pub const ALL: &[Plugin<dyn IntersectorBuilder>] = &[
    #[cfg(feature = "embree")]
    embree::PLUGIN,
    reference::PLUGIN,
];

/// Whether all triangles name vertices that exist: what comes after reads memory by these numbers.
fn check(geometries: &[Geometry]) -> Result<(), String> {
    for (number, geometry) in geometries.iter().enumerate() {
        let Geometry::Mesh(mesh) = geometry else { continue };
        let vertices = mesh.positions.len();
        if u32::try_from(mesh.triangles.len()).is_err() || u32::try_from(vertices).is_err() {
            return Err(format!("mesh {number} has more than 2^32 vertices or triangles"));
        }
        if let Some(vertex) = mesh.triangles.iter().flatten().find(|vertex| **vertex as usize >= vertices) {
            return Err(format!("mesh {number} uses vertex {vertex}, but has only {vertices}"));
        }
    }
    Ok(())
}

#[cfg(all(test, feature = "embree"))]
bhs_core::every_file_is_listed!([ALL], helpers: ["single"]);
