//! The planes of orbits, of one ray or several side by side, and their states in these.

use crate::arithmetic::polynomial::small_arc_tangent;
use crate::spherical::Attraction;
use bhs_core::real::{Mask, Real, Vector};
use glam::DVec3;

/// States of orbits, with cosines and sines of their angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polars<F> {
    /// Angles swept (rad).
    pub phi: F,
    /// 1/r.
    pub u: F,
    /// du/dphi.
    pub du: F,
    /// cos(phi).
    pub cos: F,
    /// sin(phi).
    pub sin: F,
}

impl<F: Real> Polars<F> {
    /// The state of ray number `i`.
    pub fn lane(&self, i: usize) -> Polars<f64> {
        let [phi, u, du, cos, sin] = [self.phi, self.u, self.du, self.cos, self.sin].map(|l| l.lane(i));
        Polars { phi, u, du, cos, sin }
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(&self, o: &Self, which: F::Mask) -> Self {
        Self {
            phi: F::select(which, self.phi, o.phi),
            u: F::select(which, self.u, o.u),
            du: F::select(which, self.du, o.du),
            cos: F::select(which, self.cos, o.cos),
            sin: F::select(which, self.sin, o.sin),
        }
    }
}

/// The planes of orbits, around one centre.
#[derive(Clone, Copy, Debug)]
pub struct Planes<F> {
    /// The hole's centre.
    pub center: DVec3,
    /// Unit vectors from the centre to where the orbits begin.
    pub e1: Vector<F>,
    /// Unit vectors across them.
    pub e2: Vector<F>,
}

/// Least sine of the angle between a ray and the radius. A radial ray sweeps no angle at all; this close to it, the orbit is a radial line to far
/// below rounding, and the same equations serve.
const LEAST_SINE: f64 = 1e-30;

impl<F: Real> Planes<F> {
    /// The planes and initial states of rays with unit chart directions, none of which starts at the centre.
    #[inline(always)]
    pub fn of_rays(center: DVec3, origin: Vector<F>, direction: Vector<F>) -> (Self, Polars<F>) {
        let c = F::splat;
        let one = c(1.0);
        let from_center = origin - Vector::all(center);
        // Without fused operations: critical orbits feel each rounding.
        let dot = |a: Vector<F>, b: Vector<F>| a.x * b.x + a.y * b.y + a.z * b.z;
        let r0 = dot(from_center, from_center).sqrt();
        let e1 = from_center.over(r0);
        let cos = dot(direction, e1);
        // Twice is enough (Kahan): the second projection removes what rounding left of the radial part.
        let across = direction - e1 * cos;
        let across = across - e1 * dot(across, e1);
        let length = dot(across, across).sqrt();
        let sin = length.max(c(LEAST_SINE));
        let start = Polars { phi: c(0.0), u: one / r0, du: -cos / (sin * r0), cos: one, sin: c(0.0) };
        let mut e2 = across.over(sin);
        let radial = length.le(c(LEAST_SINE));
        if radial.any() {
            e2 = any_across(e1).or(e2, radial);
        }
        (Self { center, e1, e2 }, start)
    }

    /// The points at 1/r = `u`, where cosine and sine of the angle are these.
    #[inline(always)]
    pub fn points(&self, u: F, cos: F, sin: F) -> Vector<F> {
        let r = F::splat(1.0) / u;
        Vector::all(self.center).plus(self.e1, cos * r).plus(self.e2, sin * r)
    }

    /// The angles, of less than half a turn, from the points `from` to the points `to` of the planes (rad): to 1e-5 for those of less than 0.8.
    #[inline(always)]
    pub fn angles(&self, from: Vector<F>, to: Vector<F>) -> F {
        let center = Vector::all(self.center);
        let (from, to) = (from - center, to - center);
        let (x0, y0) = (from.dot(self.e1), from.dot(self.e2));
        let (x, y) = (to.dot(self.e1), to.dot(self.e2));
        let (along, across) = (x0 * x + y0 * y, x0 * y - y0 * x);
        // Twice the angle whose tangent is that of half the angle.
        F::splat(2.0) * small_arc_tangent(across / (along + along.times_plus(along, across * across).sqrt()))
    }

    /// The plane of ray number `i`.
    pub fn lane(&self, i: usize) -> Planes<f64> {
        Planes { center: self.center, e1: self.e1.lane(i).into(), e2: self.e2.lane(i).into() }
    }
}

/// How far a step may overshoot the end of the orbit, relative to the distance to it if u' stayed as it is. A near-radial ray
/// reaches the horizon or infinity within far less than a fixed angle, and must not be thrown to u = 1e12 by it.
pub(crate) const OVERSHOOT: f64 = 1.5;

/// The angles `step`, or less where orbits at 1/r = `u`, with its derivative `du` by the angle, end before (rad).
#[inline(always)]
pub fn room<F: Real>(hole: impl Into<Attraction>, u: F, du: F, step: F) -> F {
    let c = F::splat;
    let down = du.gt(c(0.0));
    let room = F::select(down, c(hole.into().horizon) - u, -u) / du;
    F::select(room.gt(c(0.0)), step.min(c(OVERSHOOT) * room), step)
}

/// Unit vectors at right angles to the unit vectors `e`.
#[cold]
fn any_across<F: Real>(e: Vector<F>) -> Vector<F> {
    Vector::from_fn(|i| e.lane(i).any_orthonormal_vector())
}
