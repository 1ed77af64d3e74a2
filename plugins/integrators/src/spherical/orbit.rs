//! Light orbits around a round hole, stepped in the swept angle. Knows no surfaces.
//!
//! An orbit lies in the plane of the hole's centre, the ray's origin and its direction. There, with u(phi) = 1/r,
//!
//! `u'' = (3/2) rs u^2 - 2 q^2 u^3 - u`,  `u(0) = 1/r0`,  `u'(0) = -cot(alpha)/r0`,  `u'^2 = 1/b^2 - u^2 + rs u^3 - q^2 u^4`
//!
//! where alpha is the chart angle between the direction and the outward radius (Aikawa, Zhou and Wang 2019, section 2).
//! `u'` is carried from step to step: restarting from the direction of the previous chord would halve the bending.

use crate::arithmetic::polynomial::{TERMS, value_and_slope};
use crate::spherical::Attraction;
use crate::spherical::plane::{self, Planes};
use bhs_core::real::{Real, Vector};
use bhs_elementary::Elementary;
use glam::DVec3;

/// The plane of an orbit: positions and directions from (u, u', phi).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitPlane {
    /// The hole's centre.
    pub center: DVec3,
    /// Unit vector from the centre to the ray's origin: phi = 0.
    pub e1: DVec3,
    /// Unit vector across it on the side that the ray moves to: phi = 90 degrees.
    pub e2: DVec3,
}

/// A place on an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Angle swept since the start, in radians.
    pub phi: f64,
    /// 1/r.
    pub u: f64,
    /// du/dphi.
    pub du: f64,
}

impl OrbitPlane {
    /// The plane and the initial state of a ray with unit chart direction; `origin` is not the centre.
    pub fn of_ray(center: DVec3, origin: DVec3, direction: DVec3) -> (Self, State) {
        let (planes, at) = Planes::of_rays(center, Vector::from(origin), Vector::from(direction));
        (Self { center, e1: planes.e1.into(), e2: planes.e2.into() }, State { phi: at.phi, u: at.u, du: at.du })
    }

    /// Unit vector from the centre at the angle `phi`.
    pub fn radial(&self, phi: f64) -> DVec3 {
        let (sin, cos) = phi.sine_cosine();
        self.e1 * cos + self.e2 * sin
    }

    /// The point of a state with u > 0.
    pub fn point(&self, s: &State) -> DVec3 {
        self.center + self.radial(s.phi) / s.u
    }

    /// The angle swept at `point`, a little ahead of the place `from`, which is not the centre and at which it is `phi`, in radians.
    pub fn angle(&self, phi: f64, from: DVec3, point: DVec3) -> f64 {
        let (outward, p) = (from - self.center, point - self.center);
        let ahead = self.e1.cross(self.e2).cross(outward);
        phi + p.dot(ahead).arctangent2(p.dot(outward))
    }

    /// The unit chart tangent of a state, along the way of the ray: proportional to `-u' e_r + u e_phi`.
    pub fn direction(&self, s: &State) -> DVec3 {
        let State { phi, u, du } = *s;
        let (sin, cos) = phi.sine_cosine();
        // Components along e1 and e2, which are unit vectors at right angles.
        let (x, y) = (-u * sin - du * cos, u * cos - du * sin);
        let scale = 1.0 / (x * x + y * y).sqrt();
        self.e1 * (x * scale) + self.e2 * (y * scale)
    }
}

/// How an orbit goes on after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It can be stepped further.
    Underway,
    /// The step reaches infinity, u = 0, and may go on beyond it.
    Escaped,
    /// The step reaches the horizon, and may go on behind it.
    Captured,
}

/// Goes along an orbit.
pub trait Stepper {
    /// What it goes by.
    type Step: Dense;
    /// Takes one step and says how the orbit goes on. Where the last one leaves space is left to [`Dense::within_space`], for it
    /// takes as long to find out as some steps, and rays mostly end on a surface before. Not to be called after the orbit has
    /// ended.
    fn advance(&mut self) -> (Self::Step, Fate);
}

/// A stretch of an orbit with dense output: its state at any angle.
pub trait Dense: Copy {
    /// Where it begins.
    fn start(&self) -> State;
    /// Where it ends.
    fn end(&self) -> State;
    /// The state at the angle `phi` within the stretch.
    fn at(&self, phi: f64) -> State;
    /// u at the angle `phi` within the stretch, and the angle's cosine and sine.
    #[inline]
    fn place(&self, phi: f64) -> (f64, f64, f64) {
        let (sin, cos) = phi.sine_cosine();
        (self.at(phi).u, cos, sin)
    }
    /// The stretch cut short at `end`, one of its own states.
    fn until(self, end: State) -> Self;

    /// The state between `from` and `to` at which u passes `target`, which lies between the values there (Newton, kept in
    /// bounds by bisection).
    fn crossing(&self, from: State, to: State, target: f64) -> State {
        let rising = to.u > from.u;
        let (mut lo, mut hi) = (from.phi, to.phi);
        let width = hi - lo;
        let mut phi = lo + (hi - lo) * ((target - from.u) / (to.u - from.u)).clamp(0.0, 1.0);
        let mut s = self.at(phi);
        for _ in 0..60 {
            if (s.u < target) == rising {
                lo = s.phi;
            } else {
                hi = s.phi;
            }
            let newton = s.phi - (s.u - target) / s.du;
            let inside = newton > lo && newton < hi;
            phi = if inside { newton } else { 0.5 * (lo + hi) };
            let change = (phi - s.phi).abs();
            s = self.at(phi);
            // Newton's method squares what is left of the stretch: a step as small as this was the last one.
            if (inside && change <= 1e-8 * width) || change <= 2.0 * f64::EPSILON * phi {
                break;
            }
        }
        State { u: target, ..s }
    }

