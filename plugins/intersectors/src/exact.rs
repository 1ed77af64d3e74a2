//! What a segment meets of some primitives, in double precision, with a defined order of surfaces that coincide.
//!
//! Triangles are tested as in Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", JCGT 2(1): no segment slips between two
//! triangles that share an edge.
//!
//! **Surfaces that coincide.** Two surfaces coincide where they touch within rounding and have the same tangent plane. There they are
//! taken to lie an infinitesimal distance apart, each moved a little inwards, against its outer normal; of two that face the same way, the
//! one whose geometry has the lower number lies lower as seen along a fixed direction. So the order is the same whichever way a ray goes;
//! solids in contact are left before the next one is entered; and what belongs to one mesh and faces the same way is one surface.

use crate::tree::Tree;
use bhs_core::geometry::{Aabb, Analytic, Geometry, Segment};
use bhs_core::intersector::{Ends, Primitive, PrimitiveHit};
use glam::{DVec3, USizeVec3};

/// Points of a facet are computed to this, relative to the coordinates: some rounding errors. What is nearer than that touches.
const ON_FACET: f64 = 64.0 * f64::EPSILON;

/// The same of analytic surfaces, whose formulas take more operations.
const ON_ANALYTIC: f64 = 512.0 * f64::EPSILON;

/// Squared sine of the angle between tangent planes that count as the same.
const SAME_PLANE: f64 = 1e-12;

/// The direction along which surfaces that face the same way are ordered. It lies in no plane of a scene.
const UPWARDS: DVec3 = DVec3::new(0.267_949_192, 0.618_033_989, 0.738_905_610);

/// Primitives of a scene, and what finds them.
pub(crate) struct Exact {
    geometries: Vec<Geometry>,
    primitives: Vec<Primitive>,
    tree: Tree,
}

/// An end of a segment on a surface.
struct End {
    primitive: Primitive,
    point: DVec3,
    /// Outer unit normal there.
    normal: DVec3,
}

/// Where a segment meets a primitive.
#[derive(Clone, Copy)]
struct Met {
    t: f64,
    primitive: Primitive,
    /// A unit normal of its tangent plane there.
    normal: DVec3,
    /// How far from that the point may be by rounding.
    rounding: f64,
}

impl Met {
    fn hit(&self) -> PrimitiveHit {
        let Primitive { geometry, primitive } = self.primitive;
        PrimitiveHit { t: self.t, geometry, primitive, is_crowded: true }
    }
}

/// A segment that is looked along.
struct Query<'a> {
    segment: &'a Segment,
    shear: Shear,
    start: Option<End>,
    end: Option<End>,
}

impl Exact {
    /// The given primitives of `geometries`.
    pub(crate) fn new(geometries: &[Geometry], primitives: Vec<Primitive>) -> Self {
        let bounds = |p: &Primitive| {
            let b = match &geometries[p.geometry as usize] {
                Geometry::Analytic(surface) => surface.bounds(),
                mesh => mesh.corners(p.primitive).into_iter().flatten().fold(Aabb::EMPTY, Aabb::with_point),
            };
            // An analytic surface may be empty, and so is the box of a triangle whose vertices are not numbers.
            if b.is_empty() { b } else { b.grown(ON_ANALYTIC * b.min.abs().max(b.max.abs()).max_element()) }
        };
        let boxes: Vec<Aabb> = primitives.iter().map(bounds).collect();
        Self { geometries: geometries.to_vec(), tree: Tree::new(&boxes), primitives }
    }

    /// The first surface along the segment, which leaves the primitive `leaving`, if any, at its origin.
    pub(crate) fn closest(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        let query = self.query(segment, Ends { leaving, target: None })?;
        let mut best: Option<Met> = None;
        self.tree.along(segment, |number, t_max| {
            if let Some(met) = self.meet(self.primitives[number as usize], *t_max, &query)
                && best.is_none_or(|best| self.is_before(&met, &best, segment))
            {
                // What coincides with it may be found a little farther on.
                let slack = 2.0 * met.rounding / met.normal.dot(segment.direction).abs();
                *t_max = if slack.is_finite() { (met.t + slack).min(segment.t_max) } else { met.t };
                best = Some(met);
            }
            false
        });
        best.map(|met| met.hit())
    }

    /// Whether anything is met between the ends of the segment.
    pub(crate) fn blocked(&self, segment: &Segment, ends: Ends) -> bool {
        let Some(query) = self.query(segment, ends) else { return false };
        let mut blocked = false;
        self.tree.along(segment, |number, t_max| {
            blocked = self.meet(self.primitives[number as usize], *t_max, &query).is_some();
            blocked
        });
        blocked
    }

