//! Shapes: what there is to be seen. One file, one plugin; `ply*.rs`, `mesh.rs` and `ellipsoid.rs` are helpers.

use bhs_core::geometry::Shape;
use bhs_core::plugin::Plugin;

mod ellipsoid;
mod mesh;
pub mod ply;
mod ply_body;
mod ply_header;
mod ply_input;
mod plymesh;
mod sphere;
mod trianglemesh;

/// All shapes, in alphabetical order.
pub const ALL: &[Plugin<dyn Shape>] = &[plymesh::PLUGIN, sphere::PLUGIN, trianglemesh::PLUGIN];

#[cfg(test)]
bhs_core::every_file_is_listed!([ALL], helpers: ["ellipsoid", "mesh", "ply", "ply_body", "ply_header", "ply_input"]);
