//! What light moves through: geometry, the intersector over it, and the spacetime. The part of a scene that integrators see.

use crate::clearance::Clearance;
use bhs_core::geometry::{Aabb, Analytic, Geometry, STEP_OFF, Segment, SurfaceGeometry, SurfaceTangents};
use bhs_core::intersector::{Ends, Intersector, Primitive, PrimitiveHit};
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::{Conventions, Observer};
use bhs_core::ray::{Ray, SurfaceHit};
use bhs_core::spacetime::{Class, Minkowski, Place, Side, Spacetime, Spherical};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Geometry with its intersector, in render space.
pub struct World {
    /// All surfaces; indices are those of the intersector's answers.
    pub geometries: Vec<Geometry>,
    /// Finds the first surface along a segment.
    pub intersector: Box<dyn Intersector>,
    /// A box around all surfaces; empty without any.
    pub bounds: Aabb,
    /// World position of render space's origin.
    pub origin: DVec3,
    /// How far single precision may move a point of a surface (scene units).
    pub margin: f64,
    /// The free space between the surfaces, if light bends: for chords that need not be asked about.
    pub clearance: Option<Clearance>,
    /// What light moves through, in coordinates of render space.
    spacetime: Arc<dyn Spacetime>,
    bends: bool,
    /// The same, if it is a round hole: observers are asked for at every vertex.
    round: Option<Spherical>,
    /// What the picture takes of nature.
    pub conventions: Conventions,
    /// The far side of a wormhole, if it has surfaces.
    far: Option<Far>,
}

/// What is on the far side. Its geometries follow those of the near side in [`World::geometries`].
struct Far {
    intersector: Box<dyn Intersector>,
    /// Number of its first geometry.
    first: u32,
    bounds: Aabb,
    margin: f64,
    clearance: Option<Clearance>,
}

/// The surfaces of one side of a world.
#[derive(Clone, Copy)]
pub struct Half<'w> {
    intersector: &'w dyn Intersector,
    first: u32,
    /// A box around them; empty without any.
    pub bounds: &'w Aabb,
    /// How far single precision may move a point of them (scene units).
    pub margin: f64,
    /// The free space between them.
    pub clearance: Option<&'w Clearance>,
}

impl Half<'_> {
    fn own(&self, p: Primitive) -> Primitive {
        Primitive { geometry: p.geometry - self.first, ..p }
    }

    fn of_world(&self, hit: PrimitiveHit) -> PrimitiveHit {
        PrimitiveHit { geometry: hit.geometry + self.first, ..hit }
    }

    /// The first surface along a segment, which leaves the primitive `leaving` exactly at its origin, if any; numbers are those of the world.
    #[inline]
    pub fn closest(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        let hit = match leaving {
            None => self.intersector.closest(segment),
            Some(_) => self.intersector.closest_from(segment, leaving.map(|p| self.own(p))),
        };
        hit.map(|hit| self.of_world(hit))
    }

    /// The same of a segment that starts where surfaces may be as near as rounding: see [`Intersector::closest_from`].
    #[inline]
    pub fn closest_from(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        let hit = self.intersector.closest_from(segment, leaving.map(|p| self.own(p)));
        hit.map(|hit| self.of_world(hit))
    }

    /// Whether anything stands between the ends of a segment; numbers are those of the world.
    #[inline]
    pub fn blocked_between(&self, segment: &Segment, ends: Ends) -> bool {
        let own = |p| self.own(p);
        self.intersector.blocked_between(segment, Ends { leaving: ends.leaving.map(own), target: ends.target.map(own) })
    }

    /// See [`Intersector::is_crowded`].
    #[inline]
    pub fn is_crowded(&self, point: DVec3) -> bool {
        self.intersector.is_crowded(point)
    }
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

/// How far the rounding of a long way may move a point off an analytic surface, relative to that way.
const STRAY: f64 = 1e-12;

/// An analytic surface's point is put back onto the surface if the way to it was this many times as long as its coordinates.
const LONG_WAY: f64 = 16.0;

