//! Rays among surfaces, one or eight side by side: pieces of their curves, chord by chord.
//!
//! A chord strays from its curve by no more than a given gap, and is put to the intersector, which knows straight segments only. What it meets
//! decides what is seen; where the curve itself meets that surface is solved for (`packet/hits`, `resolve`). Where no surface is near
//! ([`bhs_engine::clearance`]) one chord leaps over what needs no question, however far it strays (`leaps`).
//!
//! Curves, leaps and plain hits on facets are worked out for all rays at once; the questions to the intersector are put one by one, and what is out of
//! the ordinary is resolved ray by ray. What becomes of a ray does not depend on those beside it.

use crate::tracing::arc::Arc;
use crate::tracing::departure::Departure;
use crate::tracing::places::{CurvePoints, Start};
use crate::tracing::surfaces::Surfaces;
use bhs_core::lanes::{LANES, set_bits};
use bhs_core::ray::{Arrival, RayEnd, SurfaceHit};
use bhs_core::real::{Mask, Real, Vector};
use bhs_engine::way::Watch;
use bhs_engine::world::World;
use glam::DVec3;
use hits::{Asked, Hits};

mod departures;
pub(super) mod hits;

/// Chords of one piece at most, however small the gap.
const MOST_CHORDS: f64 = 1e7;

/// Points at most that are noted of a stretch which is passed over.
const MOST_DRAWN: u32 = 10_000;

/// Rays that are followed side by side.
pub(crate) struct Packet<'w, F: Real> {
    pub world: &'w World,
    /// The surfaces of both sides; `None` where there are none.
    pub surfaces: [Option<&'w Surfaces<'w>>; 2],
    /// How the rays start.
    pub start: &'w Start<'w, F>,
    /// Bits of the rays that are on the far side.
    pub far: u32,
    /// Largest distances between chords and curves (scene units).
    pub gap: F,
    /// Lengths of chords, where they are all the same.
    stride: F,
    /// The parameters at which the rays end.
    pub limit: F,
    /// Where the rays are.
    pub parameter: F,
    /// Where the next chords begin.
    pub last: Vector<F>,
    last_s: F,
    /// Bits of the rays that have just come to another side, where the next chord begins with the piece.
    fresh: u32,
    /// Rays whose piece ends on the throat.
    pub crossing: F::Mask,
    /// The chords before, and of which rays there is one.
    pub before: Vector<F>,
    pub has_before: F::Mask,
    /// How rays leave the surfaces on which they begin exactly.
    pub departures: [Option<Departure>; LANES],
    /// Bits of those that have made no chord yet, or one that was cut short.
    pub departing: u32,
    /// Bits of those that have come to where they were to end.
    pub reached: u32,
    /// What becomes of them.
    pub ends: &'w mut [RayEnd],
    /// Steps and leaps so far.
    pub steps: F,
    pub leaps: F,
    /// Who sees the way of the first of them.
    pub watch: Option<&'w mut dyn Watch>,
}

impl<'w, F: Real> Packet<'w, F> {
    /// The rays of `start`, of which `ends` has as many places.
    #[inline(always)]
    pub fn new(world: &'w World, start: &'w Start<'w, F>, mut watch: Option<&'w mut dyn Watch>, ends: &'w mut [RayEnd]) -> Self {
        let c = F::splat;
        let mut departures = [None; LANES];
        for i in set_bits(start.departing) {
            departures[i] = Departure::of(world, start.rays.ray(i));
        }
        if let Some(watch) = &mut watch {
            watch.point(0.0, start.origin.lane(0));
        }
        Self {
            world,
            surfaces: start.surfaces.each_ref().map(Option::as_ref),
            start,
            far: start.far,
            gap: start.gap,
            stride: c(0.0),
            limit: start.limit,
            parameter: c(0.0),
            last: start.origin,
            last_s: c(0.0),
            fresh: 0,
            crossing: F::Mask::NONE,
            before: Vector::all(DVec3::ZERO),
            has_before: F::Mask::NONE,
            departures,
            departing: start.departing,
            reached: 0,
            ends,
            steps: c(0.0),
            leaps: c(0.0),
            watch,
        }
    }

    /// One more of what is counted for each of `rays`.
    #[inline(always)]
    pub fn count(count: F, rays: F::Mask) -> F {
        count + F::select(rays, F::splat(1.0), F::splat(0.0))
    }

    /// Puts the rays `crossing` onto the other side, where their next chord begins with the next piece.
    #[cold]
    pub fn cross(&mut self, crossing: F::Mask) {
        let bits = crossing.bits();
        self.far ^= bits;
        self.fresh |= bits;
        self.departing &= !bits;
        for i in set_bits(bits) {
            self.departures[i] = None;
        }
        self.has_before = self.has_before & !crossing;
    }

    /// The surfaces of the side that ray number `i` is on.
    #[inline(always)]
    pub fn surfaces_of(&self, i: usize) -> Option<&'w Surfaces<'w>> {
        self.surfaces[(self.far >> i & 1) as usize]
    }

    /// Which rays are on a side that has surfaces.
    #[inline(always)]
    fn among_surfaces(&self) -> F::Mask {
        match &self.surfaces {
            [Some(_), Some(_)] => F::Mask::ALL,
            [None, None] => F::Mask::NONE,
            [Some(_), None] if self.far == 0 => F::Mask::ALL,
            [Some(_), None] => !F::Mask::of_bits(self.far),
            [None, Some(_)] => F::Mask::of_bits(self.far),
        }
    }

