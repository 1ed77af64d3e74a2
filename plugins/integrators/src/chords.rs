//! From stretches of an orbit to hits on surfaces: chords and their intersection. Knows no differential equation.
//!
//! The chord between two points of an orbit `dphi` apart strays from it by at most about `(3/16) rs dphi^2`, whatever r and b
//! are: equal steps in phi make equal errors. What a chord meets, the orbit meets nearby ([`crate::refine`]): where exactly, is
//! solved for; and where the orbit turns out to meet that surface far from the chord, or beside the facet, the chord is
//! split and the question put again. So a ray that leaves a surface at grazing incidence does not end on it because
//! its first chord dips below, and a hit near the edge of a facet ends on the facet that the orbit meets.
//!
//! Where no surface is near ([`bhs_core::clearance`]) the orbit leaps: a stretch that stays within free space needs no question,
//! however far its chord strays.

use crate::arithmetic::polynomial::small_angle;
use crate::orbit::{Dense, OrbitPlane, State};
use crate::refine::Meeting;
use bhs_core::blackhole::BlackHole;
use bhs_core::geometry::{Aabb, Segment};
use bhs_core::integrator::SurfaceHit;
use bhs_core::intersector::Primitive;
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// How far a chord reaches beyond its ends, relative to the coordinates there: neighbouring chords overlap by more than
/// single precision can tear them apart. Also how far beside its facet a hit may lie, for the same reason.
pub(crate) const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// How many times a chord is split at most: then what it meets counts, wrong by no more than the gap between chord and orbit.
pub(crate) const SPLITS: u32 = 6;

/// How far behind a surface a chord is split, relative to its angle.
pub(crate) const JOINT: f64 = 1e-3;

/// Free space is passed over if that gets on by as much as this share of a chord.
pub(crate) const WORTHWHILE: f64 = 0.5;

/// How far outside of the sphere around all geometry the chord that leaves it may end: least radius over distance.
pub(crate) const NEARBY: f64 = 0.125;

/// Far more than the rounding of a length, relative to it.
pub(crate) const ROUNDING: f64 = 1e-6;

/// How often the first chord of a ray that leaves a surface is halved at most to be on the right side of that.
const MOST_HALVINGS: u32 = 60;

/// Longest chord, in radians, however much it may stray.
pub(crate) const LONGEST: f64 = 1.5;

/// The angle of a chord that strays from its orbit by no more than `distance`, in radians.
///
/// A chord solves `u'' + u = 0`, so that its gap in u grows by `(3/2) rs u^2`: to `(3/2) rs u^2 (1/cos(dphi/2) - 1)` in its middle
/// where r does not change much, which is `(3/2) rs (1/cos(dphi/2) - 1)` in r; and where r does change, the gap across the ray is less.
pub fn chord_angle(rs: f64, distance: f64) -> f64 {
    let x = distance / (1.5 * rs);
    // 1/cos = 1 + x, by the tangent, which keeps its digits for small x.
    let half = small_angle((x * (2.0 + x)).sqrt(), 1.0);
    (2.0 * half).clamp(1e-5, LONGEST)
}

/// A point of an orbit.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Angle swept, in radians.
    pub phi: f64,
    /// 1/r.
    pub u: f64,
    /// The point.
    pub point: DVec3,
}

/// The stretch between two places of an orbit.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    pub from: Place,
    pub to: Place,
    /// The chord before it; `None` if it begins where the ray does, maybe just off a surface.
    pub before: Option<DVec3>,
}

/// A box around all surfaces with room for rounding, and 1/r of the sphere around the hole that holds all geometry: infinite where there
/// is none.
pub(crate) fn surroundings(world: &World) -> (Aabb, f64) {
    let World { margin, reach, .. } = *world;
    (world.bounds.grown(margin), if reach > 0.0 { 1.0 / (reach + margin) } else { f64::INFINITY })
}