impl World {
    /// Geometry with its intersector in flat space; `origin` is that of render space, in the world.
    pub fn new(geometries: Vec<Geometry>, intersector: Box<dyn Intersector>, origin: DVec3) -> Self {
        let bounds = around(&geometries);
        let margin = margin(&bounds);
        let (spacetime, conventions) = (Arc::new(Minkowski::default()), Conventions::NATURE);
        Self {
            geometries,
            intersector,
            bounds,
            origin,
            margin,
            clearance: None,
            spacetime,
            bends: false,
            round: None,
            conventions,
            far: None,
        }
    }

    /// The same surfaces in `spacetime`, which is in coordinates of render space.
    #[must_use]
    pub fn in_spacetime(self, spacetime: Arc<dyn Spacetime>, conventions: Conventions) -> Self {
        let (bends, round) = match spacetime.class() {
            Class::Flat => (false, None),
            Class::Spherical(hole) => (true, Some(hole)),
            _ => (true, None),
        };
        let clearance = if bends { Clearance::new(&self.geometries, &self.bounds) } else { None };
        Self { spacetime, bends, round, conventions, clearance, ..self }
    }

    /// What light moves through, in coordinates of render space.
    #[inline]
    pub fn spacetime(&self) -> &dyn Spacetime {
        &*self.spacetime
    }

    /// Other surfaces in the same spacetime; those of the far side are gone.
    #[must_use]
    pub fn with_surfaces(self, geometries: Vec<Geometry>, intersector: Box<dyn Intersector>) -> Self {
        let Self { origin, spacetime, conventions, .. } = self;
        Self::new(geometries, intersector, origin).in_spacetime(spacetime, conventions)
    }

    /// Whether light bends: the spacetime is not flat.
    #[inline]
    pub fn bends(&self) -> bool {
        self.bends
    }

    /// With the surfaces `geometries`, over which `intersector` is built, on the far side.
    #[must_use]
    pub fn with_far_side(mut self, geometries: Vec<Geometry>, intersector: Box<dyn Intersector>) -> Self {
        let bounds = around(&geometries);
        let margin = margin(&bounds);
        let clearance = Clearance::new(&geometries, &bounds);
        self.far = Some(Far { intersector, first: self.geometries.len() as u32, bounds, margin, clearance });
        self.geometries.extend(geometries);
        self
    }

