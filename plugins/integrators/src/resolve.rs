//! What becomes of what a chord meets: the place of the surface that the ray arrives at.
//!
//! **The chord decides what is seen, the orbit where.** The chords of neighbouring rays are shifted from their orbits by nearly the same small
//! distance, so a thing takes up as much of a picture as it should, however thin it is: the rays whose chord meets it and whose orbit
//! does not are as many as those whose orbit meets it and whose chord does not, and nobody looks for the latter. So what a
//! chord meets is kept. Where the orbit meets the same surface, the ray arrives there; where it does not (past the
//! edge of a facet or a silhouette), it arrives where the chord does. So it does, too, on a thing about as small as the gap, where the
//! orbit would meet another side of it: of the rays that the chords bring, orbits would leave only those on one side.
//!
//! Only the surface on which a ray begins or ends has no other side to make up for it: there the orbit decides.

use crate::chords::{Chords, JOINT, OVERLAP, Place, SPLITS, Span};
use crate::orbit::Dense;
use crate::refine::{Facet, Meeting, on_facet, on_surface};
use bhs_core::geometry::{Geometry, Segment};
use bhs_core::integrator::SurfaceHit;
use bhs_core::intersector::PrimitiveHit;
use crate::log::TraceLog;
use bhs_core::world::Located;
use glam::{DVec2, DVec3};

/// How far off the surface that it leaves a ray may begin along an axis, in steps off that surface: more than the root of 3.
const STEPS_OFF: f64 = 4.0;

/// Two places of a surface whose normals make an angle of a smaller cosine than this are not the same place seen by chord and orbit.
const SAME_WAY: f64 = 0.95;

/// Whether a surface faces quite another way where it has the unit normal `b` than where it has `a`.
fn turns(a: DVec3, b: DVec3) -> bool {
    a.dot(b) < SAME_WAY
}

