//! Several rays around a hole followed side by side, each by its Taylor steps and chords: what `flight.rs` and `chords.rs` do for one, in lanes.
//!
//! Orbits, leaps through free space and plain hits on facets are worked out for all rays at once; the questions to the intersector are put one by
//! one. Whatever is out of the ordinary (a hit that is not where the chord has it, an analytic surface, a ray along the radius) is left to
//! the code for one ray. What becomes of a ray does not depend on those beside it.

use crate::chords::{Chords, LONGEST, NEARBY, OVERLAP, Place, ROUNDING, SPLITS, Span, WORTHWHILE};
use bhs_core::lanes::{LANES, Lanes, Vectors, first, none, of_bits, pick, set_bits};
use crate::orbit::Dense;
use crate::packet_hits::{Asked, Hits};
use crate::packet_orbit::{Planes, Polars, Steps, errors};
use bhs_core::blackhole::BlackHole;
use bhs_core::geometry::{Aabb, Segment};
use bhs_core::integrator::SurfaceHit;
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// Longest leap through free space, in radians: the gap between it and its chord is not to be large beside free space.
const LONGEST_LEAP: f64 = 0.8;

/// Chords of this angle (rad) are long.
const LONG: f64 = 0.5;

/// Free space that is worth a look, in cells of the grid.
const ENOUGH: f64 = 0.25;

/// A ray to be followed.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Where the orbit begins.
    pub from: DVec3,
    /// Unit chart direction there.
    pub direction: DVec3,
    /// Where the first chord begins: just off the surface that the orbit may begin on.
    pub origin: DVec3,
    /// Largest angle of a chord (rad).
    pub chord: f64,
    /// Relative error of the orbit.
    pub error: f64,
    /// Angle at which it ends, whatever is there (rad); infinite if nowhere.
    pub end: f64,
}

/// Where a course ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// On a surface.
    Surface(SurfaceHit),
    /// Where it was to end.
    There,
    /// Far away, in this unit chart direction.
    Sky(DVec3),
    /// Behind the horizon.
    Hole,
    /// Nowhere, after the largest number of steps.
    OutOfSteps,
    /// Not followed: the code for one ray has to.
    Odd,
}

/// Where a course ended, and at which angle (rad).
pub type Ended = (End, f64);

/// Points of orbits.
#[derive(Clone, Copy)]
pub(crate) struct Places {
    pub phi: Lanes,
    pub u: Lanes,
    pub points: Vectors,
}

impl Places {
    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub(crate) fn or(&self, o: &Self, which: Lanes) -> Self {
        Self { phi: pick(which, self.phi, o.phi), u: pick(which, self.u, o.u), points: self.points.or(o.points, which) }
    }

    /// The place of ray number `i`.
    pub(crate) fn lane(&self, i: usize) -> Place {
        Place { phi: self.phi.to_array()[i], u: self.u.to_array()[i], point: self.points.lane(i) }
    }
}

/// Rays that are followed side by side.
pub(crate) struct Packet<'w> {
    pub world: &'w World,
    pub rs: f64,
    /// A box around all surfaces, with room for rounding.
    pub bounds: Aabb,
    /// 1/r of the sphere around the hole that holds all geometry; infinite where there is none.
    u_bound: f64,
    pub planes: Planes,
    /// Largest angles of chords (rad).
    angle: Lanes,
    /// Where the next chords begin.
    pub last: Places,
    /// The last chords, and of which rays there is one.
    pub before: Vectors,
    pub has_before: Lanes,
    ends: [Ended; LANES],
}