    /// How the orbit goes on after the stretch.
    fn fate(&self, hole: impl Into<Attraction>) -> Fate {
        match self.end().u {
            u if u >= hole.into().horizon => Fate::Captured,
            u if u <= 0.0 => Fate::Escaped,
            _ => Fate::Underway,
        }
    }

    /// The part of the stretch that lies outside the horizon and this side of infinity.
    fn within_space(self, hole: impl Into<Attraction>) -> Self {
        let hole = hole.into();
        let target = match self.fate(hole) {
            Fate::Captured => hole.horizon,
            Fate::Escaped => 0.0,
            Fate::Underway => return self,
        };
        self.until(self.crossing(self.start(), self.end(), target))
    }
}

/// The angle `step`, or less where the orbit ends before, in radians.
pub fn room(hole: impl Into<Attraction>, s: &State, step: f64) -> f64 {
    plane::room(hole, s.u, s.du, step)
}

/// One step of the classic fourth-order Runge-Kutta method for the orbit equation: (u, u') after the angle `h`.
/// Generic over the number type, so that lanes of several orbits can be stepped together.
pub fn rk4<F: Real>(hole: impl Into<Attraction>, u: F, du: F, h: F) -> (F, F) {
    let hole = hole.into();
    let bend = F::splat(1.5) * F::splat(hole.rs);
    let repulsion = F::splat(2.0 * hole.charge_squared);
    let force = |u: F| {
        let force = bend * u * u - u;
        if hole.is_charged() { force - repulsion * u * u * u } else { force }
    };
    let (half, sixth, two) = (F::splat(0.5) * h, F::splat(1.0 / 6.0) * h, F::splat(2.0));
    let (k1u, k1v) = (du, force(u));
    let (k2u, k2v) = (du + half * k1v, force(u + half * k1u));
    let (k3u, k3v) = (du + half * k2v, force(u + half * k2u));
    let (k4u, k4v) = (du + h * k3v, force(u + h * k3u));
    (u + sixth * (k1u + two * (k2u + k3u) + k4u), du + sixth * (k1v + two * (k2v + k3v) + k4v))
}

/// A step of [`Rk4Orbit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// What it goes around.
    pub hole: Attraction,
    /// Where it begins.
    pub start: State,
    /// Where it ends.
    pub end: State,
}

impl Step {
    /// The coefficients of u as a polynomial in the angle since the start.
    fn quintic(&self) -> [f64; TERMS] {
        let State { phi, u, du } = self.start;
        quintic(self.hole, [u, du], [self.end.u, self.end.du], self.end.phi - phi)
    }
}

/// The coefficients of the quintic, in the angle since the start, that has u, u' and u'' in common with an orbit around `hole` at both ends of a step
/// of the angle `h`, where (u, u') are `start` and `end` (order 6, above that of the steps).
pub fn quintic<F: Real>(hole: Attraction, start: [F; 2], end: [F; 2], h: F) -> [F; TERMS] {
    let c = F::splat;
    let force = |u: F| {
        let force = u * (c(1.5 * hole.rs) * u - c(1.0));
        if hole.is_charged() { force - c(2.0 * hole.charge_squared) * u * u * u } else { force }
    };
    let [u0, u1] = [start[0], end[0]];
    let [v0, v1] = [start[1], end[1]].map(|v| v * h);
    let [a0, a1] = [u0, u1].map(|u| force(u) * h * h);
    let rise = u1 - u0;
    let c3 = c(10.0) * rise - c(6.0) * v0 - c(4.0) * v1 - c(1.5) * a0 + c(0.5) * a1;
    let c4 = c(-15.0) * rise + c(8.0) * v0 + c(7.0) * v1 + c(1.5) * a0 - a1;
    let c5 = c(6.0) * rise - c(3.0) * (v0 + v1) - c(0.5) * (a0 - a1);
    let per_angle = c(1.0) / h;
    let (mut terms, mut scale) = ([c(0.0); TERMS], c(1.0));
    for (term, share) in terms.iter_mut().zip([u0, v0, c(0.5) * a0, c3, c4, c5]) {
        *term = share * scale;
        scale = scale * per_angle;
    }
    terms
}

impl Dense for Step {
    fn start(&self) -> State {
        self.start
    }

    fn end(&self) -> State {
        self.end
    }

    fn at(&self, phi: f64) -> State {
        let (u, du) = value_and_slope(&self.quintic(), phi - self.start.phi);
        State { phi, u, du }
    }

    fn until(self, end: State) -> Self {
        Self { end, ..self }
    }
}

/// An orbit stepped by [`rk4`] with a fixed angle.
#[derive(Clone, Copy, Debug)]
pub struct Rk4Orbit {
    /// What it goes around.
    pub hole: Attraction,
    /// Angle of a step, in radians.
    pub step: f64,
    /// Where the orbit is.
    pub state: State,
}

impl Stepper for Rk4Orbit {
    type Step = Step;

    fn advance(&mut self) -> (Step, Fate) {
        let h = room(self.hole, &self.state, self.step);
        let (u, du) = rk4(self.hole, self.state.u, self.state.du, h);
        let step = Step { hole: self.hole, start: self.state, end: State { phi: self.state.phi + h, u, du } };
        self.state = step.end;
        (step, step.fate(self.hole))
    }
}
