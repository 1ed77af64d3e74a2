//! What light moves through: geometry, the intersector over it, and the hole. The part of a scene that integrators see.

use crate::blackhole::BlackHole;
use crate::clearance::Clearance;
use crate::geometry::{Aabb, Geometry, Segment, SurfaceGeometry};
use crate::integrator::{Ray, SurfaceHit};
use crate::intersector::{Intersector, PrimitiveHit};
use glam::{DVec2, DVec3};

/// Geometry with its intersector, in render space.
pub struct World {
    /// All surfaces; indices are those of the intersector's answers.
    pub geometries: Vec<Geometry>,
    /// Finds the first surface along a segment.
    pub intersector: Box<dyn Intersector>,
    /// A box around all surfaces; empty without any.
    pub bounds: Aabb,
    /// The hole, center in render space.
    pub hole: Option<BlackHole>,
    /// World position of render space's origin.
    pub origin: DVec3,
    /// How far single precision may move a point of a surface (scene units).
    pub margin: f64,
    /// The distance from the hole within which all surfaces lie (scene units); 0 without a hole or without surfaces.
    pub reach: f64,
    /// The free space between the surfaces, if there is a hole: for chords that need not be asked about.
    pub clearance: Option<Clearance>,
}

/// A hit in full precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// Parameter of the segment.
    pub t: f64,
    /// The point.
    pub point: DVec3,
    /// Weights of the triangle's second and third corner.
    pub barycentric: DVec2,
}

/// Relative size of the step off a surface: some 16 rounding errors of the single precision in which meshes are traced.
const OFFSET: f64 = 16.0 * f32::EPSILON as f64;

impl World {
    /// Geometry with its intersector around `hole`, whose centre is in render space; `origin` is that space's own, in the world.
    pub fn new(geometries: Vec<Geometry>, intersector: Box<dyn Intersector>, hole: Option<BlackHole>, origin: DVec3) -> Self {
        let bounds = geometries.iter().fold(Aabb::EMPTY, |b, g| b.union(g.bounds()));
        let clearance = hole.as_ref().filter(|h| h.rs > 0.0).and_then(|_| Clearance::new(&geometries, &bounds));
        let (mut margin, mut reach) = (0.0, 0.0);
        if !bounds.is_empty() {
            margin = OFFSET * bounds.min.abs().max(bounds.max.abs()).max_element();
            reach = hole.map_or(0.0, |h| (bounds.min - h.center).abs().max((bounds.max - h.center).abs()).length());
        }
        Self { geometries, intersector, bounds, hole, origin, margin, reach, clearance }
    }

    /// Refines an intersector's answer in double precision: the point of the segment on the triangle's plane, or the
    /// answer itself on an analytic surface (which is exact already).
    pub fn locate(&self, segment: &Segment, hit: &PrimitiveHit) -> Located {
        let Some([a, b, c]) = self.geometries[hit.geometry as usize].corners(hit.primitive) else {
            return Located { t: hit.t, point: segment.at(hit.t), barycentric: DVec2::ZERO };
        };
        // Moeller and Trumbore 1997, with the coordinates clamped to the triangle: the intersector has decided that it is hit.
        let (ab, ac) = (b - a, c - a);
        let n = ab.cross(ac);
        let across = n.dot(segment.direction);
        let t = n.dot(a - segment.origin) / across;
        // A ray within the plane has no better parameter than the one found.
        let strays = (t - hit.t).abs();
        let is_better = strays <= 1e-3 * hit.t.abs() || strays * segment.direction.length() <= 1e-3 * ab.length();
        let t = if is_better { t } else { hit.t };
        let ap = segment.at(t) - a;
        let per_nn = 1.0 / n.length_squared();
        let u = (n.dot(ap.cross(ac)) * per_nn).clamp(0.0, 1.0);
        let v = (n.dot(ab.cross(ap)) * per_nn).clamp(0.0, 1.0 - u);
        Located { t, point: a + ab * u + ac * v, barycentric: DVec2::new(u, v) }
    }

    /// The surface around a hit.
    pub fn surface(&self, hit: &SurfaceHit) -> SurfaceGeometry {
        self.geometries[hit.geometry as usize].surface(hit.point, hit.primitive, hit.barycentric)
    }

    /// A ray that leaves the surface point `hit` in the chart direction `direction`, moved off the surface far enough for
    /// single precision not to find that surface again, to the side of the (geometric, chart) normal that it points to.
    pub fn spawn(&self, hit: &SurfaceHit, normal: DVec3, direction: DVec3) -> Ray {
        let extent = match &self.geometries[hit.geometry as usize] {
            // Rounding grows with the coordinates of the corners, not only with those of the point.
            Geometry::Mesh(mesh) => mesh.corners(hit.primitive).into_iter().fold(0.0f64, |m, c| m.max(c.abs().max_element())),
            Geometry::Analytic(surface) => {
                let b = surface.bounds();
                b.min.abs().max(b.max.abs()).max_element()
            }
            Geometry::Instance(instance) => instance.magnitude(hit.primitive),
        };
        let offset = OFFSET * extent;
        let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
        Ray::new(hit.point + side * offset, direction)
    }
}