    /// The surfaces of one side; `None` if the far side has none.
    #[inline]
    pub fn half(&self, side: Side) -> Option<Half<'_>> {
        match (side, &self.far) {
            (Side::Near, _) => {
                let Self { intersector, bounds, margin, clearance, .. } = self;
                Some(Half { intersector: &**intersector, first: 0, bounds, margin: *margin, clearance: clearance.as_ref() })
            }
            (Side::Far, Some(Far { intersector, first, bounds, margin, clearance })) => {
                Some(Half { intersector: &**intersector, first: *first, bounds, margin: *margin, clearance: clearance.as_ref() })
            }
            (Side::Far, None) => None,
        }
    }

    /// A box around all surfaces of both sides, in whose charts their coordinates are; empty without any.
    pub fn bounds_of_both_sides(&self) -> Aabb {
        self.far.as_ref().map_or(self.bounds, |far| self.bounds.union(far.bounds))
    }

    /// The side that a geometry is on.
    #[inline]
    pub fn side_of(&self, geometry: u32) -> Side {
        match &self.far {
            Some(far) if geometry >= far.first => Side::Far,
            _ => Side::Near,
        }
    }

    /// The place of a hit.
    #[inline]
    pub fn place_of(&self, hit: &SurfaceHit) -> Place {
        Place { x: hit.point, side: self.side_of(hit.geometry) }
    }

    /// The observer at rest at `place`; `None` where nothing can stand still.
    #[inline]
    pub fn static_observer(&self, place: Place) -> Option<Observer> {
        if !self.bends {
            return Some(Observer::FLAT);
        }
        let here = match &self.round {
            Some(hole) => hole.at(place.x),
            None => self.spacetime.at(place),
        };
        here.map(|here| self.conventions.observer(&here))
    }

    /// The observer who moves as `motion` says at `place`; `None` where nothing can move so.
    pub fn moving_observer(&self, motion: &dyn Motion, place: Place) -> Option<Observer> {
        let spacetime = self.bends.then(|| self.spacetime());
        motion.observer(&Surroundings { spacetime, place, conventions: self.conventions })
    }

    /// Refines an intersector's answer in double precision: the point of the segment on the triangle's plane, or the
    /// answer itself on an analytic surface (which is exact already).
    pub fn locate(&self, segment: &Segment, hit: &PrimitiveHit) -> Located {
        let geometry = &self.geometries[hit.geometry as usize];
        if let Geometry::Analytic(surface) = geometry {
            return Located { t: hit.t, point: on_surface(&**surface, segment, hit.t), barycentric: DVec2::ZERO };
        }
        let Some([a, b, c]) = geometry.corners(hit.primitive) else {
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
    #[inline]
    pub fn surface(&self, hit: &SurfaceHit) -> SurfaceGeometry {
        self.geometries[hit.geometry as usize].surface(hit.point, hit.primitive, hit.barycentric)
    }

    /// How the point of a hit and its normal move with the texture coordinates.
    pub fn tangents(&self, hit: &SurfaceHit) -> SurfaceTangents {
        self.geometries[hit.geometry as usize].tangents(hit.point, hit.primitive, hit.barycentric)
    }

    /// A ray that leaves the surface point `hit` in the chart direction `direction`.
    ///
    /// Where no other surface is near, it starts a little off the surface, on the side of the (geometric, chart) normal that it
    /// points to, so that single precision does not find that surface again. Where one may be as near as that
    /// ([`Intersector::is_crowded`]), it starts on the surface and says which it leaves.
    #[inline]
    pub fn spawn(&self, hit: &SurfaceHit, normal: DVec3, direction: DVec3) -> Ray {
        self.leave(hit, normal, direction, self.step_off(hit))
    }

    /// How far off the surface rays start that leave `hit` (scene units); 0 where they start on it.
    #[inline]
    pub fn step_off(&self, hit: &SurfaceHit) -> f64 {
        if hit.is_crowded { 0.0 } else { self.geometries[hit.geometry as usize].step_off(hit.primitive) }
    }

    /// [`World::spawn`] at a point of which [`World::step_off`] is known.
    #[inline]
    pub fn leave(&self, hit: &SurfaceHit, normal: DVec3, direction: DVec3, step_off: f64) -> Ray {
        if hit.is_crowded {
            return self.leave_crowd(hit, direction);
        }
        let off = if direction.dot(normal) < 0.0 { -normal } else { normal };
        Ray { side: self.side_of(hit.geometry), ..Ray::new(hit.point + off * step_off, direction) }
    }

    #[cold]
    fn leave_crowd(&self, hit: &SurfaceHit, direction: DVec3) -> Ray {
        let origin = self.geometries[hit.geometry as usize].inner_point(hit.primitive, hit.point, hit.barycentric);
        Ray { side: self.side_of(hit.geometry), leaving: Some(hit.primitive()), ..Ray::new(origin, direction) }
    }
}

/// A box around all surfaces; empty without any.
fn around(geometries: &[Geometry]) -> Aabb {
    geometries.iter().fold(Aabb::EMPTY, |b, g| b.union(g.bounds()))
}

/// How far single precision may move a point of a surface within `bounds`.
fn margin(bounds: &Aabb) -> f64 {
    if bounds.is_empty() { 0.0 } else { STEP_OFF * bounds.min.abs().max(bounds.max.abs()).max_element() }
}

/// The point `at(t)` of a segment, back on the surface from which rounding on a long way has moved it.
fn on_surface(surface: &dyn Analytic, segment: &Segment, t: f64) -> DVec3 {
    let point = segment.at(t);
    let way = segment.origin.abs().max_element().max(t.abs() * segment.direction.length());
    if way <= LONG_WAY * point.abs().max_element() {
        return point;
    }
    let (normal, half) = (surface.surface(point).normal, STRAY * way);
    let across = Segment { origin: point - normal * half, direction: normal, t_min: 0.0, t_max: 2.0 * half };
    surface.intersect(&across).map_or(point, |t| across.at(t))
}
