//! Chords of curves, put to the surfaces of one side.
//!
//! A chord strays from its curve by no more than a given gap. What it meets counts, for that is what decides what is seen, and it is right in
//! the mean: where the curve meets that surface itself is solved for ([`crate::tracing::meeting`]), and where the curve passes beside it, the
//! chord's own hit stands. But a ray never ends on the surface that it leaves because its first chord, or one soon after, dips below that: such a
//! chord is cut short.
//!
//! Where no surface is near ([`bhs_core::clearance`]) one chord leaps over what needs no question, however far it strays.

use crate::tracing::arc::Arc;
use crate::tracing::driver::Start;
use crate::tracing::meeting::{on_facet, on_surface};
use bhs_core::geometry::{Aabb, Geometry, Segment};
use bhs_core::integrator::SurfaceHit;
use bhs_core::intersector::{Primitive, PrimitiveHit};
use bhs_core::spacetime::Side;
use crate::log::TraceLog;
use bhs_core::world::{Half, Located, World};
use glam::{DVec2, DVec3};

/// How far a chord reaches beyond its end, relative to the coordinates there: single precision does not tear it apart from the next one. Also how
/// far beside its facet a hit may lie, for the same reason.
pub(crate) const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// Free space is passed over if that gets on by as much as this share of a chord.
const WORTHWHILE: f64 = 0.5;

/// Far more than the rounding of a length, relative to it.
const ROUNDING: f64 = 1e-6;

/// How often a chord is halved at most that dips below the surface which the ray leaves.
const MOST_HALVINGS: u32 = 60;

/// Chords of one piece at most, however small the gap.
const MOST_CHORDS: f64 = 1e7;

/// How far from a surface a ray may start that leaves it, over how far off it rays are put.
const JUST_OFF: f64 = 4.0;

/// The chords of one ray on one side.
pub(crate) struct Chords<'w> {
    world: &'w World,
    /// The surfaces; `None` without any.
    half: Option<Half<'w>>,
    /// A box around them with room for rounding.
    bounds: Aabb,
    gap: f64,
    /// Where the next chord begins; `None` if nobody has said.
    last: Option<DVec3>,
    departure: Option<Departure>,
}

/// How a ray leaves the surface on which it begins, as long as chords may dip below that.
#[derive(Clone, Copy)]
struct Departure {
    launch: DVec3,
    /// Whether no chord has been made.
    is_first: bool,
    /// Whether the ray begins exactly on a surface.
    is_exact: bool,
    /// The surface, once it is known.
    primitive: Option<Primitive>,
}

/// A chord, the part of it that lies among the surfaces, and what that meets.
struct Met {
    ends: [f64; 2],
    segment: Segment,
    /// Where the segment begins and how long it is, as shares of the chord.
    part: [f64; 2],
    hit: PrimitiveHit,
}

impl<'w> Chords<'w> {
    /// The chords of a ray that begins.
    pub(crate) fn of_ray(world: &'w World, start: &Start) -> Self {
        let &Start { origin, launch, side, leaving, gap, .. } = start;
        let departure = Departure { launch, is_first: true, is_exact: leaving.is_some(), primitive: leaving };
        Self { last: Some(origin), departure: Some(departure), ..Self::on_side(world, side, gap) }
    }

    /// The chords of a ray that comes to `side`.
    pub(crate) fn on_side(world: &'w World, side: Side, gap: f64) -> Self {
        let half = world.half(side).filter(|half| !half.bounds.is_empty());
        let bounds = half.map_or(Aabb::EMPTY, |half| half.bounds.grown(half.margin));
        Self { world, half, bounds, gap, last: None, departure: None }
    }

    /// Where the last chord ended, or the first begins.
    pub(crate) fn last(&self) -> Option<DVec3> {
        self.last
    }

