//! Triangle meshes, before and after they are moved to render space.

use super::{Aabb, SurfaceGeometry};
use crate::sampling::uniform_triangle;
use glam::{DVec2, DVec3, Vec2, Vec4};

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, render space.
    pub positions: Vec<[f32; 3]>,
    /// Vertex numbers of each triangle, counter-clockwise around the outward normal `(p1-p0) x (p2-p0)`.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals of the vertices, or empty.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices, or empty.
    pub uvs: Vec<[f32; 2]>,
    /// Colours of the vertices and how opaque they are (linear sRGB), or empty.
    pub colours: Vec<[f32; 4]>,
    /// A second set of texture coordinates, or empty.
    pub second_uvs: Vec<[f32; 2]>,
    /// Directions in which tangents lie that were made with a normal map (across the shading normals up to a slant), and 1 or -1: the sign of
    /// normal x tangent along which the map's green lies. Or empty: they are those of `uvs`.
    pub tangents: Vec<[f32; 4]>,
    /// Whether the second and the third corner of every triangle have changed places since its author wrote it: what texture coordinates
    /// it has without `uvs` depends on their order.
    pub flipped: bool,
}

impl TriangleMesh {
    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        // Spelled out: `array::map` is not inlined everywhere.
        let corner = |v: u32| {
            let [x, y, z] = self.positions[v as usize];
            DVec3::new(f64::from(x), f64::from(y), f64::from(z))
        };
        let [a, b, c] = self.triangles[triangle as usize];
        [corner(a), corner(b), corner(c)]
    }

    /// The greatest coordinate of a triangle's corners: rounding grows with those, not only with the coordinates of a point.
    #[inline]
    pub(super) fn magnitude(&self, triangle: u32) -> f64 {
        let corner = |v: u32| {
            let [x, y, z] = self.positions[v as usize].map(f32::abs);
            x.max(y).max(z)
        };
        let [a, b, c] = self.triangles[triangle as usize];
        f64::from(corner(a).max(corner(b)).max(corner(c)))
    }

    /// The smallest box around the triangles.
    pub fn bounds(&self) -> Aabb {
        let positions = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
        positions.fold(Aabb::EMPTY, |b, p| b.with_point(DVec3::from_array(p.map(f64::from))))
    }

    /// Normal and texture coordinates at barycentric coordinates `b` (weights of the second and third corner).
    #[inline]
    pub fn surface(&self, triangle: u32, b: DVec2) -> SurfaceGeometry {
        let [p0, p1, p2] = self.corners(triangle);
        let mut normal = (p1 - p0).cross(p2 - p0).normalize();
        let weights = [1.0 - b.x - b.y, b.x, b.y];
        let v = self.triangles[triangle as usize];
        let mut shading_normal = normal;
        if !self.normals.is_empty() {
            let n = (0..3).map(|i| DVec3::from_array(self.normals[v[i] as usize].map(f64::from)) * weights[i]).sum::<DVec3>();
            if let Some(n) = n.try_normalize() {
                shading_normal = n;
                // As in pbrt: the vertex normals decide which side is out.
                if normal.dot(n) < 0.0 {
                    normal = -normal;
                }
            }
        }
        let uv = (0..3).map(|i| self.corner_uv(triangle, i) * weights[i]).sum::<DVec2>().as_vec2();
        let colour = match self.colours.is_empty() {
            true => Vec4::ONE,
            false => (0..3).map(|i| Vec4::from_array(self.colours[v[i] as usize]) * weights[i] as f32).sum(),
        };
        let second_uv = (!self.second_uvs.is_empty())
            .then(|| (0..3).map(|i| Vec2::from_array(self.second_uvs[v[i] as usize]) * weights[i] as f32).sum());
        SurfaceGeometry { normal, shading_normal, uv, second_uv, colour }
    }
}

/// A mesh before it is moved to render space: the same as [`TriangleMesh`], with positions in world space in `f64`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldMesh {
    /// Vertex positions, world space.
    pub positions: Vec<DVec3>,
    /// See [`TriangleMesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
    /// See [`TriangleMesh::normals`].
    pub normals: Vec<[f32; 3]>,
    /// See [`TriangleMesh::uvs`].
    pub uvs: Vec<[f32; 2]>,
    /// See [`TriangleMesh::colours`].
    pub colours: Vec<[f32; 4]>,
    /// See [`TriangleMesh::second_uvs`].
    pub second_uvs: Vec<[f32; 2]>,
    /// See [`TriangleMesh::tangents`].
    pub tangents: Vec<[f32; 4]>,
    /// See [`TriangleMesh::flipped`].
    pub flipped: bool,
}

impl WorldMesh {
    /// Moves the mesh to render space, and drops the triangles without area (of which no normal could be told), returning
    /// how many those were.
    pub fn rebase(mut self, origin: DVec3) -> (TriangleMesh, usize) {
        let positions: Vec<[f32; 3]> = self.positions.iter().map(|p| (*p - origin).as_vec3().to_array()).collect();
        let before = self.triangles.len();
        let corner = |v: u32| DVec3::from_array(positions[v as usize].map(f64::from));
        self.triangles.retain(|&[a, b, c]| {
            let (a, b, c) = (corner(a), corner(b), corner(c));
            let n = (b - a).cross(c - a);
            n.is_finite() && n.length_squared() > 0.0
        });
        let dropped = before - self.triangles.len();
        let Self { triangles, normals, uvs, colours, second_uvs, tangents, flipped, .. } = self;
        let mesh = TriangleMesh { positions, triangles, normals, uvs, colours, second_uvs, tangents, flipped };
        (mesh, dropped)
    }

    /// The smallest box around the vertices.
    pub fn bounds(&self) -> Aabb {
        self.positions.iter().fold(Aabb::EMPTY, |b, p| b.with_point(*p))
    }
}

/// A uniform point of a triangle, given by its corners: the point and its barycentric coordinates.
#[inline]
pub fn sample_triangle([a, b, c]: [DVec3; 3], u: Vec2) -> (DVec3, DVec2) {
    let w = uniform_triangle(u).as_dvec2();
    (a + (b - a) * w.x + (c - a) * w.y, w)
}

/// Area of a triangle, given by its corners; chart measure.
pub fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}
