//! Shapes: what there is to be seen. One file, one plugin; `ply*.rs`, `obj.rs`, `mtl.rs`, `obj_lines.rs`, `stl.rs`, `mesh.rs`, `polygon.rs`, `patch.rs`, `affine.rs`, `cone.rs` and
//! `ellipsoid.rs` are helpers.

use bhs_core::geometry::Shape;
use bhs_core::plugin::Plugin;

mod affine;
mod bilinearmesh;
mod cone;
mod curve;
mod cylinder;
mod disk;
mod ellipsoid;
mod file_kind;
mod gltf;
mod loopsubdiv;
mod mesh;
pub mod mtl;
pub mod obj;
mod obj_lines;
mod objmesh;
mod patch;
pub mod ply;
mod ply_body;
mod ply_header;
mod ply_input;
mod plymesh;
mod polygon;
mod sphere;
pub mod stl;
mod stlmesh;
mod trianglemesh;

/// All shapes, in alphabetical order.
pub const ALL: &[Plugin<dyn Shape>] = &[
    bilinearmesh::PLUGIN,
    curve::PLUGIN,
    cylinder::PLUGIN,
    disk::PLUGIN,
    gltf::PLUGIN,
    loopsubdiv::PLUGIN,
    objmesh::PLUGIN,
    plymesh::PLUGIN,
    sphere::PLUGIN,
    stlmesh::PLUGIN,
    trianglemesh::PLUGIN,
];

#[cfg(test)]
bhs_core::every_file_is_listed!([ALL], helpers: ["affine", "cone", "ellipsoid", "file_kind", "mesh", "mtl", "obj", "obj_lines", "patch", "ply", "ply_body", "ply_header", "ply_input", "polygon", "stl"]);
