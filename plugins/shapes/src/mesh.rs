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
        mesh.flipped = !mesh.flipped;
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

/// The parameter `indices` of a mesh of `P`: `N` vertex numbers for each of its pieces, which are called `piece`. `None` after a report
/// of what is wrong with them.
pub(crate) fn checked_indices<const N: usize>(
    p: &Params,
    indices: Option<Vec<i64>>,
    vertices: usize,
    piece: &str,
) -> Option<Vec<[u32; N]>> {
    let Some(indices) = indices else {
        if vertices != N {
            let message = format!("`indices` can be left out with exactly {N} vertices only, not with {vertices}");
            p.reject("P", message, format!("which of these make a {piece}?"));
            return None;
        }
        return Some(vec![std::array::from_fn(|i| i as u32)]);
    };
    if indices.is_empty() || indices.len() % N != 0 {
        let cause = format!("found {}: each {piece} takes {N}", indices.len());
        p.reject("indices", format!("the number of `indices` is not a multiple of {N}"), cause);
        return None;
    }
    let limit = vertices.min(u32::MAX as usize) as i64;
    if let Some((i, v)) = indices.iter().enumerate().find(|(_, v)| !(0..limit).contains(*v)) {
        let message = format!("vertex index {v} of {piece} {} is out of range", i / N);
        p.reject("indices", message, format!("there are {vertices} vertices, counted from 0"));
        return None;
    }
    Some(indices.chunks_exact(N).map(|c| std::array::from_fn(|i| c[i] as u32)).collect())
}

/// Whether a mesh can have `count` of `what` (vertices or triangles), which it numbers with 32 bits.
///
/// # Errors
/// That it cannot, in words that can follow "cannot read `file`: ".
pub(crate) fn can_be_numbered(count: u64, what: &str) -> Result<(), String> {
    match u32::try_from(count) {
        Ok(_) => Ok(()),
        Err(_) => Err(format!("{count} {what} are more than the {} that a mesh can have", u32::MAX)),
    }
}

/// Whether the parameter `name` has one value a vertex; reports if not.
pub(crate) fn one_a_vertex(p: &Params, name: &str, values: usize, vertices: usize) -> bool {
    if values != vertices {
        let cause = format!("{values} for {vertices} vertices: one each is needed");
        p.reject(name, format!("`{name}` does not match `P`"), cause);
    }
    values == vertices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_numbered_says_so() {
        assert_eq!(can_be_numbered(4_294_967_295, "triangles"), Ok(()));
        let fault = "4294967296 triangles are more than the 4294967295 that a mesh can have";
        assert_eq!(can_be_numbered(4_294_967_296, "triangles"), Err(fault.to_owned()));
    }
}