    /// The first surface that the ray meets on `piece`, of some length, which continues the piece before, and the parameter there. If it `crosses` to
    /// the other side, the last chord ends where the piece does.
    pub(crate) fn meet<A: Arc<f64>>(&mut self, piece: &A, crosses: bool, log: &mut TraceLog) -> Option<(SurfaceHit, f64)> {
        let (mut s, end) = (piece.start(), piece.end());
        let Some(half) = self.half else {
            self.last = Some(piece.point(end).into());
            self.draw(piece, [s, end], log);
            return None;
        };
        let shortest = (end - s) / MOST_CHORDS;
        while s < end {
            let from = self.last.unwrap_or_else(|| piece.point(s).into());
            let stride = piece.stride(s, self.gap).max(shortest);
            if let Some((to, point)) = self.leap(&half, piece, [s, end], from, stride) {
                log.counters.leaps += 1;
                self.draw(piece, [s, to], log);
                (self.last, self.departure, s) = (Some(point), None, to);
                continue;
            }
            // Chords of equal length to the end of the piece.
            let left = ((end - s) / stride).ceil();
            let mut to = if left > 1.0 { s + (end - s) / left } else { end };
            if to <= s {
                to = end;
            }
            let (found, to) = self.chord(&half, piece, [s, to], from, crosses, log);
            if found.is_some() {
                return found;
            }
            let point = DVec3::from(piece.point(to));
            log.point(point);
            (self.last, s) = (Some(point), to);
        }
        None
    }

    /// What the chord from `from`, at the parameter `ends[0]`, to that at `ends[1]` meets, and where the chord ends: sooner if it dips below the surface
    /// that the ray leaves.
    fn chord<A: Arc<f64>>(
        &mut self,
        half: &Half<'_>,
        piece: &A,
        [a, mut b]: [f64; 2],
        from: DVec3,
        crosses: bool,
        log: &mut TraceLog,
    ) -> (Option<(SurfaceHit, f64)>, f64) {
        let whole = b;
        let departure = self.departure.take();
        if let Some(side) = departure.and_then(|d| self.side_of_departure(&d, from)) {
            b = self.on_side_of_departure(piece, [a, b], from, side);
        }
        for _ in 0..MOST_HALVINGS {
            let to = DVec3::from(piece.point(b));
            let ends_here = crosses && b == piece.end();
            let met = self.ask(half, [a, b], [from, to], departure.as_ref(), ends_here, log);
            let found = met.as_ref().map(|met| (met, self.resolve(half, piece, met, departure.is_some_and(|d| d.is_first))));
            match (found, departure) {
                (Some((met, arrival)), Some(left)) if self.dips(&left, met, from, arrival.is_some()) => {
                    let primitive = Some(Primitive { geometry: met.hit.geometry, primitive: met.hit.primitive });
                    self.departure = Some(Departure { primitive, ..left });
                    b = a + 0.5 * (b - a);
                }
                (Some((met, arrival)), _) => return (Some(arrival.unwrap_or_else(|| self.keep(half, piece, met))), b),
                (None, _) => break,
            }
        }
        // As long as chords are cut the next one may dip, too.
        let cut = departure.filter(|_| b < whole);
        self.departure = cut.map(|d| Departure { is_first: false, ..self.departure.unwrap_or(d) });
        (None, b)
    }

    /// A normal of the surface that the ray leaves exactly, on the side to which it goes.
    fn side_of_departure(&self, departure: &Departure, from: DVec3) -> Option<DVec3> {
        let Primitive { geometry, primitive } = departure.primitive.filter(|_| departure.is_exact && departure.is_first)?;
        let normal = self.world.geometries[geometry as usize].normal(primitive, from);
        Some(normal * departure.launch.dot(normal).signum())
    }

    /// Where to end the first chord, so that it ends on the side `side` of the surface on which it begins, at `from`.
    fn on_side_of_departure<A: Arc<f64>>(&self, piece: &A, [a, b]: [f64; 2], from: DVec3, side: DVec3) -> f64 {
        let mut to = b;
        for _ in 0..MOST_HALVINGS {
            if side.dot(DVec3::from(piece.point(to)) - from) > 0.0 {
                return to;
            }
            to = a + 0.5 * (to - a);
        }
        b
    }