impl Chords<'_> {
    /// The same when it is known already that the chord of `span` meets something, which is not as most hits are: `hit`, on its part `segment`,
    /// which begins at its parameter `enter`.
    pub(crate) fn settle<D: Dense>(
        &self,
        step: &D,
        span: &Span,
        (segment, enter, hit): (&Segment, f64, &PrimitiveHit),
        splits: u32,
        log: &mut TraceLog,
    ) -> Option<SurfaceHit> {
        let from = span.from.point;
        let way = segment.direction;
        let length = way.length();
        let located = self.world.locate(segment, hit);
        if enter + located.t < 0.0 && self.turns_away(span, way, hit, &located) {
            return self.search(step, &Span { before: None, ..*span }, splits, log);
        }
        let guess = self.angle_of(span, located.point);
        let middle = 0.5 * (span.from.phi + span.to.phi);
        let swept = span.to.phi - span.from.phi;
        let rounding = OVERLAP * located.point.abs().max_element();
        let near = self.near(swept, rounding);
        let hit_geometry = &self.world.geometries[hit.geometry as usize];
        let facet = |corners| on_facet(&self.plane, step, self.rs, [&span.from, &span.to], guess, &Facet::new(corners));
        let meeting = match hit_geometry {
            Geometry::Analytic(surface) => on_surface(&self.plane, step, guess, &**surface, near, length),
            mesh => mesh.corners(hit.primitive).map(facet),
        };
        // Of a ray that leaves a curved surface, the tangent's way back leads to where it left: no place of the ray.
        let meeting = meeting.filter(|m| m.orbit.state.phi > self.begin || !matches!(hit_geometry, Geometry::Analytic(_)));
        // Where to split the chord if the orbit meets the surface beside the facet or far from the chord. Where it crosses the
        // surface is best, for there the new chords have no gap; but every other time in the middle, lest it creep. A joint
        // must not lie on a surface that it may graze, or rounding lets the ray slip through there: hence just behind it.
        let behind_it =
            meeting.map(|m| m.orbit.state.phi + JOINT * swept).filter(|phi| *phi > span.from.phi && *phi < span.to.phi);
        let split = behind_it.filter(|_| splits.is_multiple_of(2)).unwrap_or(middle);
        let met = meeting.filter(|m| m.beside <= rounding && (m.point - located.point).length() <= near);
        if met.is_none() && splits > 0 {
            let s = step.at(split);
            let at = Place { phi: split, u: s.u, point: self.plane.point(&s) };
            let first = Span { to: at, ..*span };
            let second = Span { from: at, before: Some(at.point - from), ..*span };
            let finer = self.search(step, &first, splits - 1, log).or_else(|| self.search(step, &second, splits - 1, log));
            if splits < SPLITS || self.is_overruled(hit, &located, finer.as_ref(), span, near) {
                return finer;
            }
        }
        if met.is_none()
            && splits == 0
            && span.before.is_none()
            && let Some(after) = self.rises_again(step, span, hit, segment, &located)
        {
            return self.search(step, &Span { from: after, before: None, ..*span }, 0, log);
        }
        // Much of a thing that is about as small as the gap would not be met by any orbit.
        let met = met.filter(|m| splits < SPLITS || !self.is_elsewhere(hit, &located, m));
        let on_chord =
            || Meeting { orbit: step.polar(guess), point: located.point, barycentric: located.barycentric, beside: 0.0 };
        Some(self.arrive(&met.unwrap_or_else(on_chord), hit, &located, way / length, log))
    }

    /// Whether the orbit meets an analytic surface where it faces quite another way than where the chord met it.
    fn is_elsewhere(&self, hit: &PrimitiveHit, located: &Located, met: &Meeting) -> bool {
        let Geometry::Analytic(surface) = &self.world.geometries[hit.geometry as usize] else { return false };
        turns(surface.surface(located.point).normal, surface.surface(met.point).normal)
    }

    /// Whether what the chord of `span` met where it is `located` gives way to what its parts met, `finer`: another place of the same surface; or
    /// whatever they met, if the chord grazes the surface on which the ray begins or ends, or met it behind the horizon.
    fn is_overruled(&self, hit: &PrimitiveHit, located: &Located, finer: Option<&SurfaceHit>, span: &Span, near: f64) -> bool {
        let normal =
            self.world.geometries[hit.geometry as usize].surface(located.point, hit.primitive, located.barycentric).normal;
        let is_same_surface = |found: &SurfaceHit| {
            let is_level = || normal.dot(found.point - located.point).abs() <= near;
            found.geometry == hit.geometry
                && (found.primitive == hit.primitive || is_level())
                && !turns(normal, self.world.surface(found).normal)
        };
        // A chord between points of an orbit that stays on one side of a surface dips below it by less than the gap: it meets it
        // at no steeper an angle than orbit and chord make, that is by four gaps over the length of the chord.
        let grazes = || normal.dot(span.to.point - span.from.point).abs() <= 2.0 * near;
        let ends_on = || self.target == Some(hit.geometry);
        finer.is_some_and(is_same_surface)
            || (grazes() && (ends_on() || self.begins_on(hit)))
            || (located.point - self.plane.center).length() <= self.rs
    }

    /// Whether the ray begins on the geometry of `hit`, or just off it.
    #[cold]
    fn begins_on(&self, hit: &PrimitiveHit) -> bool {
        if let Some(leaving) = self.leaving {
            return leaving.primitive.geometry == hit.geometry;
        }
        // One of the axes meets what is just under the origin at an angle of no more than 55 degrees from its normal.
        let reach = STEPS_OFF * self.world.geometries[hit.geometry as usize].step_off(hit.primitive);
        DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).any(|direction| {
            let segment = Segment { origin: self.origin, direction, t_min: 0.0, t_max: reach };
            self.world.intersector.closest(&segment).is_some_and(|under| under.geometry == hit.geometry)
        })
    }

    /// The hit of a chord on a facet, if it is as most are: ahead of where the chord begins, near to where the orbit meets the facet itself.
    #[inline]
    pub(crate) fn plain_hit<D: Dense>(
        &self,
        step: &D,
        span: &Span,
        segment: &Segment,
        enter: f64,
        hit: &PrimitiveHit,
        log: &mut TraceLog,
    ) -> Option<SurfaceHit> {
        let corners = self.world.geometries[hit.geometry as usize].corners(hit.primitive)?;
        let touched = segment.at(hit.t);
        let rounding = OVERLAP * touched.abs().max_element();
        let swept = span.to.phi - span.from.phi;
        let chord = segment.direction;
        let ahead = enter + hit.t;
        if ahead * ahead * chord.length_squared() <= rounding * rounding || ahead < 0.0 {
            return None;
        }
        let facet = Facet::new(corners);
        let met = on_facet(&self.plane, step, self.rs, [&span.from, &span.to], self.angle_of(span, touched), &facet);
        let near = self.near(swept, rounding);
        if met.beside > rounding || (met.point - touched).length_squared() > near * near {
            return None;
        }
        log.phi = met.orbit.state.phi;
        let tangent = self.plane.direction_of(&met.orbit);
        // On the side that the chord came from: see `arrive`.
        let along = tangent.dot(facet.normal);
        let on_side = along * chord.dot(facet.normal) > 0.0;
        let direction = if on_side { tangent } else { tangent - facet.normal * (2.0 * along / facet.normal.length_squared()) };
        let &PrimitiveHit { geometry, primitive, .. } = hit;
        let is_crowded = self.world.intersector.is_crowded(met.point);
        Some(SurfaceHit { point: met.point, direction, geometry, primitive, barycentric: met.barycentric, is_crowded })
    }

    /// How far from where its chord, which sweeps `swept`, meets a surface an orbit may meet it.
    #[inline]
    fn near(&self, swept: f64, rounding: f64) -> f64 {
        4.0 * (3.0 / 16.0 * self.rs * swept * swept) + rounding
    }

    /// Where the ray is when its chord, which dipped below the curved surface that the ray leaves, has come out of it again.
    fn rises_again<D: Dense>(
        &self,
        step: &D,
        span: &Span,
        hit: &PrimitiveHit,
        segment: &Segment,
        located: &Located,
    ) -> Option<Place> {
        let Geometry::Analytic(surface) = &self.world.geometries[hit.geometry as usize] else { return None };
        let rounding = OVERLAP * located.point.abs().max_element() / segment.direction.length();
        let out = surface.intersect(&Segment { t_min: located.t + rounding, ..*segment })?;
        let phi = self.angle_of(span, segment.at(out));
        let s = step.at(phi.max(span.from.phi));
        (phi < span.to.phi).then(|| Place { phi: s.phi, u: s.u, point: self.plane.point(&s) })
    }

    /// Whether a surface that the chord `way` meets before its own beginning is one that the chord before approached without
    /// reaching it, and that this one leaves: the ray has not been on its other side.
    fn turns_away(&self, span: &Span, way: DVec3, hit: &PrimitiveHit, located: &Located) -> bool {
        let Some(before) = span.before else { return false };
        let (geometry, primitive) = (hit.geometry, hit.primitive);
        let (point, barycentric) = (located.point, located.barycentric);
        let normal = self.world.geometries[geometry as usize].surface(point, primitive, barycentric).normal;
        before.dot(normal) * way.dot(normal) <= 0.0
    }

    /// The arrival at a surface that a chord in the direction `chord` met where it is `located`.
    pub(crate) fn arrive(
        &self,
        met: &Meeting,
        hit: &PrimitiveHit,
        located: &Located,
        chord: DVec3,
        log: &mut TraceLog,
    ) -> SurfaceHit {
        log.phi = met.orbit.state.phi;
        let at = |point: DVec3, direction: DVec3, barycentric: DVec2| SurfaceHit {
            point,
            direction,
            geometry: hit.geometry,
            primitive: hit.primitive,
            barycentric,
            is_crowded: self.world.intersector.is_crowded(point),
        };
        // The side that the chord came from: where it met the surface, for a curved one may have turned away between there and here.
        let side = self.world.surface(&at(located.point, chord, located.barycentric)).normal.dot(chord);
        let tangent = self.plane.direction_of(&met.orbit);
        let found = at(met.point, tangent, met.barycentric);
        let normal = self.world.surface(&found).normal;
        let along = tangent.dot(normal);
        // A tangent that would arrive from the other side does so at grazing incidence: it is turned to this side.
        if along * side > 0.0 { found } else { SurfaceHit { direction: tangent - normal * (2.0 * along), ..found } }
    }
}
