//! Shapes as intersectors and light sampling see them: triangle meshes and exact surfaces, in render space.
//!
//! Render space is world space moved so that the scene lies near the origin; positions are `f64` but for the vertices of
//! meshes, which are stored (and traced) as `f32`.

use glam::{DVec2, DVec3, Vec2, Vec4};
use std::sync::Arc;

pub mod instance;
mod mesh;
mod tangents;

use instance::Instance;

pub use mesh::{TriangleMesh, WorldMesh, sample_triangle, triangle_area};
pub use tangents::SurfaceTangents;

/// An axis-aligned box; empty if `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Whether it contains nothing.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The smallest box around this one and a point.
    pub fn with_point(self, p: DVec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box around both.
    pub fn union(self, o: Self) -> Self {
        Self { min: self.min.min(o.min), max: self.max.max(o.max) }
    }

    /// Grown by `by` on every side.
    pub fn grown(self, by: f64) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether a point lies in the box.
    #[inline]
    pub fn contains(&self, p: DVec3) -> bool {
        (self.min.cmple(p) & p.cmple(self.max)).all()
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Where coordinates should begin so that single precision is spent within: at 0 if the box is near it, else in its middle.
    pub fn origin(&self) -> DVec3 {
        let extent = (self.max - self.min).max_element();
        if self.center().length() <= 4.0 * extent { DVec3::ZERO } else { self.center() }
    }

    /// The eight corners.
    #[inline]
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i & bit == 0 { lo } else { hi };
            DVec3::new(pick(1, self.min.x, self.max.x), pick(2, self.min.y, self.max.y), pick(4, self.min.z, self.max.z))
        })
    }

    /// The part `(enter, leave)` of `t_min..=t_max` for which `origin + t direction` lies in the box, if any.
    #[inline]
    pub fn clip(&self, origin: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (t_min, t_max);
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                if o < self.min[axis] || o > self.max[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.min[axis] - o) / d, (self.max[axis] - o) / d);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some((enter, leave))
    }
}

/// A piece of a straight line: `origin + t direction` for `t_min < t < t_max`; `direction` need not be a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where t = 0.
    pub origin: DVec3,
    /// Change of position with t.
    pub direction: DVec3,
    /// Start.
    pub t_min: f64,
    /// End; may be infinite.
    pub t_max: f64,
}

impl Segment {
    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Relative size of a step off a surface: some 16 rounding errors of the single precision in which meshes are traced.
pub const STEP_OFF: f64 = 16.0 * f32::EPSILON as f64;

/// How far from the edges of its triangle a ray starts at least that starts exactly on it, relative to the coordinates: some 256
/// rounding errors of double precision. So it starts on that side of the neighbouring triangles on which it should.
const OFF_EDGES: f64 = 256.0 * f64::EPSILON;

/// What a surface looks like around one of its points; chart measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceGeometry {
    /// Unit normal of the surface itself, on its outer side.
    pub normal: DVec3,
    /// Unit normal that shading uses.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Those of the second set, where a mesh has one.
    pub second_uv: Option<Vec2>,
    /// Colour and opacity that its vertices give it (linear sRGB); 1 where they give none.
    pub colour: Vec4,
}

/// A point drawn from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaSample {
    /// The point, render space.
    pub point: DVec3,
    /// The surface's outer unit normal there.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Density with respect to chart area.
    pub pdf: f64,
}

/// A surface given by a formula, such as a sphere. All positions are in render space.
pub trait Analytic: Send + Sync {
    /// A box around it.
    fn bounds(&self) -> Aabb;
    /// Whether the surface may pass through the box of the given middle and half sides, which lies within its bounds: `false` only
    /// if it does not.
    fn may_pass(&self, _middle: DVec3, _half: DVec3) -> bool {
        true
    }
    /// The least `t` in the open range of the segment at which it meets the surface.
    fn intersect(&self, segment: &Segment) -> Option<f64>;
    /// The least positive `t` before the end of the segment at which it meets the surface again, on which it starts (at `t` = 0, but for
    /// rounding). `None` for a surface that no line meets twice.
    fn intersect_again(&self, _segment: &Segment) -> Option<f64> {
        None
    }
    /// The surface around a point of it.
    fn surface(&self, point: DVec3) -> SurfaceGeometry;
    /// How a point of it moves with u and with v; `None` where the texture coordinates do not say.
    fn tangents(&self, _point: DVec3) -> Option<[DVec3; 2]> {
        None
    }
    /// Its area, chart measure.
    fn area(&self) -> f64;
    /// Draws a point of it.
    fn sample(&self, u: Vec2) -> AreaSample;
    /// The density with which [`Analytic::sample`] draws `point`, with respect to chart area.
    fn pdf(&self, point: DVec3) -> f64;
    /// Draws a point of it that may be seen from `place` along a straight line: of a surface that hides part of itself it may leave out what is hidden.
    fn sample_from(&self, _place: DVec3, u: Vec2) -> AreaSample {
        self.sample(u)
    }
    /// The density with which [`Analytic::sample_from`] draws `point`, with respect to chart area; 0 of what it leaves out.
    fn pdf_from(&self, _place: DVec3, point: DVec3) -> f64 {
        self.pdf(point)
    }
    /// Leaves out what lies nearer to its centre than `inner` (chart, scene units), if it is a disk of which the scene does not say where it
    /// begins. `false` if nothing would be left of it.
    fn open(&mut self, _inner: f64) -> bool {
        true
    }
    /// How far apart opposite sides of it are at least (scene units); infinite for a surface without an opposite side.
    fn thickness(&self) -> f64 {
        f64::INFINITY
    }
    /// Moves the surface by `-origin`, from world space to render space. Called once, before anything else.
    fn rebase(&mut self, origin: DVec3);
}