/// The chords of one orbit through one world.
pub struct Chords<'w> {
    pub(crate) world: &'w World,
    pub(crate) plane: OrbitPlane,
    pub(crate) rs: f64,
    /// Largest angle of a chord, in radians.
    angle: f64,
    bounds: Aabb,
    /// 1/r of the sphere around the hole that holds all geometry; infinite where there is none.
    u_bound: f64,
    /// Angle at which the ray begins, in radians.
    pub(crate) begin: f64,
    /// The place where it begins.
    pub(crate) origin: DVec3,
    /// Where the next chord begins.
    last: Place,
    /// The last chord; `None` where the ray begins.
    before: Option<DVec3>,
    /// What the ray leaves, if it begins exactly on a surface.
    pub(crate) leaving: Option<Departure>,
    /// The geometry on which it ends, if it does.
    pub(crate) target: Option<u32>,
    /// Where the first chord was cut, if it was (rad): see [`Chords::off_surface`].
    cut: f64,
}

/// How a ray leaves the surface on which it begins.
#[derive(Clone, Copy)]
pub(crate) struct Departure {
    pub primitive: Primitive,
    /// A normal of the surface, on the side to which the ray goes.
    side: DVec3,
}

impl<'w> Chords<'w> {
    /// The chords, of at most the angle `angle`, of the orbit in `plane` that begins at `origin` with the state `start`.
    pub fn new(world: &'w World, hole: &BlackHole, plane: OrbitPlane, origin: DVec3, start: &State, angle: f64) -> Self {
        let last = Place { phi: start.phi, u: start.u, point: origin };
        Self { begin: start.phi, ..Self::on(world, hole.rs, plane, angle, last, None) }
    }

    /// The chords of an orbit around a hole of radius `rs` that began at the angle 0, from `last` on, which the chord `before` led to unless
    /// the ray begins there.
    pub(crate) fn on(world: &'w World, rs: f64, plane: OrbitPlane, angle: f64, last: Place, before: Option<DVec3>) -> Self {
        let (bounds, u_bound) = surroundings(world);
        Self {
            world,
            plane,
            rs,
            angle,
            bounds,
            u_bound,
            begin: 0.0,
            origin: last.point,
            last,
            before,
            leaving: None,
            target: None,
            cut: f64::NAN,
        }
    }

    /// The same, if the ray begins exactly on the surface of `leaving` and goes in the direction `launch`.
    pub fn leaving(self, leaving: Option<Primitive>, launch: DVec3) -> Self {
        let departure = |primitive: Primitive| {
            let normal = self.world.geometries[primitive.geometry as usize].normal(primitive.primitive, self.last.point);
            Departure { primitive, side: normal * launch.dot(normal).signum() }
        };
        Self { leaving: leaving.map(departure), ..self }
    }

    /// The same, of a ray that begins at `origin` and ends on the geometry `target`, if on any.
    pub(crate) fn between(self, origin: DVec3, target: Option<u32>) -> Self {
        Self { origin, target, ..self }
    }

    /// Where the last chord ended.
    pub fn last(&self) -> DVec3 {
        self.last.point
    }

    /// The first surface that the orbit meets on `step`, which continues the step before.
    pub fn meet<D: Dense>(&mut self, step: &D, log: &mut TraceLog) -> Option<SurfaceHit> {
        let (start, end) = (step.start(), step.end());
        // Outside of everything and on the way out, where no orbit turns back.
        let gone = start.u <= self.u_bound && start.du <= 0.0 && 1.5 * self.rs * start.u <= 1.0;
        if gone || self.u_bound == f64::INFINITY {
            return None;
        }
        let mut phi = start.phi;
        // Distance covered per radian on the last stretch.
        let mut pace = None;
        while phi < end.phi {
            let from = self.last;
            if from.u <= 0.0 {
                return None;
            }
            if let Some(to) = self.leap(step, &from, end.phi, pace) {
                pace = Some((to.point - from.point).length() / (to.phi - from.phi));
                self.before = Some(to.point - from.point);
                (self.last, phi) = (to, to.phi);
                log.counters.leaps += 1;
                self.draw(step, &from, &to, log);
                continue;
            }
            // Chords of equal angle to the end of the step.
            let left = ((end.phi - phi) / self.angle).ceil();
            let to = if left > 1.0 { self.place(step, phi + (end.phi - phi) / left) } else { self.at_end(&end) };
            // A chord that leaves the sphere around all geometry ends not far from there: it may go on to infinity.
            let until = if from.u > self.u_bound && to.u < NEARBY * self.u_bound { self.nearby(step, &from, to) } else { to };
            let cut = if from.phi == self.begin { self.off_surface(step, &from, &until) } else { None };
            self.last = cut.unwrap_or(to);
            self.cut = cut.map_or(self.cut, |cut| cut.phi);
            phi = self.last.phi;
            let to = cut.unwrap_or(until);
            if to.u <= 0.0 {
                return None;
            }
            pace = Some((to.point - from.point).length() / (to.phi - from.phi));
            let before = self.before.replace(to.point - from.point);
            let hit = self.search(step, &Span { from, to, before }, SPLITS, log);
            log.point(hit.map_or(to.point, |h| h.point));
            if hit.is_some() {
                return hit;
            }
        }
        None
    }

