//! How points and normals of a surface move with its texture coordinates.

use super::TriangleMesh;
use glam::{DMat3, DVec2, DVec3, DVec4};

/// Derivatives by the texture coordinates (u, v) around a point of a surface; chart measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceTangents {
    /// Of the point, by u.
    pub dpdu: DVec3,
    /// Of the point, by v.
    pub dpdv: DVec3,
    /// Of the unit shading normal, by u.
    pub dndu: DVec3,
    /// Of the unit shading normal, by v.
    pub dndv: DVec3,
}

impl SurfaceTangents {
    /// Some unit tangents of a plane with the unit normal `normal`: of surfaces whose texture coordinates say nothing.
    pub fn of_plane(normal: DVec3) -> Self {
        let (dpdu, dpdv) = normal.any_orthonormal_pair();
        Self { dpdu, dpdv, dndu: DVec3::ZERO, dndv: DVec3::ZERO }
    }

    /// Of a surface of which `[dpdu, dpdv]` are known at `point`, and everywhere near it the unit normal.
    pub fn with_normals([dpdu, dpdv]: [DVec3; 2], point: DVec3, normal: impl Fn(DVec3) -> DVec3) -> Self {
        // Central differences: their error is of the square of this share of the unit of texture.
        const STEP: f64 = 1e-5;
        let by = |along: DVec3| (normal(point + along * STEP) - normal(point - along * STEP)) / (2.0 * STEP);
        Self { dpdu, dpdv, dndu: by(dpdu), dndv: by(dpdv) }
    }

    /// Whether both derivatives of the point are finite, and neither is 0 or parallel to the other.
    pub fn span_a_plane(&self) -> bool {
        let area = self.dpdu.cross(self.dpdv).length();
        area.is_finite() && area > 1e-12 * self.dpdu.length() * self.dpdv.length() && area > 0.0
    }

    /// Those of the image of the surface under a linear map: `normal_map` takes normals along, up to their length, and `normal` is the shading
    /// normal before.
    #[must_use]
    pub fn image(self, map: DMat3, normal_map: DMat3, normal: DVec3) -> Self {
        let image = normal_map * normal;
        let (length, unit) = (image.length(), image.normalize());
        let of_normal = |d: DVec3| {
            let d = normal_map * d / length;
            d - unit * unit.dot(d)
        };
        Self { dpdu: map * self.dpdu, dpdv: map * self.dpdv, dndu: of_normal(self.dndu), dndv: of_normal(self.dndv) }
    }
}

impl TriangleMesh {
    /// The texture coordinates of the corner number `i` of a triangle.
    #[inline]
    pub(super) fn corner_uv(&self, triangle: u32, i: usize) -> DVec2 {
        match self.uvs.get(self.triangles[triangle as usize][i] as usize) {
            Some(uv) => DVec2::from_array(uv.map(f64::from)),
            None if self.flipped => [DVec2::ZERO, DVec2::ONE, DVec2::X][i],
            None => [DVec2::ZERO, DVec2::X, DVec2::ONE][i],
        }
    }

    /// The tangents at barycentric coordinates `b` (weights of the second and third corner).
    pub fn tangents(&self, triangle: u32, b: DVec2) -> SurfaceTangents {
        let by_uv = self.tangents_by_uv(triangle, b);
        self.own_tangents(triangle, b, &by_uv).unwrap_or(by_uv)
    }

    /// `by_uv` turned to the tangents that the vertices have; `None`: they have none, or they say nothing here.
    fn own_tangents(&self, triangle: u32, b: DVec2, by_uv: &SurfaceTangents) -> Option<SurfaceTangents> {
        if self.tangents.is_empty() {
            return None;
        }
        let weights = [1.0 - b.x - b.y, b.x, b.y];
        let v = self.triangles[triangle as usize];
        let sum: DVec4 = (0..3).map(|i| DVec4::from_array(self.tangents[v[i] as usize].map(f64::from)) * weights[i]).sum();
        let normal = self.surface(triangle, b).shading_normal;
        let along = sum.truncate();
        let along = (along - normal * normal.dot(along)).try_normalize()?;
        let across = normal.cross(along) * sum.w.signum();
        Some(SurfaceTangents { dpdu: along * by_uv.dpdu.length(), dpdv: across * by_uv.dpdv.length(), ..*by_uv })
    }

