//! One ray around the hole, from its start to where it ends: what the curved integrators share.

use crate::chords::{Chords, chord_angle};
use crate::orbit::{Dense, Fate, OrbitPlane, State, Stepper};
use crate::straight::Straight;
use bhs_core::blackhole::BlackHole;
use bhs_core::integrator::{Arrival, Integrator, Ray};
use bhs_core::params::Params;
use bhs_core::spacetime::Side;
use crate::log::TraceLog;
use bhs_core::world::World;

/// A ray about to be followed.
pub struct Flight<'w> {
    world: &'w World,
    /// The hole; `rs` > 0.
    pub hole: &'w BlackHole,
    /// The plane of its orbit.
    pub plane: OrbitPlane,
    ray: Ray,
    /// State of the orbit at the ray's origin.
    pub start: State,
}

impl<'w> Flight<'w> {
    /// Prepares to follow `ray`; or where it arrives, if that needs no orbit: without a hole, or inside of it.
    pub fn begin(world: &'w World, ray: &Ray, log: &mut TraceLog) -> Result<Self, Arrival> {
        let Some(hole) = world.hole.as_ref().filter(|h| h.rs > 0.0) else {
            return Err(Straight.trace(world, ray).arrival);
        };
        log.counters.geodesics += 1;
        log.phi = 0.0;
        log.point(ray.origin);
        let (plane, start) = OrbitPlane::of_ray(hole.center, ray.origin, ray.direction);
        if start.u * hole.rs >= 1.0 {
            log.counters.captured += 1;
            return Err(Arrival::Hole);
        }
        if !(start.u > 0.0 && start.du.is_finite()) {
            log.counters.out_of_steps += 1;
            return Err(Arrival::OutOfSteps);
        }
        Ok(Self { world, hole, plane, ray: *ray, start })
    }

    /// Follows `orbit`, which begins at `start`, by chords of at most the angle `chord`.
    pub fn follow<S: Stepper>(self, mut orbit: S, chord: f64, max_steps: u64, log: &mut TraceLog) -> Arrival {
        let mut chords = Chords::new(self.world, self.hole, self.plane, self.ray.origin, &self.start, chord)
            .leaving(self.ray.leaving, self.ray.direction);
        for _ in 0..max_steps {
            let (step, fate) = orbit.advance();
            log.counters.steps += 1;
            let step = if fate == Fate::Captured { step.within_space(self.hole.rs) } else { step };
            if let Some(hit) = chords.meet(&step, log) {
                log.counters.hit += 1;
                return Arrival::Surface(hit);
            }
            log.phi = step.end().phi;
            match fate {
                Fate::Underway => {}
                Fate::Escaped => {
                    log.phi = step.within_space(self.hole.rs).end().phi;
                    log.counters.escaped += 1;
                    return Arrival::Sky(self.plane.radial(log.phi), Side::Near);
                }
                Fate::Captured => {
                    log.counters.captured += 1;
                    return Arrival::Hole;
                }
            }
        }
        log.counters.out_of_steps += 1;
        Arrival::OutOfSteps
    }
}

/// How far what is traced may stray from the true ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// A distance (scene units).
    Absolute(f64),
    /// A tenth of the ray's footprint; 1e-4 of the diagonal of all surfaces for one of unknown footprint.
    Footprint,
}

/// Tolerance over footprint.
const TENTH: f64 = 0.1;

/// Tolerance of a ray of unknown footprint, relative to the diagonal of the box around all surfaces.
const UNKNOWN: f64 = 1e-4;

/// Largest relative error of an orbit. A precise orbit costs a third of a step more than one that is as coarse as chords may be, and then hits
/// are right to this, however coarse the chords: those decide only which surface is met.
const ORBIT_ERROR: f64 = 1e-6;

/// The same where there is no surface to give distances a scale: far below a pixel.
const SKY_ERROR: f64 = 1e-7;

impl Tolerance {
    /// What scenes get that do not ask for anything.
    pub const DEFAULT: Self = Self::Footprint;

    /// The parameter `tolerance`.
    pub fn read(p: &Params) -> Self {
        let about = "largest distance between the true ray and what is traced; by default a tenth of the ray's footprint";
        match p.optional::<f64>("tolerance", "scene", about) {
            Some(t) if t > 0.0 => Self::Absolute(t),
            Some(t) => {
                p.reject("tolerance", "`tolerance` must be above 0", format!("found {t}"));
                Self::DEFAULT
            }
            None => Self::DEFAULT,
        }
    }

    /// The distance (scene units) for a ray of the given footprint.
    pub fn distance(self, world: &World, footprint: f64) -> f64 {
        match self {
            Self::Absolute(t) => t,
            Self::Footprint if world.bounds.is_empty() => f64::INFINITY,
            Self::Footprint if footprint > 0.0 => TENTH * footprint,
            Self::Footprint => UNKNOWN * (world.bounds.max - world.bounds.min).length(),
        }
    }

    /// The largest angle of a chord of a ray of the given footprint around `hole` whose orbit has the relative error `error`, in radians: the
    /// chord may take up what the orbit leaves.
    pub fn chord(self, world: &World, hole: &BlackHole, footprint: f64, error: f64) -> f64 {
        chord_angle(hole.rs, self.distance(world, footprint) - error * world.reach)
    }

    /// Relative error of the orbit: `share` of the tolerance over the distance from the hole to the farthest surface, or less.
    pub fn relative(self, world: &World, footprint: f64, share: f64) -> f64 {
        let reach = world.reach;
        if reach > 0.0 { (share * self.distance(world, footprint) / reach).min(ORBIT_ERROR) } else { SKY_ERROR }
    }
}
