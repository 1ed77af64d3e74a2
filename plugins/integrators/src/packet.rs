//! Several rays around a hole followed side by side, each by its Taylor steps and chords: what `flight.rs` and `chords.rs` do for one, in lanes.
//!
//! Orbits, leaps through free space and plain hits on facets are worked out for all rays at once; the questions to the intersector are put one by
//! one. Whatever is out of the ordinary (a hit that is not where the chord has it, an analytic surface, a ray along the radius) is left to
//! the code for one ray. What becomes of a ray does not depend on those beside it.

use crate::chords::{Chords, NEARBY, Place, surroundings};
use crate::orbit::Dense;
use crate::packet_hits::{Asked, Hits};
use crate::spherical::packet_orbit::{Planes, Polars, Steps, errors};
use bhs_core::blackhole::BlackHole;
use bhs_core::geometry::Aabb;
use bhs_core::integrator::SurfaceHit;
use bhs_core::lanes::{LANES, Lanes, Vectors, first, none, of_bits, pick, set_bits};
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

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
    /// The geometry on which it ends; [`NOWHERE`] if on none. As short as that, for courses are copied a lot.
    pub target: u32,
    /// Whether it begins or ends exactly on a surface: the code for one ray sees to those.
    pub is_exact: bool,
}

/// The number of no geometry.
pub const NOWHERE: u32 = u32::MAX;

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
    pub angle: Lanes,
    /// Where the next chords begin.
    pub last: Places,
    /// The last chords, and of which rays there is one.
    pub before: Vectors,
    pub has_before: Lanes,
    courses: &'w [Course; LANES],
    ends: [Ended; LANES],
}

/// Follows the first `count` of some rays around `hole`, each for at most `max_steps` steps; the others are there to fill the lanes.
pub fn follow(
    world: &World,
    hole: &BlackHole,
    course: &[Course; LANES],
    count: usize,
    max_steps: u64,
    log: &mut TraceLog,
) -> [Ended; LANES] {
    let c = Lanes::splat;
    let vectors = |f: fn(&Course) -> DVec3| Vectors::of(std::array::from_fn(|i| f(&course[i])));
    let number = |f: fn(&Course) -> f64| Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| f(&course[i])));
    let (planes, start, ordinary) = Planes::of_rays(hole.center, vectors(|c| c.from), vectors(|c| c.direction));
    let exact = (0..LANES).filter(|i| course[*i].is_exact).fold(0, |bits, i| bits | 1 << i);
    let ordinary = ordinary & !of_bits(exact) & start.u.simd_lt(c(1.0 / hole.rs));
    let error = errors(hole.rs, &start, number(|c| c.error));
    let limit = number(|c| c.end);
    let (bounds, u_bound) = surroundings(world);
    let mut packet = Packet {
        world,
        rs: hole.rs,
        bounds,
        u_bound,
        planes,
        angle: number(|c| c.chord),
        last: Places { phi: c(0.0), u: start.u, points: vectors(|c| c.origin) },
        before: Vectors::all(DVec3::ZERO),
        has_before: none(),
        courses: course,
        ends: [(End::OutOfSteps, 0.0); LANES],
    };
    let present = first(count);
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
            log.counters.steps += count as u32;
            let mut steps = Steps::from(self.rs, &start, error);
            let there = steps.limit(limit);
            let captured = underway & steps.captured(self.rs);
            for i in set_bits(captured.to_bitmask()) {
                steps.end_at_horizon(self.rs, i);
            }
            let hit = self.meet(&steps, underway, log);
            underway &= !hit;
            self.end(&steps, underway, there, captured);
            underway &= !(there | captured | steps.escaped());
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
        loop {
            let chords = self.leaps(steps, &mut going, log);
            if chords.none() {
                // Nobody goes on: time to find out about the hits. Where there was none after all, the ray does.
                if touched.none() {
                    return met;
                }
                let arrived = self.settle(steps, &hits, log);
                met |= arrived;
                going = touched & !arrived;
                touched = none();
                hits.clear();
                continue;
            }
            let meets = self.chords(steps, chords, &mut going, &mut hits, log);
            touched |= meets;
            going &= !meets;
        }
    }

    /// Goes on by a chord with each of `rays`. Which of them meet something: what, is noted in `hits`.
    #[inline(always)]
    fn chords(&mut self, steps: &Steps, rays: Lanes, going: &mut Lanes, hits: &mut Hits, log: &mut TraceLog) -> Lanes {
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
        *going &= asking | !rays;
        let way = until.points - from.points;
        let swept = until.phi - from.phi;
        let length = way.length_squared().sqrt();
        let asked = Asked { from, to: until, way, length, swept, before: self.before, has_before: self.has_before };
        let meets = of_bits(self.ask(&asked, asking, hits, log));
        self.before = way.or(self.before, asking);
        self.has_before |= asking;
        meets
    }

    /// The places at the angles `phi`.
    #[inline(always)]
    pub(crate) fn places(&self, steps: &Steps, phi: Lanes) -> Places {
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
    pub(crate) fn alone(&self, i: usize, last: Place, before: Option<DVec3>) -> Chords<'_> {
        let Course { origin, target, .. } = self.courses[i];
        Chords::on(self.world, self.rs, self.planes.lane(i), self.angle.to_array()[i], last, before)
            .between(origin, Some(target).filter(|geometry| *geometry != NOWHERE))
    }

    /// Ray number `i` has arrived at `hit` after sweeping `phi`.
    #[inline]
    pub(crate) fn arrive(&mut self, i: usize, hit: SurfaceHit, phi: f64, log: &mut TraceLog) {
        self.ends[i] = (End::Surface(hit), phi);
        log.counters.hit += 1;
    }
}