    /// Where to cut the first chord, that from `from` to `to`, if the orbit is not there on that side of the surface that it leaves to which
    /// it set out. So that surface is not in the chord's way, and where the orbit comes back to it, a later chord meets it.
    fn off_surface<D: Dense>(&self, step: &D, from: &Place, to: &Place) -> Option<Place> {
        let side = self.leaving?.side;
        let is_on_side = |place: &Place| side.dot(place.point - from.point) > 0.0;
        if is_on_side(to) {
            return None;
        }
        let mut swept = to.phi - from.phi;
        for _ in 0..MOST_HALVINGS {
            swept *= 0.5;
            let place = self.place(step, from.phi + swept);
            if is_on_side(&place) {
                return Some(place);
            }
        }
        None
    }

    /// Notes the points of a stretch that is passed over, as chords would divide it, if somebody wants them.
    fn draw<D: Dense>(&self, step: &D, from: &Place, to: &Place, log: &mut TraceLog) {
        if log.polyline.is_some() {
            let count = ((to.phi - from.phi) / self.angle).ceil();
            for k in 1..count as u64 {
                log.point(self.place(step, from.phi + (to.phi - from.phi) * k as f64 / count).point);
            }
            log.point(to.point);
        }
    }

    /// The end of a stretch from the place `from`, no farther than the angle `end`, that nothing is near to; `None` if that would
    /// be shorter than a chord.
    ///
    /// The stretch strays from its chord by less than the gap, which is twice what it is expected to be; so it lies within a ball
    /// around the chord's middle, and is free if nothing is known to be in there. How far it may be is guessed from the
    /// free space around its beginning.
    #[inline]
    fn leap<D: Dense>(&self, step: &D, from: &Place, end: f64, pace: Option<f64>) -> Option<Place> {
        let clearance = self.world.clearance.as_ref()?;
        let around = clearance.at(from.point);
        if around <= 0.0 {
            return None;
        }
        // Of the first stretch of a step, the pace where it begins.
        let pace = pace.unwrap_or_else(|| {
            let State { u, du, .. } = step.start();
            (u * u + du * du).sqrt() / (u * u)
        });
        let least = WORTHWHILE * self.angle.min(end - from.phi);
        let mut angle = (2.0 * around / pace).min(LONGEST);
        for _ in 0..2 {
            let phi = if from.phi + angle < end { from.phi + angle } else { end };
            let swept = phi - from.phi;
            if swept < least {
                return None;
            }
            let to = self.place(step, phi);
            let chord = to.point - from.point;
            // A little more, lest rounding let a long stretch begin within the surfaces and its middle be as far from them as that.
            let needed = (0.5 + ROUNDING) * chord.length() + 3.0 / 8.0 * self.rs * swept * swept;
            if to.u > 0.0 && needed <= clearance.at(from.point + 0.5 * chord) {
                return Some(to);
            }
            angle = 0.5 * swept;
        }
        None
    }

    /// The place at the angle `phi` of `step`.
    fn place<D: Dense>(&self, step: &D, phi: f64) -> Place {
        let (u, cos, sin) = step.place(phi);
        let r = 1.0 / u;
        Place { phi, u, point: self.plane.center + self.plane.e1 * (cos * r) + self.plane.e2 * (sin * r) }
    }

