//! Light sampling around the hole: what all curved integrators offer for it.
//!
//! The geodesics between two points come in closed form (`connect.rs`), whatever integrator follows the rays; what stands in
//! their way is found by the same chords as for any ray. The orbit between the ends is a Taylor series: it only has to be as
//! precise as the chords, and its points cost a tenth of those of the closed form.

use crate::chords::{Chords, chord_angle};
use crate::connect::{MOST_IMAGES, connect_pair, connect_pairs, spread_of};
use crate::connect_sky::{connect_sky, spread_sky};
use crate::flight::Tolerance;
use crate::orbit::{Dense, Fate, OrbitPlane, Stepper};
use crate::packet::{Course, End, NOWHERE, follow};
use crate::straight::Straight;
use crate::taylor::TaylorOrbit;
use bhs_core::blackhole::BlackHole;
use bhs_core::geometry::Segment;
use bhs_core::integrator::{ConnectionPair, Connections, Cost, ShadowRay, SurfaceHit};
use bhs_core::intersector::{Ends, Primitive};
use bhs_core::lanes::LANES;
use bhs_core::params::Params;
use bhs_core::spacetime::{Place, Side};
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// How long the chords along a connection may be.
#[derive(Clone, Copy, Debug)]
pub enum Chord {
    /// An angle (rad).
    Angle(f64),
    /// As long as the ray strays from them by no more than this.
    Tolerance(Tolerance),
}

/// Geodesics between two points around a hole.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// Pairs of geodesics that light sampling looks for: 1 plus the greatest number of whole turns around the hole.
    pub turns: u32,
    /// The chords that look for what stands in the way.
    pub chord: Chord,
}

/// How close to the end a connection may meet a surface without being blocked by it, relative to the coordinates there: the
/// surface at the end must not shadow itself.
const SHADOW_END: f64 = 64.0 * f32::EPSILON as f64;

/// Relative error of the orbit between the ends; it is to meet the end closer than [`SHADOW_END`].
const ORBIT_ERROR: f64 = 1e-7;

/// The parameter `windings`, plus 1.
pub fn read_turns(p: &Params) -> u32 {
    let most = i64::from(MOST_IMAGES / 2 - 1);
    let windings = p.get_in("windings", 0, 0..=most, "", "whole turns around the hole of the longest light that is sampled");
    windings as u32 + 1
}

fn hole(world: &World) -> Option<&BlackHole> {
    world.hole.as_ref().filter(|h| h.rs > 0.0)
}

impl Connections for Joined {
    fn turns(&self) -> u32 {
        self.turns
    }

    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        match hole(world) {
            Some(hole) => connect_pair(hole, x.x, y.x, turn),
            None => Straight.connect(world, x, y, turn),
        }
    }

    fn connect_all(&self, world: &World, pairs: &[[Place; 2]], found: &mut [&mut [ConnectionPair]]) {
        let Some(hole) = hole(world) else { return Straight.connect_all(world, pairs, found) };
        for (turn, found) in (0..).zip(found) {
            connect_pairs(hole, pairs, turn, found);
        }
    }

    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64> {
        match hole(world) {
            Some(hole) => spread_of(hole, x.x, launch, y.x, phi, 2 * self.turns),
            None => Straight.spread(world, x, launch, y, phi),
        }
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        match hole(world) {
            Some(hole) => connect_sky(hole, x.x, sky.0, turn),
            None => Straight.connect_sky(world, x, sky, turn),
        }
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64> {
        match hole(world) {
            Some(hole) => spread_sky(hole, x.x, launch, sky.0, phi, 2 * self.turns),
            None => Straight.spread_sky(world, x, launch, sky, phi),
        }
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let mut log = TraceLog::default();
        for (ray, occluded) in shadow_rays.iter().zip(occluded) {
            *occluded = !self.visible(world, ray, &mut log);
        }
        log.cost()
    }
}

impl Joined {
    fn visible(&self, world: &World, sight: &ShadowRay, log: &mut TraceLog) -> bool {
        let ShadowRay { start, from: x, to: Place { x: y, .. }, target, connection } = *sight;
        let Some(hole) = hole(world).filter(|_| connection.phi > 0.0) else {
            let mut occluded = [false];
            log.counters.queries += Straight.occluded_all(world, std::slice::from_ref(sight), &mut occluded).queries;
            return !occluded[0];
        };
        let course = self.course(world, hole, sight);
        let (plane, state) = OrbitPlane::of_ray(hole.center, x, connection.launch);
        let chords = Chords::new(world, hole, plane, start.origin, &state, course.chord);
        let mut chords =
            chords.leaving(start.leaving, connection.launch).between(start.origin, target.map(|target| target.geometry));
        let target = target.filter(|_| world.intersector.is_crowded(y));
        let mut orbit = TaylorOrbit::new(hole.rs, state, course.error);
        loop {
            let (step, fate) = orbit.advance();
            let done = step.end().phi >= course.end || fate != Fate::Underway;
            let step = if step.end().phi > course.end { step.until(step.at(course.end)) } else { step };
            if let Some(hit) = chords.meet(&step, log) {
                // Other surfaces may be as near to a crowded end as that.
                return is_end(&hit, x, y) && target.is_none_or(|target| target.geometry == hit.geometry);
            }
            if done {
                return target.is_none() || !self.ends_blocked(world, chords.last(), y, target, log);
            }
        }
    }

}

/// Distance from the end within which a surface may be met that does not block a connection between `x` and `y` (scene units).
fn close(x: DVec3, y: DVec3) -> f64 {
    SHADOW_END * y.abs().max_element().max(x.abs().max_element())
}

/// Whether what was met on the way from `x` to `y` is where it ends.
fn is_end(hit: &SurfaceHit, x: DVec3, y: DVec3) -> bool {
    (hit.point - y).length() <= 4.0 * close(x, y)
}

impl Joined {
    /// Whether anything stands between the last chord's end and the point `to` of the primitive `target`.
    fn ends_blocked(&self, world: &World, from: DVec3, to: DVec3, target: Option<Primitive>, log: &mut TraceLog) -> bool {
        log.counters.queries += 1;
        let segment = Segment { origin: from, direction: to - from, t_min: 0.0, t_max: 1.0 };
        world.intersector.blocked_between(&segment, Ends { leaving: None, target })
    }

    /// What is followed to find out what stands in the way.
    fn course(&self, world: &World, hole: &BlackHole, sight: &ShadowRay) -> Course {
        let ShadowRay { start, from, to: Place { x: to, .. }, target, connection } = *sight;
        let chord = match self.chord {
            Chord::Angle(angle) => angle,
            Chord::Tolerance(t) => chord_angle(hole.rs, t.distance(world, start.footprint)),
        };
        // The last chord ends just before `to`: by d phi/d s = sin(beta)/r.
        let from_center = to - hole.center;
        let r = from_center.length();
        let sin = connection.arrival.cross(from_center).length() / r;
        let end = connection.phi - close(from, to) * sin / r;
        let is_exact = start.leaving.is_some() || (target.is_some() && world.intersector.is_crowded(to));
        let target = target.map_or(NOWHERE, |target| target.geometry);
        Course { from, direction: connection.launch, origin: start.origin, chord, error: ORBIT_ERROR, end, target, is_exact }
    }
}