    /// Goes along `piece`, which continues those before, to the parameters `end` of `rays`, or as far as the first surface that a ray meets. Which
    /// rays have met one. `hits` holds nothing before and after: it is large.
    #[inline(always)]
    pub fn meet<A: Arc<F>>(&mut self, piece: &A, end: F, rays: F::Mask, hits: &mut Hits<F>) -> F::Mask {
        self.last_s = F::select(rays, piece.start(), self.last_s);
        if self.fresh != 0 {
            let fresh = rays & F::Mask::of_bits(self.fresh);
            self.last = piece.point(piece.start()).or(self.last, fresh);
            self.fresh &= !fresh.bits();
        }
        let mut going = rays & self.among_surfaces();
        if going.bits() != rays.bits() {
            self.pass_over_nothing(piece, end, rays & !going);
        }
        if A::HAS_EQUAL_STRIDES {
            self.stride = piece.stride(piece.start(), self.gap);
        }
        // Those whose chords have met something, and what it was.
        let (mut touched, mut met) = (F::Mask::NONE, F::Mask::NONE);
        loop {
            let chords = self.leaps(piece, end, &mut going);
            if !chords.any() {
                // Nobody goes on: time to find out about the hits. Where there was none after all, the ray does.
                if !touched.any() {
                    return met;
                }
                let arrived = self.resolve_hits(piece, hits);
                met = met | arrived;
                going = touched & !arrived;
                touched = F::Mask::NONE;
                hits.clear();
                continue;
            }
            let meets = self.chords(piece, end, chords, hits);
            touched = touched | meets;
            going = going & !meets;
        }
    }

    /// Lengths of the next chords of `piece`.
    #[inline(always)]
    pub fn strides<A: Arc<F>>(&self, piece: &A) -> F {
        if A::HAS_EQUAL_STRIDES {
            return self.stride;
        }
        let shortest = (piece.end() - piece.start()) * F::splat(1.0 / MOST_CHORDS);
        piece.stride(self.last_s, self.gap).max(shortest)
    }

    /// Where the next chords begin.
    #[inline(always)]
    pub fn from(&self) -> CurvePoints<F> {
        CurvePoints { s: self.last_s, points: self.last }
    }

    /// The places of `piece` at the parameters `s`.
    #[inline(always)]
    pub fn places<A: Arc<F>>(&self, piece: &A, s: F) -> CurvePoints<F> {
        CurvePoints { s, points: piece.point(s) }
    }

    /// `rays` have come from where they were to `to`.
    #[inline(always)]
    pub fn go_to(&mut self, to: &CurvePoints<F>, rays: F::Mask) {
        let CurvePoints { s, points } = to.or(&self.from(), rays);
        self.before = (points - self.last).or(self.before, rays);
        self.has_before = self.has_before | rays;
        (self.last_s, self.last) = (s, points);
    }

    /// Goes on by a chord with each of `rays`. Which of them meet something: what, is noted in `hits`.
    #[inline(always)]
    fn chords<A: Arc<F>>(&mut self, piece: &A, end: F, rays: F::Mask, hits: &mut Hits<F>) -> F::Mask {
        // Chords of equal length to the end of the piece.
        let from = self.from();
        let left = ((end - from.s) / self.strides(piece)).ceil();
        let next = from.s + (end - from.s) / left;
        let s = F::select(left.gt(F::splat(1.0)) & next.gt(from.s), next, end);
        let mut to = self.places(piece, s);
        let departing = self.departing & rays.bits();
        if departing != 0 {
            self.cut_short(piece, &from, &mut to, departing);
        }
        let way = to.points - from.points;
        let length = way.length();
        let (before, has_before) = (self.before, self.has_before);
        let asked = Asked { from, to, way, length, before, has_before, end };
        let meets = F::Mask::of_bits(self.ask(piece, &asked, rays, hits));
        if departing != 0 {
            self.have_departed(departing);
        }
        self.go_to(&to, rays);
        self.draw(piece, &from, rays & !meets, false);
        meets
    }

    /// Ray number `i` has arrived at `hit`, at the parameter `parameter`.
    #[inline]
    pub fn arrive(&mut self, i: usize, hit: SurfaceHit, parameter: f64) {
        self.ends[i].arrival = Arrival::Surface(hit);
        self.ends[i].swept = parameter;
        if i == 0
            && let Some(watch) = &mut self.watch
        {
            watch.point(parameter, hit.point);
        }
    }

    /// Where there are no surfaces, nobody is asked.
    #[cold]
    fn pass_over_nothing<A: Arc<F>>(&mut self, piece: &A, end: F, rays: F::Mask) {
        let from = self.from();
        let to = self.places(piece, end);
        self.go_to(&to, rays);
        self.draw(piece, &from, rays, true);
    }

    /// Notes the points of the way from `from` to where the rays are now, if it is that of the first of `rays` and somebody wants them. What was
    /// `passed_over` is divided as chords would divide it.
    #[inline(always)]
    pub fn draw<A: Arc<F>>(&mut self, piece: &A, from: &CurvePoints<F>, rays: F::Mask, passed_over: bool) {
        if self.watch.is_some() && rays.bits() & 1 == 1 {
            self.draw_way(&piece.lane(0), from.s.lane(0), passed_over);
        }
    }

    #[cold]
    fn draw_way<A: Arc<f64>>(&mut self, piece: &A, from: f64, passed_over: bool) {
        let (to, last, gap) = (self.last_s.lane(0), self.last.lane(0), self.gap.lane(0));
        let Some(watch) = self.watch.as_mut().filter(|watch| watch.wants_points()) else { return };
        let mut s = from;
        for _ in 0..if passed_over { MOST_DRAWN } else { 0 } {
            s += piece.stride(s, gap);
            if s.is_nan() || s >= to {
                break;
            }
            watch.point(s, piece.point(s).into());
        }
        watch.point(to, last);
    }
}