    /// The place of the state `end`.
    fn at_end(&self, end: &State) -> Place {
        Place { phi: end.phi, u: end.u, point: self.plane.point(end) }
    }

    /// A place between `from`, within the sphere around all geometry, and `to`, far outside of it or beyond infinity: outside, but
    /// not far.
    pub(crate) fn nearby<D: Dense>(&self, step: &D, from: &Place, to: Place) -> Place {
        let (mut inside, mut outside) = (*from, to);
        // Where a straight line would have it, and half way there if the orbit does not.
        for attempt in 0..60 {
            let wanted = if attempt % 2 == 0 { 0.5 * (1.0 + NEARBY) * self.u_bound } else { 0.5 * (inside.u + outside.u) };
            let share = ((inside.u - wanted) / (inside.u - outside.u)).clamp(0.01, 0.99);
            let between = self.place(step, inside.phi + share * (outside.phi - inside.phi));
            if between.u > self.u_bound {
                inside = between;
            } else if between.u < NEARBY * self.u_bound {
                outside = between;
            } else {
                return between;
            }
        }
        let state = |p: &Place| State { phi: p.phi, u: p.u, du: 0.0 };
        self.at_end(&step.crossing(state(from), state(&to), self.u_bound))
    }

    /// The first surface that the orbit meets within `span`, splitting its chord as often as needed but at most `splits` times.
    pub(crate) fn search<D: Dense>(&self, step: &D, span: &Span, splits: u32, log: &mut TraceLog) -> Option<SurfaceHit> {
        let (from, to) = (span.from.point, span.to.point);
        let way = to - from;
        let length = way.length();
        if length == 0.0 {
            return None;
        }
        // Overlap with the chord before: but the first one begins where the ray does, off the surface that it leaves.
        let overlap = |p: DVec3| OVERLAP * p.abs().max_element() / length;
        let (t_min, t_max) = (if span.before.is_none() { 0.0 } else { -overlap(from) }, 1.0 + overlap(to));
        // What a chord within the box reaches beyond its ends is of no account to the box.
        let within = self.bounds.contains(from) && self.bounds.contains(to);
        let Some((enter, leave)) = (if within { Some((t_min, t_max)) } else { self.bounds.clip(from, way, t_min, t_max) }) else {
            log.counters.chords_skipped += 1;
            return None;
        };
        log.counters.queries += 1;
        let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
        // Only the chord on which the ray begins leaves anything; the next may begin as near to the surface.
        let leaving = self.leaving.filter(|_| span.before.is_none() && span.from.phi == self.begin && enter == 0.0);
        let intersector = &self.world.intersector;
        let hit = match leaving {
            Some(leaving) => intersector.closest_from(&segment, Some(leaving.primitive)),
            None if span.from.phi == self.cut => intersector.closest_from(&segment, None),
            None => intersector.closest(&segment),
        }?;
        if leaving.is_some() {
            // As near as this to where the ray begins its chord strays from it by less than rounding.
            let located = self.world.locate(&segment, &hit);
            if located.t * length <= OVERLAP * from.abs().max_element() {
                let orbit = step.polar(self.angle_of(span, located.point));
                let met = Meeting { orbit, point: located.point, barycentric: located.barycentric, beside: 0.0 };
                return Some(self.arrive(&met, &hit, &located, way / length, log));
            }
        }
        self.plain_hit(step, span, &segment, enter, &hit, log)
            .or_else(|| self.settle(step, span, (&segment, enter, &hit), splits, log))
    }

    /// The angle swept at a point of the chord of `span`, in radians.
    #[inline]
    pub(crate) fn angle_of(&self, span: &Span, point: DVec3) -> f64 {
        let OrbitPlane { center, e1, e2 } = self.plane;
        let (from, to) = (span.from.point - center, point - center);
        let ([x0, y0], [x, y]) = ([from.dot(e1), from.dot(e2)], [to.dot(e1), to.dot(e2)]);
        span.from.phi + small_angle(x0 * y - y0 * x, x0 * x + y0 * y)
    }
}
