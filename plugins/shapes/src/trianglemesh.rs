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

use crate::mesh::{to_world, unit};
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

    let triangles = triangles(p, indices, count);
    let one_a_vertex = |name: &str, n: usize| {
        if n != count {
            p.reject(name, format!("`{name}` does not match `P`"), format!("{n} for {count} vertices: one each is needed"));
        }
        n == count
    };
    let normals_fit = normals.as_ref().is_none_or(|n| one_a_vertex("N", n.len()));
    let uvs_fit = uvs.as_ref().is_none_or(|uv| one_a_vertex("uv", uv.len()));
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
    };
    Some(Box::new(to_world(p, mesh)?))
}

/// The triangles by vertex number; `None` after a report of what is wrong with them.
fn triangles(p: &Params, indices: Option<Vec<i64>>, vertices: usize) -> Option<Vec<[u32; 3]>> {
    let Some(indices) = indices else {
        if vertices != 3 {
            let message = format!("`indices` can be left out with exactly 3 vertices only, not with {vertices}");
            p.reject("P", message, "which of these make a triangle?");
            return None;
        }
        return Some(vec![[0, 1, 2]]);
    };
    if indices.is_empty() || indices.len() % 3 != 0 {
        let cause = format!("found {}: each triangle takes 3", indices.len());
        p.reject("indices", "the number of `indices` is not a multiple of 3", cause);
        return None;
    }
    let limit = vertices.min(u32::MAX as usize) as i64;
    if let Some((i, v)) = indices.iter().enumerate().find(|(_, v)| !(0..limit).contains(*v)) {
        let message = format!("vertex index {v} of triangle {} is out of range", i / 3);
        p.reject("indices", message, format!("there are {vertices} vertices, counted from 0"));
        return None;
    }
    Some(indices.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect())
}