/// Follows up to [`LANES`] rays around `hole`, each for at most `max_steps` steps.
pub fn follow(world: &World, hole: &BlackHole, courses: &[Course], max_steps: u64, log: &mut TraceLog) -> [Ended; LANES] {
    let c = Lanes::splat;
    // Places without a ray repeat the first one.
    let course: [Course; LANES] = std::array::from_fn(|i| courses[if i < courses.len() { i } else { 0 }]);
    let number = |f: fn(&Course) -> f64| Lanes::from(course.map(|c| f(&c)));
    let (planes, start, ordinary) =
        Planes::of_rays(hole.center, Vectors::of(course.map(|c| c.from)), Vectors::of(course.map(|c| c.direction)));
    let ordinary = ordinary & start.u.simd_lt(c(1.0 / hole.rs));
    let error = errors(hole.rs, &start, number(|c| c.error));
    let limit = number(|c| c.end);
    let reach = world.reach + world.margin;
    let mut packet = Packet {
        world,
        rs: hole.rs,
        bounds: world.bounds.grown(world.margin),
        u_bound: if world.reach > 0.0 { 1.0 / reach } else { f64::INFINITY },
        planes,
        angle: number(|c| c.chord),
        last: Places { phi: c(0.0), u: start.u, points: Vectors::of(course.map(|c| c.origin)) },
        before: Vectors::all(DVec3::ZERO),
        has_before: none(),
        ends: [(End::OutOfSteps, 0.0); LANES],
    };
    let present = first(courses.len());
    for i in set_bits((present & !ordinary).to_bitmask()) {
        packet.ends[i] = (End::Odd, 0.0);
    }
    packet.go(&start, error, limit, present & ordinary, max_steps, log);
    packet.ends
}