    fn query<'a>(&self, segment: &'a Segment, ends: Ends) -> Option<Query<'a>> {
        let shear = Shear::new(segment)?;
        let end = |primitive: Primitive, point: DVec3| {
            let normal = self.geometries[primitive.geometry as usize].normal(primitive.primitive, point);
            End { primitive, point, normal }
        };
        let start = ends.leaving.map(|p| end(p, segment.origin));
        let end = ends.target.map(|p| end(p, segment.at(segment.t_max)));
        Some(Query { segment, shear, start, end })
    }

    /// Where a primitive is met before the parameter `t_max`.
    fn meet(&self, primitive: Primitive, t_max: f64, query: &Query) -> Option<Met> {
        let geometry = &self.geometries[primitive.geometry as usize];
        match geometry {
            Geometry::Analytic(surface) => self.meet_analytic(primitive, &**surface, t_max, query),
            mesh => self.meet_facet(primitive, mesh.corners(primitive.primitive)?, t_max, query),
        }
    }

    fn meet_facet(&self, primitive: Primitive, corners: [DVec3; 3], t_max: f64, query: &Query) -> Option<Met> {
        let Query { segment, start, end, .. } = query;
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        for (end, is_start) in [(start, true), (end, false)] {
            let Some(end) = end else { continue };
            if end.primitive == primitive {
                return None;
            }
            let rounding = ON_FACET * size.max(end.point.abs().max_element());
            if normal.dot(end.point - a).abs() <= rounding && is_parallel(normal, end.normal) {
                let between = holds(corners, end.point) && self.is_between(end, primitive, segment.direction, is_start);
                let t = if is_start { 0.0 } else { segment.t_max };
                return between.then_some(Met { t, primitive, normal, rounding });
            }
        }
        let in_range = |t: &f64| segment.t_min < *t && *t < segment.t_max && *t <= t_max;
        let strict = || query.shear.triangle(corners).filter(in_range);
        let t = match start.as_ref().and_then(|start| beside_start(start, segment, corners, normal)) {
            None => strict()?,
            Some(t) => t.filter(in_range)?,
        };
        Some(Met { t, primitive, normal, rounding: ON_FACET * size })
    }

    fn meet_analytic(&self, primitive: Primitive, surface: &dyn Analytic, t_max: f64, query: &Query) -> Option<Met> {
        let Query { segment, start, end, .. } = query;
        let mut range = Segment { t_max: t_max.min(segment.t_max), ..**segment };
        let mut starts_on_it = false;
        let bounds = surface.bounds();
        let size = bounds.min.abs().max(bounds.max.abs()).max_element();
        for (end, is_start) in [(start, true), (end, false)] {
            let Some(end) = end else { continue };
            let rounding = ON_ANALYTIC * size.max(end.point.abs().max_element());
            if end.primitive != primitive {
                let across = Segment { origin: end.point, direction: end.normal, t_min: -rounding, t_max: rounding };
                let touches = surface.intersect(&across).is_some();
                let normal = if touches { surface.surface(end.point).normal } else { DVec3::ZERO };
                if !touches || !is_parallel(normal, end.normal) {
                    continue;
                }
                if self.is_between(end, primitive, segment.direction, is_start) {
                    let t = if is_start { 0.0 } else { segment.t_max };
                    return Some(Met { t, primitive, normal, rounding });
                }
            }
            // The surface is known to pass through the end: what is looked for is where else it is met.
            if is_start {
                starts_on_it = true;
            } else {
                range.t_max = range.t_max.min(segment.t_max - rounding / end.normal.dot(segment.direction).abs());
            }
        }
        let t = match range.t_min < range.t_max {
            true if starts_on_it => surface.intersect_again(&range)?,
            true => surface.intersect(&range)?,
            false => return None,
        };
        let is_within =
            range.t_min < t && t < range.t_max && !start.as_ref().is_some_and(|start| lies_behind(start, t, segment, bounds));
        let normal = surface.surface(segment.at(t)).normal;
        is_within.then_some(Met { t, primitive, normal, rounding: ON_ANALYTIC * size })
    }

    /// Whether a primitive that coincides with that of an end lies between the ends of a segment of the given direction: after its start or
    /// before its end.
    fn is_between(&self, end: &End, primitive: Primitive, direction: DVec3, is_start: bool) -> bool {
        let outer = self.geometries[primitive.geometry as usize].normal(primitive.primitive, end.point);
        let (own, other) = (end.normal, outer);
        let up = upwards(own);
        let (own, other) = (height(own, end.primitive, up), height(other, primitive, up));
        if (direction.dot(up) > 0.0) == is_start { other > own } else { other < own }
    }

    /// Whether `new` comes before `old` along the segment.
    fn is_before(&self, new: &Met, old: &Met, segment: &Segment) -> bool {
        let rounding = new.rounding.max(old.rounding);
        let apart = (new.t - old.t).abs() * old.normal.dot(segment.direction).abs();
        if !(apart <= rounding && is_parallel(new.normal, old.normal)) {
            return new.t < old.t;
        }
        let point = segment.at(old.t);
        let up = upwards(old.normal);
        let [new_height, old_height] = [new, old].map(|met| {
            let outer = self.geometries[met.primitive.geometry as usize].normal(met.primitive.primitive, point);
            height(outer, met.primitive, up)
        });
        if new_height == old_height {
            // One surface.
            new.primitive.primitive < old.primitive.primitive
        } else {
            (new_height < old_height) == (segment.direction.dot(up) > 0.0)
        }
    }
}

