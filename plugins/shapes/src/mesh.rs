//! What all meshes share: the way from their own coordinates to world space.

use crate::polygon;
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
    for [x, y, z, sign] in &mut mesh.tangents {
        [*x, *y, *z] = unit(m * Vec3::new(*x, *y, *z).as_dvec3());
        // Of a mirrored frame normal x tangent points the other way.
        if mirrors != reverse {
            *sign = -*sign;
        }
    }
    Some(WorldGeometry::Mesh(mesh))
}

/// The unit vector along `v`, however long or short that is; zero for zero and for what is no number.
pub(crate) fn unit(v: DVec3) -> [f32; 3] {
    (v / v.abs().max_element()).normalize_or_zero().as_vec3().to_array()
}

/// A polygon of more than three corners, so far as the fan of triangles around its first corner.
pub(crate) struct Fan {
    /// Its first triangle.
    pub(crate) start: usize,
    pub(crate) triangles: usize,
}

/// Turns fans into the triangles that fill their polygons; how many of these cross themselves.
pub(crate) fn fill_polygons(mesh: &mut WorldMesh, fans: &[Fan]) -> u64 {
    /// Stands where a polygon has fewer triangles than corners let expect.
    const GONE: [u32; 3] = [u32::MAX; 3];
    let (mut crossing, mut are_some_gone) = (0, false);
    let (mut corners, mut places) = (Vec::new(), Vec::new());
    for fan in fans {
        let triangles = &mut mesh.triangles[fan.start..][..fan.triangles];
        corners.clear();
        corners.extend(triangles[0][..2].iter().copied().chain(triangles.iter().map(|t| t[2])));
        places.clear();
        places.extend(corners.iter().map(|v| mesh.positions[*v as usize]));
        let filled = polygon::fill(&places);
        crossing += u64::from(filled.crosses);
        let filled = filled.triangles.into_iter().map(|t| t.map(|i| corners[i as usize]));
        let mut filled = filled.map(Some).chain(std::iter::repeat(None));
        for triangle in triangles {
            *triangle = filled.next().flatten().unwrap_or(GONE);
            are_some_gone |= *triangle == GONE;
        }
    }
    if are_some_gone {
        mesh.triangles.retain(|t| *t != GONE);
    }
    crossing
}

/// Gives vertices whose normal is zero that of the triangles around them, weighted by area and on the side of the normals that their other
/// corners have.
pub(crate) fn fill_normals(mesh: &mut WorldMesh) {
    let is_missing = |n: &[f32; 3]| *n == [0.0; 3];
    if !mesh.normals.iter().any(is_missing) {
        return;
    }
    let mut sums = vec![DVec3::ZERO; mesh.normals.len()];
    for t in &mesh.triangles {
        let normals = t.map(|v| mesh.normals[v as usize]);
        if !normals.iter().any(is_missing) {
            continue;
        }
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let own = (b - a).cross(c - a);
        let others: DVec3 = normals.iter().map(|n| Vec3::from_array(*n).as_dvec3()).sum();
        let own = if own.dot(others) < 0.0 { -own } else { own };
        t.iter().for_each(|v| sums[*v as usize] += own);
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums).filter(|(n, _)| is_missing(n)) {
        *normal = unit(sum);
    }
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

/// Warns of `count` faces of a file whose outline crosses itself.
pub(crate) fn warn_of_crossing(p: &Params, file: &str, count: u64) {
    if count > 0 {
        let message = format!("faces of `{file}` cross themselves, and are taken for fans of triangles: {count}");
        p.report(Diagnostic::warning("crossing-faces", message).at(p.span_of("filename"), ""));
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
