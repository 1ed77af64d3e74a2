//! Orbits around a round hole through a world of surfaces, with the swept angle as parameter.

use crate::spherical::Attraction;
use crate::spherical::arc::PlanarArc;
use crate::spherical::orbit::{Dense, quintic, rk4};
use crate::spherical::plane::{Planes, Polars, room};
use crate::spherical::steps::{Steps, Stretch, errors};
use crate::tracing::arc::Arc as _;
use crate::tracing::driver::{Course, Next};
use bhs_core::lanes::set_bits;
use bhs_core::real::{Mask, Real, Vector};
use bhs_core::spacetime::Spherical;
use bhs_elementary::Elementary;
use glam::DVec3;

/// How far outside of the sphere around all surfaces a curve may end that goes on to infinity: least 1/r over that of the sphere.
const NEARBY: f64 = 0.125;

/// Attempts at finding such an end.
const ATTEMPTS: u32 = 60;

/// How orbits are stepped.
pub trait Method<F: Real>: Copy {
    /// What they are stepped by.
    type Steps: Stretch<F>;

    /// Steps of no length of orbits that are at `at`.
    fn nowhere(&self, at: &Polars<F>) -> Self::Steps;

    /// Makes `steps` the next ones of orbits around `hole` that are at `start`. In their place, for they are large.
    fn step(&self, hole: Attraction, start: &Polars<F>, steps: &mut Self::Steps);
}

/// By Taylor series, with errors of u of at most so much in a step.
#[derive(Clone, Copy, Debug)]
pub struct Taylor<F>(F);

impl<F: Real> Method<F> for Taylor<F> {
    type Steps = Steps<F>;

    #[inline(always)]
    fn nowhere(&self, at: &Polars<F>) -> Steps<F> {
        Steps::nowhere(at)
    }

    #[inline(always)]
    fn step(&self, hole: Attraction, start: &Polars<F>, steps: &mut Steps<F>) {
        steps.make(hole, start, self.0);
    }
}

/// By the classic Runge-Kutta method, in steps of this angle (rad).
#[derive(Clone, Copy, Debug)]
pub struct RungeKutta(pub f64);

impl<F: Real> Method<F> for RungeKutta {
    type Steps = Steps<F>;

    #[inline(always)]
    fn nowhere(&self, at: &Polars<F>) -> Steps<F> {
        Steps::nowhere(at)
    }

    #[inline(always)]
    fn step(&self, hole: Attraction, start: &Polars<F>, steps: &mut Steps<F>) {
        let h = room(hole, start.u, start.du, F::splat(self.0));
        let (u, du) = rk4(hole, start.u, start.du, h);
        steps.follow(quintic(hole, [start.u, start.du], [u, du], h), start, h);
        // The state itself, not what the polynomial gives for it.
        (steps.end.u, steps.end.du) = (u, du);
    }
}

/// What is told once of a hole that many rays go around.
#[derive(Clone, Copy, Debug)]
pub struct SphericalSetup {
    /// Its centre.
    pub center: DVec3,
    /// The hole.
    pub hole: Attraction,
    /// 1/r of a sphere that holds all surfaces (1 / scene unit); infinite where there are none.
    bound: f64,
    /// 1/r of a sphere around those and where light goes round: beyond it no outgoing orbit turns back or meets anything.
    outside: f64,
}

impl SphericalSetup {
    /// The hole `hole` among surfaces within the distance `around` from its centre; 0: there are none.
    pub fn new(hole: &Spherical, around: f64) -> Self {
        let bound = if around > 0.0 { 1.0 / around } else { f64::INFINITY };
        let center = hole.center;
        let hole = Attraction::from(hole);
        Self { center, hole, bound, outside: bound.min(hole.photon_sphere()) }
    }

    /// The planes and initial states of rays from the points `x` in the unit chart directions `d`.
    #[inline(always)]
    pub fn launch<F: Real>(&self, x: Vector<F>, d: Vector<F>) -> InitialOrbits<F> {
        let (planes, at) = Planes::of_rays(self.center, x, d);
        InitialOrbits { setting: *self, planes, at }
    }

    /// Which orbits at `at` meet nothing any more: outside of everything and on the way out, where no orbit turns back.
    #[inline(always)]
    fn are_gone<F: Real>(&self, at: &Polars<F>) -> F::Mask {
        let c = F::splat;
        at.u.le(c(self.outside)) & at.du.le(c(0.0))
    }

    /// Which rays at `at` begin where nothing can stand, and which not at all.
    #[inline(always)]
    fn refused<F: Real>(&self, at: &Polars<F>) -> (F::Mask, F::Mask) {
        let inside = at.u.ge(F::splat(self.hole.horizon));
        (inside, !inside & !(at.u.gt(F::splat(0.0)) & at.du.is_finite()))
    }

