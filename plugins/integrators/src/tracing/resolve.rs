//! What becomes of what a chord meets: the place of the surface that the ray arrives at.
//!
//! **The chord decides what is seen, the curve where.** The chords of neighbouring rays are shifted from their curves by nearly the same small
//! distance, so a thing takes up as much of a picture as it should, however thin it is: the rays whose chord meets it and whose curve
//! does not are as many as those whose curve meets it and whose chord does not, and nobody looks for the latter. So what a
//! chord meets is kept. Where the curve meets the same surface, the ray arrives there; where it does not (past the
//! edge of a facet or a silhouette), it arrives where the chord does. So it does, too, on a thing about as small as the gap, where the
//! curve would meet another side of it: of the rays that the chords bring, curves would leave only those on one side.
//!
//! Only the surface on which a ray begins or ends has no other side to make up for it: there the curve decides.

use crate::tracing::arc::Arc;
use crate::tracing::departure::Departure;
use crate::tracing::meeting::{Meeting, on_facet, on_surface};
use crate::tracing::places::CurvePoint;
use crate::tracing::surfaces::{OVERLAP, Surfaces};
use bhs_core::geometry::{Geometry, Segment};
use bhs_core::intersector::PrimitiveHit;
use bhs_core::ray::{Cost, Ray, SurfaceHit};
use bhs_engine::world::{Located, World};
use glam::DVec3;

/// How many times a chord is split at most: then what it meets counts, wrong by no more than the gap between chord and curve.
const SPLITS: u32 = 6;

/// How far behind a surface a chord is split, relative to its length in the parameter.
const JOINT: f64 = 1e-3;

/// How far off the surface that it leaves a ray may begin along an axis, in steps off that surface: more than the root of 3.
const STEPS_OFF: f64 = 4.0;

/// Two places of a surface whose normals make an angle of a smaller cosine than this are not the same place seen by chord and curve.
const SAME_WAY: f64 = 0.95;

/// Whether a surface faces quite another way where it has the unit normal `b` than where it has `a`.
fn turns(a: DVec3, b: DVec3) -> bool {
    a.dot(b) < SAME_WAY
}

/// A chord of one ray.
#[derive(Clone, Copy)]
pub(crate) struct Chord {
    pub from: CurvePoint,
    pub to: CurvePoint,
    /// The chord before it; `None` if it begins where the ray does, maybe just off a surface, or comes to this side.
    pub before: Option<DVec3>,
}

impl Chord {
    fn way(&self) -> DVec3 {
        self.to.point - self.from.point
    }

    fn length_of_parameter(&self) -> f64 {
        self.to.s - self.from.s
    }
}

/// A part of a chord, the chord's parameter where it begins, and what it meets.
type MetBy<'a> = (&'a Segment, f64, &'a PrimitiveHit);

/// One ray on one piece of its curve.
#[derive(Clone, Copy)]
pub(crate) struct One<'a, A> {
    pub world: &'a World,
    pub surfaces: &'a Surfaces<'a>,
    pub piece: &'a A,
    pub ray: &'a Ray,
    /// The geometry on which it ends, if it does.
    pub target: Option<u32>,
    /// How it leaves the surface on which it begins, if it does so exactly and is still on that side.
    pub departure: Option<&'a Departure>,
    /// The parameter where the piece ends on the throat, if it does.
    pub ends_at_throat: Option<f64>,
}