    fn tangents_by_uv(&self, triangle: u32, b: DVec2) -> SurfaceTangents {
        let [p0, p1, p2] = self.corners(triangle);
        let [uv0, uv1, uv2] = [0, 1, 2].map(|i| self.corner_uv(triangle, i));
        let (duv1, duv2) = (uv1 - uv0, uv2 - uv0);
        let determinant = duv1.perp_dot(duv2);
        // By u and by v, of what differs by `d1` and `d2` from the first corner to the others.
        let solve = |d1: DVec3, d2: DVec3| [(d1 * duv2.y - d2 * duv1.y) / determinant, (d2 * duv1.x - d1 * duv2.x) / determinant];
        let [dpdu, dpdv] = solve(p1 - p0, p2 - p0);
        let mut tangents = SurfaceTangents { dpdu, dpdv, dndu: DVec3::ZERO, dndv: DVec3::ZERO };
        if !tangents.span_a_plane() {
            return SurfaceTangents::of_plane((p1 - p0).cross(p2 - p0).normalize());
        }
        if !self.normals.is_empty() {
            let v = self.triangles[triangle as usize];
            let [n0, n1, n2] = v.map(|v| DVec3::from_array(self.normals[v as usize].map(f64::from)));
            let sum = n0 * (1.0 - b.x - b.y) + n1 * b.x + n2 * b.y;
            if let Some(unit) = sum.try_normalize() {
                // The normal is that sum over its length.
                let of_unit = |d: DVec3| (d - unit * unit.dot(d)) / sum.length();
                [tangents.dndu, tangents.dndv] = solve(n1 - n0, n2 - n0).map(of_unit);
            }
        }
        tangents
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> TriangleMesh {
        TriangleMesh {
            positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            normals: vec![[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.6, 0.8]],
            uvs: vec![[0.1, 0.2], [0.9, 0.1], [0.3, 0.8]],
            ..TriangleMesh::default()
        }
    }

    #[test]
    fn points_and_normals_move_as_the_tangents_say() {
        let mesh = mesh();
        let corners = mesh.corners(0);
        let [uv0, uv1, uv2] = [0, 1, 2].map(|i| mesh.corner_uv(0, i));
        let at = DVec2::new(0.3, 0.25);
        let tangents = mesh.tangents(0, at);
        for (step, of_point, of_normal) in
            [(DVec2::X, tangents.dpdu, tangents.dndu), (DVec2::Y, tangents.dpdv, tangents.dndv)].map(|(s, p, n)| (s * 1e-5, p, n))
        {
            // The weights of the point that is `step` further in texture.
            let m = glam::DMat2::from_cols(uv1 - uv0, uv2 - uv0).inverse();
            let moved = at + m * step;
            let point = |b: DVec2| corners[0] + (corners[1] - corners[0]) * b.x + (corners[2] - corners[0]) * b.y;
            let by = |d: DVec3| d / 1e-5;
            assert!((by(point(moved) - point(at)) - of_point).length() < 1e-5);
            let normal = |b| mesh.surface(0, b).shading_normal;
            assert!((by(normal(moved) - normal(at)) - of_normal).length() < 1e-4);
        }
    }

    #[test]
    fn texture_coordinates_that_say_nothing_have_some_tangents() {
        let flat = TriangleMesh { uvs: vec![[0.5, 0.5]; 3], ..mesh() };
        let tangents = flat.tangents(0, DVec2::splat(0.2));
        assert!(tangents.span_a_plane() && tangents.dndu == DVec3::ZERO);
        let normal = flat.surface(0, DVec2::splat(0.2)).normal;
        assert!(tangents.dpdu.dot(normal).abs() < 1e-12 && tangents.dpdv.dot(normal).abs() < 1e-12);
    }
}