    /// Puts a chord to the surfaces.
    fn ask(
        &self,
        half: &Half<'_>,
        ends: [f64; 2],
        [from, to]: [DVec3; 2],
        departure: Option<&Departure>,
        ends_here: bool,
        log: &mut TraceLog,
    ) -> Option<Met> {
        let way = to - from;
        let length = way.length();
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let t_max = if ends_here { 1.0 } else { 1.0 + OVERLAP * to.abs().max_element() / length };
        // What a chord within the box reaches beyond its end is of no account to the box.
        let within = self.bounds.contains(from) && self.bounds.contains(to);
        let Some((enter, leave)) = (if within { Some((0.0, t_max)) } else { self.bounds.clip(from, way, 0.0, t_max) }) else {
            log.counters.chords_skipped += 1;
            return None;
        };
        log.counters.queries += 1;
        let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
        let hit = match departure.filter(|d| d.is_exact && enter == 0.0) {
            Some(d) => half.closest_from(&segment, d.primitive.filter(|_| d.is_first)),
            None => half.closest(&segment, None),
        }?;
        Some(Met { ends, segment, part: [enter, leave - enter], hit })
    }

    /// Whether a chord from `from` meets what it does because it dips below the surface that the ray leaves. `is_met`: the curve meets it, too.
    fn dips(&self, departure: &Departure, met: &Met, from: DVec3, is_met: bool) -> bool {
        let PrimitiveHit { geometry, primitive, .. } = met.hit;
        if !departure.is_first {
            return !is_met && departure.primitive == Some(Primitive { geometry, primitive });
        }
        let surface = &self.world.geometries[geometry as usize];
        let just_off = JUST_OFF * surface.step_off(primitive);
        let normal = surface.normal(primitive, from);
        let is_there = match surface {
            Geometry::Analytic(surface) => {
                let across = Segment { origin: from - normal * just_off, direction: normal, t_min: 0.0, t_max: 2.0 * just_off };
                surface.intersect(&across).is_some()
            }
            mesh => mesh.corners(primitive).is_some_and(|[a, ..]| normal.dot(from - a).abs() <= just_off),
        };
        is_there && normal.dot(departure.launch) * normal.dot(met.segment.direction) < 0.0
    }

    /// Where the curve itself meets what its chord meets, if it does so nearby. `is_first`: the curve begins where the chord does.
    fn resolve<A: Arc<f64>>(&self, half: &Half<'_>, piece: &A, met: &Met, is_first: bool) -> Option<(SurfaceHit, f64)> {
        let Met { ends, segment, hit, .. } = met;
        let located = self.world.locate(segment, hit);
        let rounding = OVERLAP * located.point.abs().max_element();
        let length = segment.direction.length();
        let near = 4.0 * piece.gap(ends[0], ends[1]) + rounding;
        let guess = self.parameter(piece, met, &located);
        let meeting = match &self.world.geometries[hit.geometry as usize] {
            // Of a ray that leaves a curved surface, the tangent's way back leads to where it left: no place of the ray.
            Geometry::Analytic(surface) => on_surface(piece, *ends, guess, &**surface, near.min(length), length)
                .filter(|m| !is_first || m.parameter > ends[0]),
            mesh => on_facet(piece, *ends, guess, mesh.corners(hit.primitive)?),
        };
        let meeting = meeting.filter(|m| m.beside <= rounding && (m.point - located.point).length() <= near)?;
        let found = self.arrive(half, piece, met, (meeting.parameter, meeting.point, meeting.barycentric), &located);
        Some((found, meeting.parameter))
    }

    /// The hit of a chord that the curve passes beside, as it is.
    fn keep<A: Arc<f64>>(&self, half: &Half<'_>, piece: &A, met: &Met) -> (SurfaceHit, f64) {
        let located = self.world.locate(&met.segment, &met.hit);
        let parameter = self.parameter(piece, met, &located);
        (self.arrive(half, piece, met, (parameter, located.point, located.barycentric), &located), parameter)
    }