    /// Where those of the curves `piece` of steps that leave for infinity end: outside of all surfaces, but not far.
    #[cold]
    fn ends<F: Real, S: Stretch<F>>(&self, piece: &PlanarArc<F, S>, leaving: F::Mask) -> F {
        let c = F::splat;
        let (start, end) = (*piece.stretch.start(), *piece.stretch.end());
        let (bound, near) = (c(self.bound), c(NEARBY * self.bound));
        // Where a straight line would have it.
        let wanted = c(0.5 * (1.0 + NEARBY) * self.bound);
        let share = ((start.u - wanted) / (start.u - end.u)).max(c(0.01)).min(c(0.99));
        let guess = start.phi + share * (end.phi - start.phi);
        let u = piece.inverse_radius(guess);
        let all = F::select(leaving, guess, end.phi);
        let rest = (leaving & !(u.le(bound) & u.ge(near))).bits();
        if rest == 0 {
            return all;
        }
        F::from_fn(|i| if rest >> i & 1 == 1 { self.end(&piece.lane(i)) } else { all.lane(i) })
    }

    /// The same of one, by bisection from infinity inwards.
    fn end<S: Stretch<f64>>(&self, piece: &PlanarArc<f64, S>) -> f64 {
        let (mut inside, mut outside) = (piece.stretch.start().phi, piece.stretch.end().phi);
        for _ in 0..ATTEMPTS {
            let middle = 0.5 * (inside + outside);
            let u = piece.inverse_radius(middle);
            if u > self.bound {
                inside = middle;
            } else if u < NEARBY * self.bound {
                outside = middle;
            } else {
                return middle;
            }
        }
        inside
    }
}

/// Orbits that begin.
#[derive(Clone, Copy, Debug)]
pub struct InitialOrbits<F> {
    setting: SphericalSetup,
    planes: Planes<F>,
    /// Their initial states.
    pub at: Polars<F>,
}

impl<F: Real> InitialOrbits<F> {
    /// The orbits by Taylor series, with errors of about `error` times the distance from the hole.
    #[inline(always)]
    pub fn by_series(self, error: F) -> Orbits<F, Taylor<F>> {
        let method = Taylor(errors(self.setting.hole, &self.at, error));
        self.by(method)
    }

    /// The orbits, stepped by `method`.
    #[inline(always)]
    pub fn by<M: Method<F>>(self, method: M) -> Orbits<F, M> {
        let Self { setting, planes, at } = self;
        let stretch = method.nowhere(&at);
        let piece = PlanarArc { hole: setting.hole, planes, stretch, end: at.phi };
        Orbits { setting, method, at, piece }
    }
}

/// Orbits underway.
#[derive(Clone, Copy)]
pub struct Orbits<F: Real, M: Method<F>> {
    setting: SphericalSetup,
    method: M,
    at: Polars<F>,
    piece: PlanarArc<F, M::Steps>,
}

impl<F: Real, M: Method<F>> Course<F> for Orbits<F, M> {
    type Piece = PlanarArc<F, M::Steps>;

    #[inline(always)]
    fn begin(&self) -> (F::Mask, F::Mask) {
        self.setting.refused(&self.at)
    }

    #[inline(always)]
    fn advance(&mut self, which: F::Mask) -> Next<F> {
        let c = F::splat;
        let SphericalSetup { hole, bound, .. } = self.setting;
        let start = self.at;
        self.method.step(hole, &start, &mut self.piece.stretch);
        let end = *self.piece.stretch.end();
        self.at = end;
        let (captured, escaped) = (which & end.u.ge(c(hole.horizon)), which & end.u.le(c(0.0)));
        let gone = self.setting.are_gone(&start);
        let mut ends = F::select(gone, start.phi, end.phi);
        let leaving = which & !gone & end.u.lt(c(NEARBY * bound)) & !captured;
        if leaving.any() {
            ends = F::select(leaving, self.setting.ends(&self.piece, leaving), ends);
        }
        let mut until = end.phi;
        if captured.any() {
            let horizon = at_horizon(&self.piece, captured);
            ends = F::select(captured, horizon, ends);
            until = F::select(captured, horizon, until);
        }
        self.piece.end = ends;
        Next { until, crosses: F::Mask::NONE, escapes: escaped, falls: captured, lost: F::Mask::NONE }
    }

    #[inline(always)]
    fn piece(&self) -> &PlanarArc<F, M::Steps> {
        &self.piece
    }

    fn directions(&mut self, which: F::Mask, mut found: impl FnMut(usize, Option<DVec3>, f64)) {
        let PlanarArc { planes, stretch, .. } = &self.piece;
        let (far, right) = stretch.at_infinity();
        let directions = (planes.e1 * far.cos).plus(planes.e2, far.sin);
        let right = right.bits();
        for i in set_bits(which.bits()) {
            if right >> i & 1 == 1 {
                found(i, Some(directions.lane(i)), far.phi.lane(i));
            } else {
                let phi = crossing(&stretch.lane(i), 0.0);
                let (sin, cos) = phi.sine_cosine();
                found(i, Some(planes.e1.lane(i) * cos + planes.e2.lane(i) * sin), phi);
            }
        }
    }
}

/// The angle at which 1/r passes `target` on a stretch.
fn crossing<D: Dense>(stretch: &D, target: f64) -> f64 {
    stretch.crossing(stretch.start(), stretch.end(), target).phi
}

/// The angles at which those of the orbits `captured` reach the horizon.
#[cold]
fn at_horizon<F: Real, S: Stretch<F>>(piece: &PlanarArc<F, S>, captured: F::Mask) -> F {
    let is_captured = |i: usize| captured.bits() >> i & 1 == 1;
    F::from_fn(|i| if is_captured(i) { crossing(&piece.stretch.lane(i), piece.hole.horizon) } else { 0.0 })
}
