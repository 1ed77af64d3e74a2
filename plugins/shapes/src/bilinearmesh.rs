//! `bilinearmesh`: patches that are spanned by four vertices each, exactly: curved where these do not lie in a plane.
//!
//! A patch has the corners p00, p10, p01, p11, in this order; its points are `(1-u)(1-v) p00 + u(1-v) p10 + (1-u)v p01 + uv p11`. Its outer side is
//! that of `dp/du x dp/dv`, where vertex normals `N` are given that of these; `ReverseOrientation` turns both. Where all patches are
//! parallelograms without `N`, they are two triangles each.
//!
//! | parameter | type | default | meaning |
//! |---|---|---|---|
//! | `P` | point3 | required | vertex positions |
//! | `indices` | integer | 0 1 2 3 | four vertex numbers a patch, from 0; may be left out with exactly four vertices |
//! | `N` | normal | none | shading normals, one a vertex |
//! | `uv` | point2 | none | texture coordinates, one pair a vertex; without them those of the patch, (0,0) to (1,1) |
//!
//! ```bhs
//! WorldBegin
//! Shape "bilinearmesh" "point3 P" [ -1 0 -1   1 0 -1   -1 0 1   1 1 1 ]
//! ```

use crate::mesh::{checked_indices, normal_matrix, one_a_vertex, to_world, unit};
use crate::patch::Patch;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Shape, WorldGeometry, WorldMesh};
use bhs_core::params::{Normal3, Params, Point2, Point3};
use bhs_core::plugin::Plugin;
use glam::{DVec2, DVec3};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "bilinearmesh", summary: "bilinear patches, flat or curved", build };

/// How far a patch may be from a parallelogram to be taken for one, relative to its size.
const FLAT: f64 = 1e-9;

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let positions = p.require::<Vec<Point3>>("P", "", "vertex positions");
    let indices = p.optional::<Vec<i64>>("indices", "", "four vertex numbers a patch, from 0");
    let normals = p.optional::<Vec<Normal3>>("N", "", "shading normals, one a vertex");
    let uvs = p.optional::<Vec<Point2>>("uv", "", "texture coordinates, one pair a vertex");
    let positions: Vec<DVec3> = positions?.into_iter().map(|p| p.0).collect();
    let count = positions.len();
    let patches = checked_indices::<4>(p, indices, count, "patch");
    let normals_fit = normals.as_ref().is_none_or(|n| one_a_vertex(p, "N", n.len(), count));
    let uvs_fit = uvs.as_ref().is_none_or(|uv| one_a_vertex(p, "uv", uv.len(), count));
    let uvs: Vec<DVec2> = uvs.into_iter().flatten().map(|uv| uv.0).collect();
    let finite = uvs.iter().all(|uv| uv.as_vec2().is_finite());
    if !finite {
        p.reject("uv", "`uv` is too large", "more than single precision can hold");
    }
    let patches = patches?;
    if !(normals_fit && uvs_fit && finite) {
        return None;
    }
    let corners = |patch: &[u32; 4]| patch.map(|v| positions[v as usize]);
    warn_of_crossings(p, &patches, corners);
    let corner_uvs = |patch: &[u32; 4]| match uvs.is_empty() {
        true => [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE],
        false => patch.map(|v| uvs[v as usize]),
    };
    if normals.is_none() && patches.iter().all(|i| is_parallelogram(corners(i), corner_uvs(i))) {
        let mut mesh = WorldMesh::default();
        for patch in &patches {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners(patch));
            mesh.uvs.extend(corner_uvs(patch).map(|uv| uv.as_vec2().to_array()));
            mesh.triangles.extend([[first, first + 1, first + 3], [first, first + 3, first + 2]]);
        }
        return Some(Box::new(to_world(p, mesh)?));
    }

    let to_world = p.context().world_from_object;
    let reverse = p.context().reverse_orientation;
    let flip = (to_world.matrix3.determinant() < 0.0) != reverse;
    let n_matrix = normal_matrix(to_world.matrix3) * if reverse { -1.0 } else { 1.0 };
    let mut surfaces = Vec::with_capacity(patches.len());
    for patch in &patches {
        let points = corners(patch).map(|p| to_world.transform_point3(p));
        if !points.iter().all(|p| p.is_finite()) {
            let error = Diagnostic::error("bad-transform", "the current transform takes a vertex to infinity");
            p.report(error.at(p.owner().span, ""));
            return None;
        }
        let normals = normals.as_ref().map(|n| patch.map(|v| DVec3::from_array(unit(n_matrix * n[v as usize].0).map(f64::from))));
        surfaces.push(WorldGeometry::Analytic(Box::new(Patch::new(points, normals, corner_uvs(patch), flip))));
    }
    Some(Box::new(surfaces))
}

/// Warns of flat patches that cross themselves, as those do whose corners stand in a circle.
fn warn_of_crossings(p: &Params, patches: &[[u32; 4]], corners: impl Fn(&[u32; 4]) -> [DVec3; 4]) {
    let crossing = patches.iter().filter(|patch| crosses_itself(corners(patch))).count();
    if crossing > 0 {
        let what = if patches.len() == 1 {
            "this patch crosses itself".to_owned()
        } else {
            format!("{crossing} patches cross themselves")
        };
        p.report(
            Diagnostic::warning("bow-tie", format!("{what}: the third and the fourth corner have changed places"))
                .at(p.span_of(if p.is_given("indices") { "indices" } else { "P" }), "like a bow tie")
                .help("corners stand row by row: p00, p10, p01, p11, and not in a circle; exchange the last two"),
        );
    }
}

/// Whether the sides of a flat patch cross: in a circle the corners are p00, p10, p11, p01.
fn crosses_itself([p00, p10, p01, p11]: [DVec3; 4]) -> bool {
    let circle = [p00, p10, p11, p01];
    let normal = |i: usize| (circle[(i + 1) % 4] - circle[i]).cross(circle[(i + 3) % 4] - circle[i]);
    let normals: [DVec3; 4] = std::array::from_fn(normal);
    let along = normals.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or_default();
    let size = along.length();
    // Two of the corners turn the other way round than the other two.
    let turns = normals.map(|n| n.dot(along) / (size * size));
    let (left, right) = (turns.iter().filter(|t| **t > 1e-3).count(), turns.iter().filter(|t| **t < -1e-3).count());
    let is_flat = normals.iter().all(|n| n.cross(along).length() <= 1e-3 * size * size);
    is_flat && (left, right) == (2, 2)
}

/// Whether two triangles are the same as the patch, texture coordinates included.
fn is_parallelogram([p00, p10, p01, p11]: [DVec3; 4], [t00, t10, t01, t11]: [DVec2; 4]) -> bool {
    let (twist, size) = (p11 - p10 - p01 + p00, (p11 - p00).abs().max((p10 - p01).abs()));
    let (bend, range) = (t11 - t10 - t01 + t00, (t11 - t00).abs().max((t10 - t01).abs()));
    twist.abs().max_element() <= FLAT * size.max_element() && bend.abs().max_element() <= FLAT * range.max_element()
}