    /// About the parameter of the curve beside a point of its chord.
    fn parameter<A: Arc<f64>>(&self, piece: &A, met: &Met, located: &Located) -> f64 {
        let share = met.part[0] + located.t.clamp(0.0, met.part[1]);
        piece.beside(met.ends[0], met.ends[1], share.min(1.0))
    }

    /// The arrival at the parameter, point and weights `at` of the surface that a chord met where it is `located`.
    fn arrive<A: Arc<f64>>(
        &self,
        half: &Half<'_>,
        piece: &A,
        met: &Met,
        (parameter, point, barycentric): (f64, DVec3, DVec2),
        located: &Located,
    ) -> SurfaceHit {
        let PrimitiveHit { geometry, primitive, .. } = met.hit;
        let surface = &self.world.geometries[geometry as usize];
        let chord = met.segment.direction;
        // The side that the chord came from: where it met the surface, for a curved one may have turned away between there and here.
        let side = surface.surface(located.point, primitive, located.barycentric).normal.dot(chord);
        let normal = surface.surface(point, primitive, barycentric).normal;
        let tangent = DVec3::from(piece.tangent(parameter)).normalize();
        let along = tangent.dot(normal);
        // A tangent that would arrive from the other side does so at grazing incidence: it is turned to this side.
        let direction = if along * side > 0.0 { tangent } else { tangent - normal * (2.0 * along) };
        SurfaceHit { point, direction, geometry, primitive, barycentric, is_crowded: half.is_crowded(point) }
    }

    /// The end of a stretch from `from`, at the parameter `s`, that nothing is near to, no farther than `end`; `None` if that would be shorter than a
    /// chord, which may have the length `stride` in the parameter.
    ///
    /// The stretch strays from its chord by no more than its gap, here doubled; so it lies within a ball around the chord's middle, and is free if
    /// nothing is known to be in there. How far it may be is guessed from the free space around its beginning.
    fn leap<A: Arc<f64>>(
        &self,
        half: &Half<'_>,
        piece: &A,
        [s, end]: [f64; 2],
        from: DVec3,
        stride: f64,
    ) -> Option<(f64, DVec3)> {
        let around = self.free(half, from);
        if around <= 0.0 {
            return None;
        }
        let least = WORTHWHILE * stride.min(end - s);
        let mut length = 2.0 * around / DVec3::from(piece.tangent(s)).length();
        for _ in 0..2 {
            let to = if s + length < end { s + length } else { end };
            if to - s < least || to <= s {
                return None;
            }
            let point = DVec3::from(piece.point(to));
            let chord = point - from;
            // A little more, for rounding.
            let needed = (0.5 + ROUNDING) * chord.length() + 2.0 * piece.gap(s, to);
            if needed <= self.free(half, from + 0.5 * chord) {
                return Some((to, point));
            }
            length = 0.5 * (to - s);
        }
        None
    }

    /// A distance from `point` within which there is no surface.
    fn free(&self, half: &Half<'_>, point: DVec3) -> f64 {
        match half.clearance {
            Some(clearance) => clearance.at(point),
            None => point.distance(point.clamp(self.bounds.min, self.bounds.max)),
        }
    }

    /// Notes the points of a stretch about which nobody is asked, as chords would divide it, if somebody wants them.
    fn draw<A: Arc<f64>>(&self, piece: &A, [from, to]: [f64; 2], log: &mut TraceLog) {
        if log.polyline.is_none() {
            return;
        }
        let mut s = from;
        for _ in 0..MOST_DRAWN {
            s += piece.stride(s, self.gap);
            if s.is_nan() || s >= to {
                break;
            }
            log.point(piece.point(s).into());
        }
        log.point(piece.point(to).into());
    }
}

/// Points at most that are noted of a stretch.
const MOST_DRAWN: u32 = 10_000;
