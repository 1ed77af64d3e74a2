//! Objects that stand in a scene many times: their meshes are kept once, and every instance is a transform.
//!
//! The vertices of an object are single-precision numbers in coordinates of its own, near whose origin it lies and in which it is
//! about as large as in the scene; the way from there to render space is in double precision. So an instance is as exact as a copy,
//! however far from the object's origin it stands and whatever the scales.

use crate::geometry::{Aabb, SurfaceGeometry, SurfaceTangents, TriangleMesh, WorldMesh};
use bhs_elementary::Elementary;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::sync::Arc;

/// Cells along each axis into which the vertices of a mesh are sorted, so that the box around an instance is found without a look at
/// each of them.
const CELLS: f64 = 16.0;

/// The meshes of an object, in its own coordinates.
pub struct Object {
    meshes: Vec<Arc<TriangleMesh>>,
    /// The vertices of each mesh, by place.
    blocks: Vec<Vec<Block>>,
    /// From its own coordinates to those in which it was defined.
    defined_from_own: DAffine3,
    /// Triangles without area, which were dropped.
    dropped: usize,
}

impl Object {
    /// An object of meshes whose coordinates are those of world space at its definition. `typical` is the factor by which one of its
    /// instances scales it.
    pub fn new(meshes: Vec<WorldMesh>, typical: f64) -> Self {
        let bounds = meshes.iter().fold(Aabb::EMPTY, |b, m| b.union(m.bounds()));
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.origin() };
        // A power of two changes no digit.
        let scale = typical.logarithm2().round().exponential2();
        let scale = if scale.is_normal() && scale.recip().is_normal() { scale } else { 1.0 };
        let mut object = Self {
            meshes: Vec::new(),
            blocks: Vec::new(),
            defined_from_own: DAffine3::from_scale(DVec3::splat(scale.recip())),
            dropped: 0,
        };
        object.defined_from_own.translation = origin;
        for mut mesh in meshes {
            mesh.positions.iter_mut().for_each(|p| *p = (*p - origin) * scale);
            let (mesh, dropped) = mesh.rebase(DVec3::ZERO);
            object.dropped += dropped;
            object.blocks.push(blocks(&mesh));
            object.meshes.push(Arc::new(mesh));
        }
        object
    }

    /// Its meshes, in its own coordinates.
    pub fn meshes(&self) -> &[Arc<TriangleMesh>] {
        &self.meshes
    }

    /// Triangles without area that it was made with and that were dropped.
    pub fn dropped_triangles(&self) -> usize {
        self.dropped
    }

    /// Places it: `world_from_defined` takes the coordinates in which it was defined to world space, `origin` is render space's
    /// own. One geometry a mesh, in their order; `None` if the transform leaves the range of single precision.
    pub fn place(self: &Arc<Self>, world_from_defined: DAffine3, origin: DVec3) -> Option<Vec<Instance>> {
        let mut render_from_own = world_from_defined * self.defined_from_own;
        render_from_own.translation -= origin;
        let m = render_from_own.matrix3;
        let determinant = m.determinant();
        let inverse = render_from_own.inverse();
        let in_range = [determinant, determinant.recip()].into_iter().all(|d| (d as f32).is_normal());
        if !(in_range && render_from_own.is_finite() && inverse.is_finite()) {
            return None;
        }
        // As the transform of the object's own outer side; by cofactors, which a mirror turns round.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let (forth, back) = (abs(m), abs(inverse.matrix3));
        let bounds = (0..self.meshes.len()).map(|i| self.bounds(i, &render_from_own)).collect();
        let placement = Arc::new(Placement {
            object: Arc::clone(self),
            render_from_own,
            normal_from_own: cofactors * determinant.signum(),
            forth,
            there_and_back: forth * back,
            bounds,
        });
        Some((0..self.meshes.len() as u32).map(|part| Instance { placement: Arc::clone(&placement), part }).collect())
    }

    /// The smallest box around the image of a mesh.
    fn bounds(&self, mesh: usize, t: &DAffine3) -> Aabb {
        let rows = t.matrix3.transpose();
        let along = |axis: DVec3| self.farthest(mesh, axis);
        let max = DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(along));
        let min = -DVec3::from_array([rows.x_axis, rows.y_axis, rows.z_axis].map(|axis| along(-axis)));
        Aabb { min: min + t.translation, max: max + t.translation }
    }

    /// The greatest product of a vertex of a mesh with `direction`.
    fn farthest(&self, mesh: usize, direction: DVec3) -> f64 {
        let (blocks, mesh) = (&self.blocks[mesh], &self.meshes[mesh]);
        let reach = |b: &Block| direction.dot(b.bounds.center()) + direction.abs().dot(0.5 * (b.bounds.max - b.bounds.min));
        let most = |b: &Block| b.vertices.iter().map(|v| direction.dot(position(mesh, *v))).fold(f64::NEG_INFINITY, f64::max);
        // The one that reaches farthest first: few others reach as far as what is in it.
        let first = blocks.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))).map_or(f64::NEG_INFINITY, most);
        blocks.iter().fold(first, |found, b| if reach(b) > found { found.max(most(b)) } else { found })
    }
}

