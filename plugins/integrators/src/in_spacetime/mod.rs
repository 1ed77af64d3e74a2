//! Integrators in spacetimes other than flat space and the plain hole: which way of following rays belongs to which class.

use crate::flight::Tolerance;
use crate::general::course::{Depths, Ray as GeneralRay};
use crate::general::{self, Surroundings};
use crate::graded_index::course::Setting;
use crate::spherical::course::Ray as Orbit;
use crate::straight::Straight;
use crate::tracing::driver::{Course, End, Start, follow};
use crate::tracing::extent::{Extent, Precision};
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray, Traced};
use bhs_core::observer::Observer;
use bhs_core::spacetime::{Class, Place, Spacetime, Spherical};
use bhs_core::stats::TraceLog;
use bhs_core::world::World;

mod joining;

pub use joining::Joining;

/// How rays are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// To a tolerance, by what suits the class of the spacetime best.
    Adaptive(Tolerance),
    /// By classic Runge-Kutta steps of this length, as seen from the nearest hole (rad).
    RungeKutta(f64),
    /// To a tolerance, by Hamilton's equations.
    General(Tolerance),
}

/// Light in the spacetime of the world that it is followed through.
#[derive(Clone, Debug)]
pub struct InSpacetime {
    /// How.
    pub method: Method,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// The rays between two points, if they are searched.
    pub connections: Option<Joining>,
}

/// What is told once of a world through which many rays are followed.
enum Setup<'w> {
    Straight,
    Spherical(Spherical, Extent),
    Index(Setting<'w>),
    General(Box<Surroundings<'w>>, Depths, Extent),
}

impl Method {
    fn setup<'w>(self, world: &World, spacetime: &'w dyn Spacetime) -> Setup<'w> {
        let extent = Extent::of(world);
        let general = || {
            let throat = match spacetime.class() {
                Class::Index(index) => index.throat(),
                _ => None,
            };
            let surroundings = Surroundings::new(spacetime, throat, true, extent.reach);
            Setup::General(Box::new(surroundings), Depths::new(world, spacetime), extent)
        };
        match (self, spacetime.class()) {
            (_, Class::Flat) => Setup::Straight,
            (Self::General(_), _) | (_, Class::General(_)) => general(),
            (_, Class::Spherical(hole)) => Setup::Spherical(hole, extent),
            (_, Class::Index(index)) => Setup::Index(Setting::new(world, spacetime, index)),
        }
    }
}

impl InSpacetime {
    /// Does `work` with what is told of `world`.
    fn with_setup<R>(&self, world: &World, work: impl FnOnce(&Setup<'_>) -> R) -> R {
        match (&world.spacetime, world.hole.as_ref().filter(|h| h.rs > 0.0)) {
            (Some(spacetime), _) => work(&self.method.setup(world, &**spacetime)),
            (None, Some(hole)) => {
                let plain = Spherical { center: hole.center, rs: hole.rs, charge_squared: 0.0 };
                work(&self.method.setup(world, &plain))
            }
            (None, None) => work(&Setup::Straight),
        }
    }

    /// Follows `ray`: where it ends, and its parameter there.
    fn trace_in(&self, setup: &Setup<'_>, world: &World, ray: &Ray, log: &mut TraceLog) -> (Arrival, f64) {
        if matches!(setup, Setup::Straight) {
            return (Straight.trace(world, ray, log), log.phi);
        }
        log.counters.geodesics += 1;
        let place = Place { x: ray.origin, side: ray.side };
        let stands = world.spacetime.as_ref().is_none_or(|spacetime| spacetime.at(place).is_some());
        let ended = stands.then(|| self.end_in(setup, world, ray, log)).flatten();
        let (end, parameter) = ended.unwrap_or_else(|| {
            log.point(ray.origin);
            (End::Fallen, 0.0)
        });
        log.phi = parameter;
        (end.arrival(log), parameter)
    }

    /// The same; `None` if it begins where nothing can stand.
    fn end_in(&self, setup: &Setup<'_>, world: &World, ray: &Ray, log: &mut TraceLog) -> Option<(End, f64)> {
        let &Ray { origin, direction, side, .. } = ray;
        match setup {
            Setup::Straight => None,
            Setup::Spherical(hole, extent) => {
                let around = extent.around(hole.center);
                let Precision { error, gap } = self.precision(extent, ray, hole.center);
                Some(match self.method {
                    Method::RungeKutta(step) => {
                        let orbit = Orbit::by_runge_kutta(hole, origin, direction, step, around)?;
                        self.follow(world, ray, gap, orbit, log)
                    }
                    _ => self.follow(world, ray, gap, Orbit::by_series(hole, origin, direction, error, around)?, log),
                })
            }
            Setup::Index(setting) => {
                let Precision { error, gap } = self.precision(&setting.extent, ray, setting.medium.center);
                let path = setting.ray(origin, direction, side, error);
                let path = if let Method::RungeKutta(step) = self.method { path.by_runge_kutta(step) } else { path };
                Some(self.follow(world, ray, gap, path, log))
            }
            Setup::General(surroundings, depths, extent) => {
                let Precision { error, gap } = self.precision(extent, ray, surroundings.center());
                let paths: general::Paths<'_> = surroundings.start(origin, direction, side, error)?;
                Some(self.follow(world, ray, gap, GeneralRay { paths, surroundings, depths }, log))
            }
        }
    }

    fn precision(&self, extent: &Extent, ray: &Ray, center: glam::DVec3) -> Precision {
        match self.method {
            Method::Adaptive(tolerance) | Method::General(tolerance) => extent.precision(tolerance, ray.footprint, center),
            // One chord a step.
            Method::RungeKutta(_) => Precision { error: RUNGE_KUTTA_ERROR, gap: f64::INFINITY },
        }
    }

    fn follow<C: Course>(&self, world: &World, ray: &Ray, gap: f64, mut course: C, log: &mut TraceLog) -> (End, f64) {
        let &Ray { origin, direction: launch, side, leaving, .. } = ray;
        let start = Start { origin, launch, side, leaving, gap, limit: f64::INFINITY, max_steps: self.max_steps };
        follow(world, &start, &mut course, log)
    }
}

/// What a course is told of the error that is asked for, if its steps do not depend on it.
const RUNGE_KUTTA_ERROR: f64 = 1e-6;

impl Integrator for InSpacetime {
    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        self.with_setup(world, |setup| self.trace_in(setup, world, ray, log).0)
    }

    fn trace_all(&self, world: &World, rays: &[Ray], traced: &mut [Traced], log: &mut TraceLog) {
        self.with_setup(world, |setup| {
            for (ray, traced) in rays.iter().zip(traced) {
                let (arrival, phi) = self.trace_in(setup, world, ray, log);
                *traced = Traced { arrival, phi };
            }
        });
    }

    fn observer(&self, world: &World, place: Place) -> Option<Observer> {
        world.static_observer(place)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        self.connections.as_ref().map(Joining::offered)
    }

    fn is_curved(&self) -> bool {
        true
    }
}