/// The surface of one shape.
#[derive(Clone)]
pub enum Geometry {
    /// Triangles.
    Mesh(Arc<TriangleMesh>),
    /// A formula.
    Analytic(Arc<dyn Analytic>),
    /// Triangles that other places have too.
    Instance(Instance),
}

impl Geometry {
    /// A box around it.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Analytic(surface) => surface.bounds(),
            Self::Instance(instance) => instance.bounds(),
        }
    }

    /// Its triangles' number; none in an analytic surface.
    pub fn triangle_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len(),
            Self::Analytic(_) => 0,
            Self::Instance(instance) => instance.mesh().triangles.len(),
        }
    }

    /// The corners of a triangle, render space; `None` for an analytic surface.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> Option<[DVec3; 3]> {
        match self {
            Self::Mesh(mesh) => Some(mesh.corners(triangle)),
            Self::Analytic(_) => None,
            Self::Instance(instance) => Some(instance.corners(triangle)),
        }
    }

    /// The magnitude of the numbers (render space) with which single precision finds hits on a primitive.
    #[inline]
    pub fn magnitude(&self, primitive: u32) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.magnitude(primitive),
            Self::Analytic(surface) => {
                let b = surface.bounds();
                b.min.abs().max(b.max.abs()).max_element()
            }
            Self::Instance(instance) => instance.magnitude(primitive),
        }
    }

    /// How far off a primitive single precision does not find it again (scene units).
    #[inline]
    pub fn step_off(&self, primitive: u32) -> f64 {
        STEP_OFF * self.magnitude(primitive)
    }

    /// The point `point` of a primitive, which has the weights `barycentric` of its second and third corner, moved off the edges of
    /// the triangle by some rounding errors.
    pub fn inner_point(&self, primitive: u32, point: DVec3, barycentric: DVec2) -> DVec3 {
        let Some([a, b, c]) = self.corners(primitive) else { return point };
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        let (ab, ac) = (b - a, c - a);
        let longest = ab.length_squared().max(ac.length_squared()).max((c - b).length_squared());
        // The least height over an edge.
        let height = (ab.cross(ac).length_squared() / longest).sqrt();
        let least = (OFF_EDGES * size / height).min(0.25);
        let weights = [1.0 - barycentric.x - barycentric.y, barycentric.x, barycentric.y];
        if weights.into_iter().all(|w| w >= least) {
            return point;
        }
        let [_, v, w] = weights.map(|w| w.max(least));
        let sum = weights.map(|w| w.max(least)).into_iter().sum::<f64>();
        a + ab * (v / sum) + ac * (w / sum)
    }

    /// The outer unit normal of the surface at a point of a primitive, chart.
    pub fn normal(&self, primitive: u32, point: DVec3) -> DVec3 {
        let barycentric = self.corners(primitive).map_or(DVec2::ZERO, |[a, b, c]| {
            let (ab, ac, p) = (b - a, c - a, point - a);
            let n = ab.cross(ac);
            let per_nn = n.length_squared().recip();
            // A triangle without area has no weights.
            if !per_nn.is_finite() {
                return DVec2::ZERO;
            }
            let v = (n.dot(p.cross(ac)) * per_nn).clamp(0.0, 1.0);
            DVec2::new(v, (n.dot(ab.cross(p)) * per_nn).clamp(0.0, 1.0 - v))
        });
        self.surface(point, primitive, barycentric).normal
    }

    /// The surface around a point of it: of triangles, that with the weights `barycentric` of the second and third corner of
    /// `triangle`.
    #[inline]
    pub fn surface(&self, point: DVec3, triangle: u32, barycentric: DVec2) -> SurfaceGeometry {
        match self {
            Self::Mesh(mesh) => mesh.surface(triangle, barycentric),
            Self::Analytic(surface) => surface.surface(point),
            Self::Instance(instance) => instance.surface(triangle, barycentric),
        }
    }

    /// How a point of it, given as for [`Geometry::surface`], and the normal there move with the texture coordinates.
    pub fn tangents(&self, point: DVec3, triangle: u32, barycentric: DVec2) -> SurfaceTangents {
        match self {
            Self::Mesh(mesh) => mesh.tangents(triangle, barycentric),
            Self::Analytic(surface) => {
                let normal = |p| surface.surface(p).shading_normal;
                let known = surface.tangents(point).map(|t| SurfaceTangents::with_normals(t, point, normal));
                known.filter(SurfaceTangents::span_a_plane).unwrap_or_else(|| SurfaceTangents::of_plane(normal(point)))
            }
            Self::Instance(instance) => instance.tangents(triangle, barycentric),
        }
    }
}

/// What a shape plugin makes, in world space.
pub enum WorldGeometry {
    /// Triangles.
    Mesh(WorldMesh),
    /// A formula.
    Analytic(Box<dyn Analytic>),
}

impl WorldGeometry {
    /// A box around it, world space.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Analytic(surface) => surface.bounds(),
        }
    }
}

/// A shape plugin's product; kept behind a trait so that shapes register like every other kind.
pub trait Shape: Send + Sync {
    /// Hands over the geometry, in world space, normals on the outer side (transform and `ReverseOrientation` applied): mostly one
    /// surface, or several that share what they are made of.
    fn into_geometry(self: Box<Self>) -> Vec<WorldGeometry>;
}

impl Shape for WorldGeometry {
    fn into_geometry(self: Box<Self>) -> Vec<WorldGeometry> {
        vec![*self]
    }
}

impl Shape for Vec<WorldGeometry> {
    fn into_geometry(self: Box<Self>) -> Vec<WorldGeometry> {
        *self
    }
}