/// Vertices that are near each other.
struct Block {
    bounds: Aabb,
    vertices: Box<[u32]>,
}

/// The vertices of the triangles, cell by cell.
fn blocks(mesh: &TriangleMesh) -> Vec<Block> {
    let bounds = mesh.bounds();
    let per_cell = CELLS / (bounds.max - bounds.min).max_element();
    let cell = |v: u32| {
        let c = ((position(mesh, v) - bounds.min) * per_cell).as_uvec3();
        (c.z * CELLS as u32 + c.y) * CELLS as u32 + c.x
    };
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
    let mut vertices: Vec<(u32, u32)> = (0u32..).zip(used).filter(|(_, used)| *used).map(|(v, _)| (cell(v), v)).collect();
    vertices.sort_unstable();
    let of_cell = |same: &[(u32, u32)]| Block {
        bounds: same.iter().fold(Aabb::EMPTY, |b, (_, v)| b.with_point(position(mesh, *v))),
        vertices: same.iter().map(|(_, v)| *v).collect(),
    };
    vertices.chunk_by(|a, b| a.0 == b.0).map(of_cell).collect()
}

fn position(mesh: &TriangleMesh, vertex: u32) -> DVec3 {
    DVec3::from_array(mesh.positions[vertex as usize].map(f64::from))
}