/// Where a segment crosses the plane of a facet, if that is so near to the plane of the surface on which it starts that rounding would
/// decide on which side: then the facet is met (but for rounding) if it stands on the side to which the segment goes, as a wall on a floor,
/// and is not if it lies on the other side. `None` if this says nothing about the facet.
fn beside_start(start: &End, segment: &Segment, corners: [DVec3; 3], normal: DVec3) -> Option<Option<f64>> {
    let [a, b, c] = corners;
    let rounding = ON_FACET * a.abs().max(b.abs()).max(c.abs()).max(start.point.abs()).max_element();
    let across = start.normal.dot(segment.direction);
    let t = normal.dot(a - segment.origin) / normal.dot(segment.direction);
    let off_plane = (t * across).abs();
    if off_plane.is_nan() || off_plane > rounding {
        return None;
    }
    let side = start.normal * across.signum();
    let heights = corners.map(|corner| side.dot(corner - start.point));
    if heights.iter().all(|h| *h <= rounding) {
        return Some(None);
    }
    if !heights.iter().all(|h| *h >= -rounding) {
        return None;
    }
    let point = segment.at(t);
    let (ab, ac, p) = (b - a, c - a, point - a);
    let n = ab.cross(ac);
    let per_nn = 1.0 / n.length_squared();
    let v = (n.dot(p.cross(ac)) * per_nn).clamp(0.0, 1.0);
    let w = (n.dot(ab.cross(p)) * per_nn).clamp(0.0, 1.0 - v);
    Some(((a + ab * v + ac * w - point).length() <= 2.0 * rounding).then_some(t))
}

/// Whether an analytic surface with the box `bounds`, which a segment meets at the parameter `t` so near to the plane of the surface on which it
/// starts that rounding decides on which side, lies on that side of the plane to which the segment does not go: as the wall of a can on the
/// lid of another. [`beside_start`] says the same of facets.
fn lies_behind(start: &End, t: f64, segment: &Segment, bounds: Aabb) -> bool {
    let rounding = ON_ANALYTIC * bounds.min.abs().max(bounds.max.abs()).max(start.point.abs()).max_element();
    let across = start.normal.dot(segment.direction);
    let side = start.normal * across.signum();
    (t * across).abs() <= rounding && bounds.corners().iter().all(|corner| side.dot(*corner - start.point) <= rounding)
}

/// The one of the two normals of a plane that points upwards.
fn upwards(normal: DVec3) -> DVec3 {
    if normal.dot(UPWARDS) < 0.0 { -normal } else { normal }
}

/// How high a primitive with the given outer normal lies among those that coincide.
fn height(outer: DVec3, primitive: Primitive, up: DVec3) -> (bool, u32) {
    (outer.dot(up) < 0.0, primitive.geometry)
}

fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length_squared() <= SAME_PLANE * a.length_squared() * b.length_squared()
}

/// Whether a point of a triangle's plane belongs to the triangle. (Rays that leave a facet start some rounding errors off its edges.)
fn holds([a, b, c]: [DVec3; 3], point: DVec3) -> bool {
    let (ab, ac, p) = (b - a, c - a, point - a);
    let n = ab.cross(ac);
    let per_nn = 1.0 / n.length_squared();
    let (v, w) = (n.dot(p.cross(ac)) * per_nn, n.dot(ab.cross(p)) * per_nn);
    v >= 0.0 && w >= 0.0 && v + w <= 1.0
}

/// The shear that takes the segment's line to an axis, with its start at the origin.
struct Shear {
    origin: DVec3,
    axes: USizeVec3,
    shear: DVec3,
}

impl Shear {
    /// None unless the segment is a piece of a line.
    fn new(segment: &Segment) -> Option<Self> {
        let Segment { origin, direction, t_min, t_max } = *segment;
        let is_piece = origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO && t_min < t_max;
        if !is_piece {
            return None;
        }
        let z = direction.abs().max_position();
        let axes = USizeVec3::new((z + 1) % 3, (z + 2) % 3, z);
        let along = direction[z];
        let shear = DVec3::new(direction[axes.x] / along, direction[axes.y] / along, 1.0 / along);
        Some(Self { origin, axes, shear })
    }

    /// The parameter at which the line meets the triangle, edges included.
    fn triangle(&self, corners: [DVec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            let (x, y, z) = (p[self.axes.x], p[self.axes.y], p[self.axes.z]);
            DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
        // An edge of two triangles gives these two the same number with opposite signs, exactly.
        let weights = DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let sum = weights.element_sum();
        let t = weights.dot(DVec3::new(a.z, b.z, c.z)) / sum;
        t.is_finite().then_some(t)
    }
}
