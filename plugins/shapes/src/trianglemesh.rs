//! `trianglemesh`: triangles whose vertices stand in the scene.
//!
//! A triangle's outer side is the one from which its corners are seen in counter-clockwise order (in the right-handed sense:
//! along the normal `(p1-p0) x (p2-p0)`); where vertex normals `N` are given, they decide. `ReverseOrientation` turns both.
//!
//! | parameter | type | default | meaning |
//! |---|---|---|---|
//! | `P` | point3 | required | vertex positions |
//! | `indices` | integer | 0 1 2 | three vertex numbers a triangle, from 0; may be left out with exactly three vertices |
//! | `N` | normal | none | shading normals, one a vertex |
//! | `uv` | point2 | none | texture coordinates, one pair a vertex; without them (0,0) (1,0) (1,1) in every triangle |
//!
//! ```bhs
//! WorldBegin
//! Shape "trianglemesh" "point3 P" [ -1 0 -1   1 0 -1   1 0 1   -1 0 1 ]
//!     "integer indices" [ 0 1 2   0 2 3 ]
//! ```

use crate::mesh::{checked_indices, one_a_vertex, to_world, unit};
use bhs_core::geometry::{Shape, WorldMesh};
use bhs_core::params::{Normal3, Params, Point2, Point3};
use bhs_core::plugin::Plugin;

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> =
    Plugin { name: "trianglemesh", summary: "triangles whose vertices stand in the scene", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let positions = p.require::<Vec<Point3>>("P", "", "vertex positions");
    let indices = p.optional::<Vec<i64>>("indices", "", "three vertex numbers a triangle, from 0");
    let normals = p.optional::<Vec<Normal3>>("N", "", "shading normals, one a vertex");
    let uvs = p.optional::<Vec<Point2>>("uv", "", "texture coordinates, one pair a vertex");
    let positions = positions?;
    let count = positions.len();

    let triangles = checked_indices::<3>(p, indices, count, "triangle");
    let normals_fit = normals.as_ref().is_none_or(|n| one_a_vertex(p, "N", n.len(), count));
    let uvs_fit = uvs.as_ref().is_none_or(|uv| one_a_vertex(p, "uv", uv.len(), count));
    let finite = uvs.iter().flatten().all(|uv| uv.0.as_vec2().is_finite());
    if !finite {
        p.reject("uv", "`uv` is too large", "more than single precision can hold");
    }
    let triangles = triangles?;
    if !(finite && normals_fit && uvs_fit) {
        return None;
    }
    let mesh = WorldMesh {
        positions: positions.into_iter().map(|p| p.0).collect(),
        triangles,
        normals: normals.into_iter().flatten().map(|n| unit(n.0)).collect(),
        uvs: uvs.into_iter().flatten().map(|uv| uv.0.as_vec2().to_array()).collect(),
        ..WorldMesh::default()
    };
    Some(Box::new(to_world(p, mesh)?))
}