fn abs(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// Where an object stands.
struct Placement {
    object: Arc<Object>,
    render_from_own: DAffine3,
    /// Takes normals along, up to their length.
    normal_from_own: DMat3,
    /// What rounding to single precision grows by on the way to render space and on that to the object and back: the magnitudes
    /// of the matrix, and of those of its inverse.
    forth: DMat3,
    there_and_back: DMat3,
    /// Of each mesh, render space.
    bounds: Vec<Aabb>,
}

/// A mesh of an object that stands somewhere.
#[derive(Clone)]
pub struct Instance {
    placement: Arc<Placement>,
    part: u32,
}

impl Instance {
    /// The mesh, in the object's own coordinates.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.placement.object.meshes[self.part as usize]
    }

    /// The object.
    pub fn object(&self) -> &Arc<Object> {
        &self.placement.object
    }

    /// Which mesh of the object it is.
    pub fn part(&self) -> u32 {
        self.part
    }

    /// Takes the object's own coordinates to render space.
    pub fn render_from_own(&self) -> &DAffine3 {
        &self.placement.render_from_own
    }

    /// Whether both are meshes of the same object at the same place.
    pub fn stands_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.placement, &other.placement)
    }

    /// The smallest box around it, render space.
    pub fn bounds(&self) -> Aabb {
        self.placement.bounds[self.part as usize]
    }

    /// The corners of a triangle, render space.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh().corners(triangle).map(|p| self.placement.render_from_own.transform_point3(p))
    }

    /// See [`TriangleMesh::surface`]. As in pbrt, what the object has of normals is transformed as a whole.
    pub fn surface(&self, triangle: u32, b: DVec2) -> SurfaceGeometry {
        let own = self.mesh().surface(triangle, b);
        let image = |n: DVec3| (self.placement.normal_from_own * n).normalize();
        SurfaceGeometry { normal: image(own.normal), shading_normal: image(own.shading_normal), ..own }
    }

    /// See [`TriangleMesh::tangents`].
    pub fn tangents(&self, triangle: u32, b: DVec2) -> SurfaceTangents {
        let Placement { render_from_own, normal_from_own, .. } = &*self.placement;
        let normal = self.mesh().surface(triangle, b).shading_normal;
        self.mesh().tangents(triangle, b).image(render_from_own.matrix3, *normal_from_own, normal)
    }

    /// The magnitude of the numbers (render space) with which single precision finds hits on a triangle: those of its corners, or more
    /// where the transform adds numbers that cancel.
    pub fn magnitude(&self, triangle: u32) -> f64 {
        let Placement { render_from_own: t, forth, there_and_back, .. } = &*self.placement;
        let corners = self.mesh().corners(triangle);
        let largest = |f: &dyn Fn(DVec3) -> DVec3| corners.into_iter().fold(DVec3::ZERO, |m, p| m.max(f(p).abs()));
        let (own, render) = (largest(&|p| p), largest(&|p| t.transform_point3(p)));
        let numbers = (*forth * own).max(*there_and_back * render.max(t.translation.abs()));
        numbers.max_element()
    }

    /// No less than [`Instance::magnitude`] of any triangle of a mesh whose coordinates are at most `own`.
    pub fn magnitude_within(&self, own: DVec3) -> f64 {
        let Placement { render_from_own: t, forth, there_and_back, .. } = &*self.placement;
        let b = self.bounds();
        let render = b.min.abs().max(b.max.abs());
        (*forth * own).max(*there_and_back * render.max(t.translation.abs())).max_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix64;

    fn random(i: u64) -> f64 {
        (mix64(i) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn points(n: u64, at: DVec3, size: f64) -> Vec<DVec3> {
        (0..n).map(|i| at + size * DVec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2))).collect()
    }

    fn slanted() -> DAffine3 {
        let m = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, -2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
        DAffine3 { matrix3: m, translation: DVec3::new(-1.0, 2.0, 0.5) }
    }

    #[test]
    fn corners_and_bounds_are_those_of_a_copy() {
        for (at, size) in [(DVec3::ZERO, 1.0), (DVec3::new(1e6, -3e6, 5e5), 1.0), (DVec3::ZERO, 1e-9), (DVec3::ZERO, 1e12)] {
            let positions = points(6000, at, size);
            let triangles: Vec<[u32; 3]> = (0..6000).map(|i| [i, (i * 7 + 1) % 6000, (i * 13 + 5) % 6000]).collect();
            let mesh = WorldMesh { positions: positions.clone(), triangles: triangles.clone(), ..Default::default() };
            // Back to where it is of ordinary size.
            let t = slanted() * DAffine3::from_scale(DVec3::splat(size.recip())) * DAffine3::from_translation(-at);
            let origin = DVec3::new(0.5, 0.25, -1.0);
            let object = Arc::new(Object::new(vec![mesh], t.matrix3.determinant().abs().cbrt()));
            assert_eq!(object.dropped_triangles(), 0);
            let instance = object.place(t, origin).expect("in range").remove(0);
            let mut bounds = Aabb::EMPTY;
            let mut worst = 0.0f64;
            for (i, triangle) in (0..).zip(&triangles) {
                for (found, v) in instance.corners(i).into_iter().zip(triangle) {
                    worst = worst.max((found - (t.transform_point3(positions[*v as usize]) - origin)).length());
                    bounds = bounds.with_point(found);
                }
            }
            assert!(worst < 4e-7, "{at} {size}: {worst:e}");
            let off = (instance.bounds().min - bounds.min).abs().max((instance.bounds().max - bounds.max).abs());
            assert!(off.max_element() < 1e-13, "{off}");
        }
    }

    #[test]
    fn the_outer_side_stays_outside() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let normals = vec![[0.6, 0.0, 0.8]; 3];
        for (t, n) in [
            (DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)), DVec3::NEG_Z),
            (DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)), DVec3::Z),
            (DAffine3::from_scale(DVec3::splat(-2.0)), DVec3::NEG_Z),
        ] {
            let mesh = WorldMesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2]],
                normals: normals.clone(),
                ..Default::default()
            };
            let instance = Arc::new(Object::new(vec![mesh], 1.0)).place(t, DVec3::ZERO).expect("in range").remove(0);
            let s = instance.surface(0, DVec2::splat(0.25));
            assert_eq!(s.normal, n);
            let expected = (t.matrix3.inverse().transpose() * DVec3::new(0.6, 0.0, 0.8)).normalize();
            assert!((s.shading_normal - expected).length() < 1e-7);
        }
    }

    #[test]
    fn what_single_precision_cannot_hold_is_refused() {
        let mesh =
            WorldMesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]], ..Default::default() };
        let object = Arc::new(Object::new(vec![mesh], 1.0));
        for factor in [1e14, 1e-14, f64::INFINITY, f64::NAN, 0.0] {
            assert!(object.place(DAffine3::from_scale(DVec3::splat(factor)), DVec3::ZERO).is_none(), "{factor}");
        }
        assert!(object.place(DAffine3::from_scale(DVec3::splat(1e12)), DVec3::ZERO).is_some());
    }
}
