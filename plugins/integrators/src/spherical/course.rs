//! Orbits around a round hole through a world of surfaces, with the swept angle as parameter.

use crate::spherical::Attraction;
use crate::spherical::arc::PlanarArc;
use crate::spherical::orbit::{Dense, Fate, OrbitPlane, Rk4Orbit, State, Step, Stepper};
use crate::spherical::taylor::{TaylorOrbit, TaylorStep};
use crate::tracing::arc::Arc;
use crate::tracing::driver::{Course, Next};
use bhs_core::spacetime::Spherical;
use glam::DVec3;

/// How far beyond all surfaces the last curve of an orbit ends: 1/r over that of the sphere around them.
const BEYOND: f64 = 0.5;

/// An orbit underway.
#[derive(Clone, Debug)]
pub struct Ray<S> {
    orbit: S,
    hole: Attraction,
    plane: OrbitPlane,
    /// 1/r of a sphere around all surfaces and where light goes round (1 / scene unit).
    outside: f64,
}

/// A step of an orbit that is a curve.
pub trait Curve: Dense {
    /// The curve.
    fn arc(&self, hole: Attraction, plane: &OrbitPlane) -> PlanarArc<f64>;
}

impl Curve for TaylorStep {
    fn arc(&self, hole: Attraction, plane: &OrbitPlane) -> PlanarArc<f64> {
        PlanarArc::of_taylor(hole, plane, self)
    }
}

impl Curve for Step {
    fn arc(&self, _: Attraction, plane: &OrbitPlane) -> PlanarArc<f64> {
        PlanarArc::of_runge_kutta(plane, self)
    }
}

/// The plane and the first state of the orbit around `hole` from `x` in the direction `d`, if that is no place at or inside the horizon.
fn launch(hole: &Spherical, x: DVec3, d: DVec3) -> Option<(OrbitPlane, State)> {
    hole.at(x)?;
    let (plane, state) = OrbitPlane::of_ray(hole.center, x, d);
    (state.u > 0.0 && state.du.is_finite()).then_some((plane, state))
}

/// 1/r of a sphere that holds all within `around` of the hole, and where light goes round.
fn outside(hole: &Attraction, around: f64) -> f64 {
    BEYOND * hole.photon_sphere().min(1.0 / around)
}

impl Ray<TaylorOrbit> {
    /// The ray from `x` along `d`, by Taylor series with errors of about `error` times the distance from the hole, among surfaces within the distance
    /// `around` from it. `None` where nothing can stand.
    pub fn by_series(hole: &Spherical, x: DVec3, d: DVec3, error: f64, around: f64) -> Option<Self> {
        let (plane, state) = launch(hole, x, d)?;
        let hole = Attraction::from(hole);
        Some(Self { orbit: TaylorOrbit::new(hole, state, error), hole, plane, outside: outside(&hole, around) })
    }
}

impl Ray<Rk4Orbit> {
    /// The same by the classic Runge-Kutta method with steps of the angle `step` (rad).
    pub fn by_runge_kutta(hole: &Spherical, x: DVec3, d: DVec3, step: f64, around: f64) -> Option<Self> {
        let (plane, state) = launch(hole, x, d)?;
        let hole = Attraction::from(hole);
        Some(Self { orbit: Rk4Orbit { hole, step, state }, hole, plane, outside: outside(&hole, around) })
    }
}

impl<S: Stepper> Course for Ray<S>
where
    S::Step: Curve,
{
    type Piece = PlanarArc<f64>;

    fn advance(&mut self) -> (PlanarArc<f64>, Next) {
        let (step, fate) = self.orbit.advance();
        let next = match fate {
            Fate::Underway => Next::GoesOn,
            Fate::Captured => Next::Falls,
            Fate::Escaped => {
                let parameter = step.within_space(self.hole).end().phi;
                Next::Escapes { direction: self.plane.radial(parameter), parameter }
            }
        };
        let start = step.start();
        let step = if fate == Fate::Captured { step.within_space(self.hole) } else { step };
        let arc = step.arc(self.hole, &self.plane);
        // Outside of everything and on the way out no orbit turns back; and its points there need not be finite.
        let gone = start.u <= self.outside && start.du <= 0.0;
        (if gone { arc.until(start.phi) } else { arc.before(self.outside) }, next)
    }
}
