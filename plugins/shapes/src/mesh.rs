//! What all meshes share: the way from their own coordinates to world space.

use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{WorldGeometry, WorldMesh};
use bhs_core::params::Params;
use glam::{DMat3, DVec3, Vec3};

/// Applies the current transform and `ReverseOrientation` to a mesh in its own coordinates; `None` after a report that a
/// vertex leaves the numbers.
///
/// As in pbrt, the outward normal is the transform of the object's own: where the transform mirrors, two corners of every
/// triangle change places so that `(p1-p0) x (p2-p0)` stays on that side.
pub(crate) fn to_world(p: &Params, mut mesh: WorldMesh) -> Option<WorldGeometry> {
    let to_world = p.context().world_from_object;
    let reverse = p.context().reverse_orientation;
    for v in &mut mesh.positions {
        *v = to_world.transform_point3(*v);
    }
    if let Some(i) = mesh.positions.iter().position(|v| !v.is_finite()) {
        p.report(
            Diagnostic::error("bad-transform", format!("the current transform takes vertex {i} to infinity"))
                .at(p.owner().span, ""),
        );
        return None;
    }
    let m = to_world.matrix3;
    let mirrors = m.determinant() < 0.0;
    if mirrors != reverse {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
    let n_matrix = normal_matrix(m) * if reverse { -1.0 } else { 1.0 };
    for n in &mut mesh.normals {
        *n = unit(n_matrix * Vec3::from_array(*n).as_dvec3());
    }
    Some(WorldGeometry::Mesh(mesh))
}

/// The unit vector along `v`, however long or short that is; zero for zero.
pub(crate) fn unit(v: DVec3) -> [f32; 3] {
    (v / v.abs().max_element()).normalize_or_zero().as_vec3().to_array()
}

/// What takes normals along when `m` takes points: the inverse transpose of `m` up to a positive factor, by cofactors, so
/// that it exists for flattening transforms too.
pub(crate) fn normal_matrix(m: DMat3) -> DMat3 {
    let [a, b, c]: [DVec3; 3] = [m.x_axis, m.y_axis, m.z_axis];
    let cofactors = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    cofactors * if m.determinant() < 0.0 { -1.0 } else { 1.0 }
}