impl<A: Arc<f64>> One<'_, A> {
    /// The first surface that the curve meets along `chord`, which is split as often as needed but at most `splits` times; and the parameter there.
    fn search(&self, chord: &Chord, splits: u32, cost: &mut Cost) -> Option<(SurfaceHit, f64)> {
        let (from, to) = (chord.from.point, chord.to.point);
        let way = to - from;
        let length = way.length();
        if length == 0.0 {
            return None;
        }
        // Overlap with the chord before: but the first one begins where the ray does, off the surface that it leaves.
        let overlap = |p: DVec3| OVERLAP * p.abs().max_element() / length;
        let t_min = if chord.before.is_none() { 0.0 } else { -overlap(from) };
        let t_max = if self.ends_at_throat == Some(chord.to.s) { 1.0 } else { 1.0 + overlap(to) };
        // What a chord within the box reaches beyond its ends is of no account to the box.
        let bounds = &self.surfaces.bounds;
        let within = bounds.contains(from) && bounds.contains(to);
        let Some((enter, leave)) = (if within { Some((t_min, t_max)) } else { bounds.clip(from, way, t_min, t_max) }) else {
            cost.chords_skipped += 1;
            return None;
        };
        cost.queries += 1;
        let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
        let half = &self.surfaces.half;
        let hit = match self.departure {
            Some(departure) if chord.before.is_none() && enter == 0.0 => half.closest_from(&segment, Some(departure.primitive)),
            Some(departure) if departure.cut == Some(chord.from.s) => half.closest_from(&segment, None),
            _ => half.closest(&segment, None),
        }?;
        self.resolve(chord, (&segment, enter, &hit), splits, cost)
    }

    /// Where the ray arrives if its `chord` meets something: `hit`, on its part `segment`, which begins at its parameter `enter`; and the parameter
    /// of the curve there. `None` if it meets nothing on this chord after all.
    pub(crate) fn resolve_hit(&self, chord: &Chord, met: MetBy<'_>, cost: &mut Cost) -> Option<(SurfaceHit, f64)> {
        self.resolve(chord, met, SPLITS, cost)
    }

    fn resolve(
        &self,
        chord: &Chord,
        (segment, enter, hit): MetBy<'_>,
        splits: u32,
        cost: &mut Cost,
    ) -> Option<(SurfaceHit, f64)> {
        let (from, way) = (chord.from.point, segment.direction);
        let length = way.length();
        let located = self.world.locate(segment, hit);
        if self.departure.is_some()
            && chord.before.is_none()
            && enter == 0.0
            && located.t * length <= OVERLAP * from.abs().max_element()
        {
            // As near as this to where the ray begins its chord strays from it by less than rounding.
            let parameter = self.beside(chord, located.point);
            let met = Meeting { parameter, point: located.point, barycentric: located.barycentric, beside: 0.0 };
            return Some(self.arrive(&met, hit, &located, way / length));
        }
        if enter + located.t < 0.0 && self.turns_away(chord, way, hit, &located) {
            return self.search(&Chord { before: None, ..*chord }, splits, cost);
        }
        let guess = self.beside(chord, located.point);
        let ends = [chord.from.s, chord.to.s];
        let middle = 0.5 * (ends[0] + ends[1]);
        let swept = chord.length_of_parameter();
        let rounding = OVERLAP * located.point.abs().max_element();
        let near = 4.0 * self.piece.gap(ends[0], ends[1]) + rounding;
        let hit_geometry = &self.world.geometries[hit.geometry as usize];
        let meeting = match hit_geometry {
            // Of a ray that leaves a curved surface, the tangent's way back leads to where it left: no place of the ray.
            Geometry::Analytic(surface) => {
                on_surface(self.piece, ends, guess, &**surface, near.min(length), length).filter(|m| m.parameter > 0.0)
            }
            mesh => mesh.corners(hit.primitive).and_then(|corners| on_facet(self.piece, ends, guess, corners)),
        };
        // Where to split the chord if the curve meets the surface beside the facet or far from the chord. Where it crosses the
        // surface is best, for there the new chords have no gap; but every other time in the middle, lest it creep. A joint
        // must not lie on a surface that it may graze, or rounding lets the ray slip through there: hence just behind it.
        let behind_it = meeting.map(|m| m.parameter + JOINT * swept).filter(|s| *s > ends[0] && *s < ends[1]);
        let split = behind_it.filter(|_| splits.is_multiple_of(2)).unwrap_or(middle);
        let met = meeting.filter(|m| m.beside <= rounding && (m.point - located.point).length() <= near);
        if met.is_none() && splits > 0 {
            let at = CurvePoint { s: split, point: self.piece.point(split).into() };
            let first = Chord { to: at, ..*chord };
            let second = Chord { from: at, before: Some(at.point - from), ..*chord };
            let finer = self.search(&first, splits - 1, cost).or_else(|| self.search(&second, splits - 1, cost));
            if splits < SPLITS || self.is_overruled(hit, &located, finer.as_ref().map(|f| &f.0), chord, near) {
                return finer;
            }
        }
        if met.is_none()
            && splits == 0
            && chord.before.is_none()
            && let Some(after) = self.rises_again(chord, hit, segment, &located)
        {
            return self.search(&Chord { from: after, before: None, ..*chord }, 0, cost);
        }
        // Much of a thing that is about as small as the gap would not be met by any curve.
        let met = met.filter(|m| splits < SPLITS || !self.is_elsewhere(hit, &located, m));
        let on_chord = || Meeting { parameter: guess, point: located.point, barycentric: located.barycentric, beside: 0.0 };
        Some(self.arrive(&met.unwrap_or_else(on_chord), hit, &located, way / length))
    }

    /// About the parameter of the curve beside a point of its chord.
    fn beside(&self, chord: &Chord, point: DVec3) -> f64 {
        let way = chord.way();
        let share = (way.dot(point - chord.from.point) / way.length_squared()).clamp(0.0, 1.0);
        self.piece.beside([chord.from.s, chord.to.s], [chord.from.point.into(), chord.to.point.into()], share)
    }

    /// Whether the curve meets an analytic surface where it faces quite another way than where the chord met it.
    fn is_elsewhere(&self, hit: &PrimitiveHit, located: &Located, met: &Meeting) -> bool {
        let Geometry::Analytic(surface) = &self.world.geometries[hit.geometry as usize] else { return false };
        turns(surface.surface(located.point).normal, surface.surface(met.point).normal)
    }

    /// Whether what the chord of `span` met where it is `located` gives way to what its parts met, `finer`: another place of the same surface; or
    /// whatever they met, if the chord grazes the surface on which the ray begins or ends, or met it behind the horizon.
    fn is_overruled(&self, hit: &PrimitiveHit, located: &Located, finer: Option<&SurfaceHit>, chord: &Chord, near: f64) -> bool {
        let normal =
            self.world.geometries[hit.geometry as usize].surface(located.point, hit.primitive, located.barycentric).normal;
        let is_same_surface = |found: &SurfaceHit| {
            let is_level = || normal.dot(found.point - located.point).abs() <= near;
            found.geometry == hit.geometry
                && (found.primitive == hit.primitive || is_level())
                && !turns(normal, self.world.surface(found).normal)
        };
        // A chord between points of an curve that stays on one side of a surface dips below it by less than the gap: it meets it
        // at no steeper an angle than curve and chord make, that is by four gaps over the length of the chord.
        let grazes = || normal.dot(chord.way()).abs() <= 2.0 * near;
        let ends_on = || self.target == Some(hit.geometry);
        finer.is_some_and(is_same_surface)
            || (grazes() && (ends_on() || self.begins_on(hit)))
            || self.piece.is_nowhere(located.point)
    }

    /// Whether the ray begins on the geometry of `hit`, or just off it.
    #[cold]
    fn begins_on(&self, hit: &PrimitiveHit) -> bool {
        if let Some(leaving) = self.ray.leaving {
            return leaving.geometry == hit.geometry;
        }
        // One of the axes meets what is just under the origin at an angle of no more than 55 degrees from its normal.
        let reach = STEPS_OFF * self.world.geometries[hit.geometry as usize].step_off(hit.primitive);
        DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).any(|direction| {
            let segment = Segment { origin: self.ray.origin, direction, t_min: 0.0, t_max: reach };
            self.surfaces.half.closest(&segment, None).is_some_and(|under| under.geometry == hit.geometry)
        })
    }

    /// Where the ray is when its chord, which dipped below the curved surface that the ray leaves, has come out of it again.
    fn rises_again(&self, chord: &Chord, hit: &PrimitiveHit, segment: &Segment, located: &Located) -> Option<CurvePoint> {
        let Geometry::Analytic(surface) = &self.world.geometries[hit.geometry as usize] else { return None };
        let rounding = OVERLAP * located.point.abs().max_element() / segment.direction.length();
        let out = surface.intersect(&Segment { t_min: located.t + rounding, ..*segment })?;
        let s = self.beside(chord, segment.at(out));
        (s < chord.to.s).then(|| CurvePoint { s, point: self.piece.point(s).into() })
    }

    /// Whether a surface that the chord `way` meets before its own beginning is one that the chord before approached without
    /// reaching it, and that this one leaves: the ray has not been on its other side.
    fn turns_away(&self, chord: &Chord, way: DVec3, hit: &PrimitiveHit, located: &Located) -> bool {
        let Some(before) = chord.before else { return false };
        let surface = &self.world.geometries[hit.geometry as usize];
        let normal = surface.surface(located.point, hit.primitive, located.barycentric).normal;
        before.dot(normal) * way.dot(normal) <= 0.0
    }

    /// The arrival at a surface that a chord in the direction `chord` met where it is `located`; and the parameter there.
    fn arrive(&self, met: &Meeting, hit: &PrimitiveHit, located: &Located, chord: DVec3) -> (SurfaceHit, f64) {
        let surface = &self.world.geometries[hit.geometry as usize];
        // The side that the chord came from: where it met the surface, for a curved one may have turned away between there and here.
        let side = surface.surface(located.point, hit.primitive, located.barycentric).normal.dot(chord);
        let normal = surface.surface(met.point, hit.primitive, met.barycentric).normal;
        let tangent = DVec3::from(self.piece.tangent(met.parameter)).normalize();
        let along = tangent.dot(normal);
        // A tangent that would arrive from the other side does so at grazing incidence: it is turned to this side.
        let direction = if along * side > 0.0 { tangent } else { tangent - normal * (2.0 * along) };
        let PrimitiveHit { geometry, primitive, .. } = *hit;
        let is_crowded = self.surfaces.half.is_crowded(met.point);
        let found = SurfaceHit { point: met.point, direction, geometry, primitive, barycentric: met.barycentric, is_crowded };
        (found, met.parameter)
    }
}