impl Packet<'_> {
    /// Follows the rays in `underway` to their ends.
    fn go(&mut self, start: &Polars, error: Lanes, limit: Lanes, mut underway: Lanes, max_steps: u64, log: &mut TraceLog) {
        let mut start = *start;
        for _ in 0..max_steps {
            let count = u64::from(underway.to_bitmask().count_ones());
            if count == 0 {
                return;
            }
            log.counters.steps += count;
           
            let mut steps = Steps::from(self.rs, &start, error);
            let there = steps.limit(limit);
            let captured = underway & steps.captured(self.rs);
            for i in set_bits(captured.to_bitmask()) {
                steps.end_at_horizon(self.rs, i);
            }
            let hit = self.meet(&steps, underway, log);
            underway = underway & !hit;
            self.end(&steps, underway, there, captured);
            underway = underway & !(there | captured | steps.escaped());
            start = steps.end;
        }
        for i in set_bits(underway.to_bitmask()) {
            self.ends[i].1 = start.phi.to_array()[i];
        }
    }

    /// Notes the ends of those of `rays` that end with these steps.
    fn end(&mut self, steps: &Steps, rays: Lanes, there: Lanes, captured: Lanes) {
        let phi = steps.end.phi.to_array();
        for i in set_bits((rays & there).to_bitmask()) {
            self.ends[i] = (End::There, phi[i]);
        }
        for i in set_bits((rays & captured & !there).to_bitmask()) {
            self.ends[i] = (End::Hole, phi[i]);
        }
        let escaped = (rays & steps.escaped() & !there).to_bitmask();
        if escaped != 0 {
            let (far, right) = steps.angles_at_infinity();
            let directions = (self.planes.e1 * far.cos).plus(self.planes.e2, far.sin);
            let (far, right) = (far.phi.to_array(), right.to_bitmask());
            for i in set_bits(escaped) {
                self.ends[i] = if right >> i & 1 == 1 {
                    (End::Sky(directions.lane(i)), far[i])
                } else {
                    let far = steps.lane(i).within_space(self.rs).end().phi;
                    (End::Sky(self.planes.lane(i).radial(far)), far)
                };
            }
        }
    }

    /// Goes along `steps`, which continue those before, as far as the first surface that an orbit meets: [`Chords::meet`]. Which of `rays` have
    /// met one.
    fn meet(&mut self, steps: &Steps, rays: Lanes, log: &mut TraceLog) -> Lanes {
        let c = Lanes::splat;
        let Polars { u, du, .. } = steps.start;
        // Outside of everything and on the way out, where no orbit turns back.
        let gone = u.simd_le(c(self.u_bound)) & du.simd_le(c(0.0)) & (c(1.5 * self.rs) * u).simd_le(c(1.0));
        let mut going = rays & !gone;
        if self.u_bound == f64::INFINITY {
            return none();
        }
        // Those whose chords have met something, and what it was.
        let (mut touched, mut met) = (none(), none());
        let mut hits = Hits::default();
        // Distance covered per radian on the last stretch; on the first one of a step, where it begins.
        let mut pace = u.mul_add(u, du * du).sqrt() / (u * u);
        loop {
            let chords = self.leaps(steps, &mut going, &mut pace, log);
            if chords.none() {
                // Nobody goes on: time to find out about the hits. Where there was none after all, the ray does.
                if touched.none() {
                    return met;
                }
               
               
                let arrived = self.settle(steps, &hits, log);
                met = met | arrived;
                going = touched & !arrived;
                touched = none();
                hits.clear();
                continue;
            }
           
           
            let meets = self.chords(steps, chords, &mut going, &mut pace, &mut hits, log);
            touched = touched | meets;
            going = going & !meets;
        }
    }

    /// Takes those rays that are `going` through free space as far as it reaches. Which of them have to go on by chords.
    #[inline(always)]
    fn leaps(&mut self, steps: &Steps, going: &mut Lanes, pace: &mut Lanes, log: &mut TraceLog) -> Lanes {
        let mut chords = none();
        loop {
            *going = *going & self.last.phi.simd_lt(steps.end.phi) & self.last.u.simd_gt(none());
            let leaping = *going & !chords;
            if leaping.none() {
                return *going;
            }
           
           
            chords = chords | (leaping & !self.leap(steps, leaping, pace, log));
        }
    }

    /// Goes on by a chord with each of `rays`. Which of them meet something: what, is noted in `hits`.
    #[inline(always)]
    fn chords(
        &mut self,
        steps: &Steps,
        rays: Lanes,
        going: &mut Lanes,
        pace: &mut Lanes,
        hits: &mut Hits,
        log: &mut TraceLog,
    ) -> Lanes {
        let c = Lanes::splat;
        // Chords of equal angle to the end of the step.
        let (from, end) = (self.last, steps.end.phi);
        let left = ((end - from.phi) / self.angle).ceil();
        let phi = pick(left.simd_gt(c(1.0)), from.phi + (end - from.phi) / left, end);
        let to = self.places(steps, phi);
        let until = self.outside_nearby(steps, &from, &to, rays);
        self.last = to.or(&from, rays);
        // Of those that leave for infinity nothing is left to ask.
        let asking = rays & until.u.simd_gt(c(0.0));
        *going = *going & (asking | !rays);
        let way = until.points - from.points;
        let swept = until.phi - from.phi;
        let length = way.length_squared().sqrt();
        *pace = pick(asking, length / swept, *pace);
        let asked = Asked { from, to: until, way, length, swept, before: self.before, has_before: self.has_before };
        let meets = of_bits(self.ask(&asked, asking, hits, log));
        self.before = way.or(self.before, asking);
        self.has_before = self.has_before | asking;
        meets
    }

    /// Takes those of `rays` that can through free space, as far as it reaches but no farther than a long chord. Which of them got on by
    /// more than a share of a chord.
    ///
    /// From ball to ball of free space along the long chord, as the light goes through the middles of the balls but for the gap between chord
    /// and orbit (sphere tracing; Hart 1996): each ball is known from one look at the grid, and the orbit's place only at the end.
    #[inline(always)]
    fn leap(&mut self, steps: &Steps, rays: Lanes, pace: &mut Lanes, log: &mut TraceLog) -> Lanes {
        let c = Lanes::splat;
        let Some(clearance) = self.world.clearance.as_ref() else { return none() };
        let end = steps.end.phi;
        // A long chord takes no longer than a look around.
        let rays = rays & (self.angle.simd_lt(c(LONG)) | (end - self.last.phi).simd_gt(self.angle));
        if rays.none() {
            return rays;
        }
        let around = clearance.at_each(self.last.points);
        let mut trying = rays & around.simd_gt(c(0.0));
        if trying.none() {
            return trying;
        }
        let least = c(WORTHWHILE) * self.angle.fast_min(end - self.last.phi);
        let phi = (self.last.phi + c(LONGEST_LEAP)).fast_min(end);
        let to = self.places(steps, phi);
        trying = trying & to.u.simd_gt(c(0.0));
        let (way, swept) = (to.points - self.last.points, phi - self.last.phi);
        let length = way.length_squared().sqrt();
        let per_length = c(1.0) / length;
        // Twice what the gap is expected to be.
        let gap = c(3.0 / 8.0 * self.rs) * swept * swept;
        let enough = c(ENOUGH * clearance.cell());
        // How far along the chord the ball around the last point reaches. The gap grows no faster than with four times the share of the way.
        let reach = |covered: Lanes, free: Lanes| {
            c(1.0 - ROUNDING) * free - gap * (c(4.0) * (covered + free) * per_length).fast_min(c(1.0))
        };
        let (mut covered, mut ahead) = (c(0.0), reach(c(0.0), around));
        let mut marching = trying;
        loop {
            marching = marching & ahead.simd_gt(enough) & covered.simd_lt(length);
            if marching.none() {
                break;
            }
            covered = pick(marching, covered + ahead, covered);
            ahead = reach(covered, clearance.at_each(self.last.points.plus(way, covered * per_length)));
        }
        // Where the orbit is there: its angle by that of the chord's point.
        let whole = covered.simd_ge(length);
        let got = self.last.points.plus(way, covered * per_length);
        let stretch = trying & !whole;
        let mut to = to;
        if stretch.any() {
            let turned = self.planes.angles(self.last.points, got);
            let part = self.places(steps, self.last.phi + turned.fast_min(swept));
            to = part.or(&to, stretch);
        }
        let leaped = trying & (to.phi - self.last.phi).simd_ge(least);
        let chord = to.points - self.last.points;
        self.before = chord.or(self.before, leaped);
        *pace = pick(leaped, chord.length_squared().sqrt() / (to.phi - self.last.phi), *pace);
        self.last = to.or(&self.last, leaped);
        self.has_before = self.has_before | leaped;
        log.counters.leaps += u64::from(leaped.to_bitmask().count_ones());
        leaped
    }

    /// The places at the angles `phi`.
    #[inline(always)]
    fn places(&self, steps: &Steps, phi: Lanes) -> Places {
        let (u, cos, sin) = steps.place(phi);
        Places { phi, u, points: self.planes.points(u, cos, sin) }
    }

    /// The ends of the chords from `from` to `to`; where a chord of `rays` leaves the sphere around all geometry, a place outside but not far
    /// ([`Chords::nearby`]).
    #[inline(always)]
    fn outside_nearby(&self, steps: &Steps, from: &Places, to: &Places, rays: Lanes) -> Places {
        let c = Lanes::splat;
        let (bound, near) = (c(self.u_bound), c(NEARBY * self.u_bound));
        let leaving = rays & from.u.simd_gt(bound) & to.u.simd_lt(near);
        if leaving.none() {
            return *to;
        }
        let wanted = c(0.5 * (1.0 + NEARBY) * self.u_bound);
        let share = ((from.u - wanted) / (from.u - to.u)).fast_clamp(c(0.01), c(0.99));
        let between = self.places(steps, from.phi + share * (to.phi - from.phi));
        let good = leaving & between.u.simd_le(bound) & between.u.simd_ge(near);
        let mut until = between.or(to, good);
        for i in set_bits((leaving & !good).to_bitmask()) {
            let Place { phi, u, point } = self.alone(i, from.lane(i), None).nearby(&steps.lane(i), &from.lane(i), to.lane(i));
            let which = of_bits(1 << i);
            until = Places { phi: c(phi), u: c(u), points: Vectors::all(point) }.or(&until, which);
        }
        until
    }

    /// The chords of ray number `i` alone, from `last`.
    fn alone(&self, i: usize, last: Place, before: Option<DVec3>) -> Chords<'_> {
        Chords::on(self.world, self.rs, self.planes.lane(i), self.angle.to_array()[i], last, before)
    }

    /// Asks what the chords of `rays` meet, and notes it in `hits`. Bits of those that meet something.
    #[inline(always)]
    fn ask(&self, asked: &Asked, rays: Lanes, hits: &mut Hits, log: &mut TraceLog) -> u32 {
        let c = Lanes::splat;
        let overlap = |p: &Vectors| c(OVERLAP) * p.largest() / asked.length;
        let t_min = pick(asked.has_before, -overlap(&asked.from.points), c(0.0)).to_array();
        let t_max = (c(1.0) + overlap(&asked.to.points)).to_array();
        let within = (self.contains(&asked.from.points) & self.contains(&asked.to.points)).to_bitmask();
        let ([x, y, z], [dx, dy, dz]) = (asked.from.points.to_arrays(), asked.way.to_arrays());
        let mut meets = 0;
        for i in set_bits((rays & asked.length.simd_gt(c(0.0))).to_bitmask()) {
            let (from, way) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]));
            let range =
                if within >> i & 1 == 1 { Some((t_min[i], t_max[i])) } else { self.bounds.clip(from, way, t_min[i], t_max[i]) };
            let Some((enter, leave)) = range else {
                log.counters.chords_skipped += 1;
                continue;
            };
            log.counters.queries += 1;
            let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
            if let Some(hit) = self.world.intersector.closest(&segment) {
                hits.note(self.world, i, segment, enter, hit);
                meets |= 1 << i;
            }
        }
        hits.keep(asked, of_bits(meets));
        meets
    }

    /// What has become of what chords have met: which rays have arrived there.
    fn settle(&mut self, steps: &Steps, hits: &Hits, log: &mut TraceLog) -> Lanes {
        let plain = self.plain_hits(steps, hits, log);
        let mut arrived = plain;
        for i in set_bits(hits.touched & !plain) {
           
            if let Some(hit) = self.settle_alone(steps, hits, i, log) {
                self.arrive(i, hit, log.phi, log);
                arrived |= 1 << i;
            }
        }
        of_bits(arrived)
    }

    /// Ray number `i` has arrived at `hit` after sweeping `phi`.
    #[inline]
    pub(crate) fn arrive(&mut self, i: usize, hit: SurfaceHit, phi: f64, log: &mut TraceLog) {
        self.ends[i] = (End::Surface(hit), phi);
        log.counters.hit += 1;
    }

    /// What has become of the hit of ray number `i`, which is not as most are.
    #[cold]
    fn settle_alone(&self, steps: &Steps, hits: &Hits, i: usize, log: &mut TraceLog) -> Option<SurfaceHit> {
        let asked = &hits.asked;
        let (from, to) = (asked.from.lane(i), asked.to.lane(i));
        let before = (asked.has_before.to_bitmask() >> i & 1 == 1).then(|| asked.before.lane(i));
        self.alone(i, from, before).settle(&steps.lane(i), &Span { from, to, before }, hits.chord(i), SPLITS, log)
    }

    /// Which points lie within the box around all surfaces.
    #[inline(always)]
    fn contains(&self, p: &Vectors) -> Lanes {
        let (min, max) = (Vectors::all(self.bounds.min), Vectors::all(self.bounds.max));
        let between = |p: Lanes, min: Lanes, max: Lanes| p.simd_ge(min) & p.simd_le(max);
        between(p.x, min.x, max.x) & between(p.y, min.y, max.y) & between(p.z, min.z, max.z)
    }
}

