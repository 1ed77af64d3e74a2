//! Long steps of orbits by Taylor series (`series`), of one ray or several side by side.

use crate::arithmetic::polynomial::{TERMS, cos_sin, value, value_and_slope};
use crate::spherical::Attraction;
use crate::spherical::orbit::Dense;
use crate::spherical::plane::{Polars, room};
use crate::spherical::series::{LONGEST, LONGEST_POWER, SAFETY, coefficients, root};
use bhs_core::lanes::{LANES, set_bits};
use bhs_core::real::{Mask, Real};

/// Newton's corrections of the angle at which an orbit reaches infinity.
const MOST_CORRECTIONS: u32 = 8;

/// Largest errors of u in a step of orbits that are at `start`, if their points are to stray from the true ones by about `relative` times the
/// distance from the hole, as far as double precision goes.
///
/// An error of u moves a point across the ray by its ratio to 1/b times r. Near the critical impact parameter more is asked of a step: there an
/// error on the way in changes `epsilon = (rs/b)^2 - 4/27`, and the angle at which the ray leaves by the relative change of epsilon. What cannot
/// be asked for is an epsilon better than rounding: the angle is uncertain by some 1e-15/|epsilon|.
#[inline(always)]
pub fn errors<F: Real>(hole: impl Into<Attraction>, start: &Polars<F>, relative: F) -> F {
    let c = F::splat;
    let (hole, Polars { u, du, .. }) = (hole.into(), *start);
    if hole.is_charged() {
        let barrier = u * u * u.times_plus(u.times_plus(c(hole.charge_squared), c(-hole.rs)), c(1.0));
        let inverse_b_squared = du.times_plus(du, barrier);
        let closeness = ((inverse_b_squared - c(hole.critical)).abs() / inverse_b_squared).min(c(1.0));
        return inverse_b_squared.sqrt() * (c(SAFETY) * relative * closeness).max(c(0.5 * f64::EPSILON));
    }
    let rs = hole.rs;
    let inverse_b_squared = du.times_plus(du, u * u * u.times_plus(c(-rs), c(1.0)));
    let scaled = inverse_b_squared * c(rs * rs);
    let closeness = ((scaled - c(4.0 / 27.0)).abs() / scaled).min(c(1.0));
    inverse_b_squared.sqrt() * (c(SAFETY) * relative * closeness).max(c(0.5 * f64::EPSILON))
}

/// One Taylor step of each orbit.
#[derive(Clone, Copy)]
pub struct Steps<F> {
    pub(super) c: [F; TERMS],
    /// Where they begin.
    pub start: Polars<F>,
    /// Where they end.
    pub end: Polars<F>,
}

impl<F: Real> Steps<F> {
    /// Makes these the steps from `start` of the orbits around `hole`, with errors of u of at most `error`.
    #[inline]
    pub fn make(&mut self, hole: impl Into<Attraction>, start: &Polars<F>, error: F) {
        let (one, hole) = (F::splat, hole.into());
        let c = coefficients(&hole, start.u, start.du);
        // The last two coefficients, for one of them is zero where the orbit is symmetric; as no step is longer than LONGEST, the very last counts
        // for no more than so many times the one before. And two more, for coefficients change sign and may be small by chance: these would
        // shrink by 8 or so if the nearest pole were some 3 rad away, as it is near the hole.
        let pair = |n: usize| one(LONGEST).times_plus(c[n + 1].abs(), c[n].abs());
        let share = error / pair(TERMS - 4).times_plus(one(0.125), pair(TERMS - 2));
        // Most steps may be the longest: the root, which costs as much as a fifth of the step, is not needed for that.
        let shorter = (!share.ge(one(LONGEST_POWER))).bits();
        let mut longest = [LONGEST; LANES];
        let shares = share.to_array();
        for i in set_bits(shorter) {
            longest[i] = root(shares[i]);
        }
        let h = room(hole, start.u, start.du, F::from_fn(|i| longest[i]));
        self.follow(c, start, h);
    }

    /// Steps of no length.
    #[inline(always)]
    pub fn nowhere(at: &Polars<F>) -> Self {
        Self { c: [F::splat(0.0); TERMS], start: *at, end: *at }
    }

    /// The steps from `start` of the orbits around `hole`, with errors of u of at most `error`.
    pub fn from(hole: impl Into<Attraction>, start: &Polars<F>, error: F) -> Self {
        let mut steps = Self::nowhere(start);
        steps.make(hole, start, error);
        steps
    }

    /// Makes these the steps along which 1/r is the polynomial `c` in the angle since `start`, of the angles `h`.
    #[inline(always)]
    pub fn follow(&mut self, c: [F; TERMS], start: &Polars<F>, h: F) {
        (self.c, self.start) = (c, *start);
        self.end = self.polar(start.phi + h);
    }

    /// Which orbits have reached infinity.
    fn escaped(&self) -> F::Mask {
        self.end.u.le(F::splat(0.0))
    }

    /// The angles at which the orbits reach infinity, and of which of them they are right (Newton's method; [`Dense::crossing`] finds the others).
    #[inline(always)]
    fn angles_at_infinity(&self) -> (Polars<F>, F::Mask) {
        let c = F::splat;
        let width = self.end.phi - self.start.phi;
        let mut t = width * (self.start.u / (self.start.u - self.end.u)).max(c(0.0)).min(c(1.0));
        let mut right = F::Mask::NONE;
        for _ in 0..MOST_CORRECTIONS {
            let (u, du) = value_and_slope(&self.c, t);
            let change = u / du;
            t = F::select(right, t, t - change);
            right = right | (change.abs().le(c(1e-8) * width) & t.ge(c(0.0)) & t.le(width));
            if (right | !self.escaped()).all() {
                break;
            }
        }
        (self.polar(self.start.phi + t), right)
    }

    /// Cosines and sines of the angles `t` after the start.
    #[inline(always)]
    fn cos_sin(&self, t: F) -> (F, F) {
        let (cos, sin) = cos_sin(t);
        let Polars { cos: c0, sin: s0, .. } = self.start;
        (c0 * cos - s0 * sin, s0.times_plus(cos, c0 * sin))
    }
}

/// A stretch of an orbit, or of several around the same hole, with their states at any angle.
pub trait Stretch<F: Real>: Copy {
    /// That of one of the orbits.
    type One: Stretch<f64> + Dense;

    /// Where it begins.
    fn start(&self) -> &Polars<F>;

    /// Where it ends.
    fn end(&self) -> &Polars<F>;

    /// The states at the angles `phi`.
    fn polar(&self, phi: F) -> Polars<F>;

    /// 1/r at the angles `phi`, with their cosines and sines.
    #[inline(always)]
    fn place(&self, phi: F) -> (F, F, F) {
        let Polars { u, cos, sin, .. } = self.polar(phi);
        (u, cos, sin)
    }

    /// 1/r at the angles `phi`.
    #[inline(always)]
    fn inverse_radius(&self, phi: F) -> F {
        self.polar(phi).u
    }

    /// Where the orbits reach infinity, and of which of them that is right: [`Dense::crossing`] finds the others.
    #[inline(always)]
    fn at_infinity(&self) -> (Polars<F>, F::Mask) {
        (*self.end(), F::Mask::NONE)
    }

    /// That of ray number `i`, as one ray by itself has it.
    fn lane(&self, i: usize) -> Self::One;
}

impl<F: Real> Stretch<F> for Steps<F> {
    type One = Steps<f64>;

    #[inline(always)]
    fn start(&self) -> &Polars<F> {
        &self.start
    }

    #[inline(always)]
    fn end(&self) -> &Polars<F> {
        &self.end
    }

    #[inline(always)]
    fn polar(&self, phi: F) -> Polars<F> {
        let t = phi - self.start.phi;
        let (cos, sin) = self.cos_sin(t);
        let (u, du) = value_and_slope(&self.c, t);
        Polars { phi, u, du, cos, sin }
    }

    #[inline(always)]
    fn place(&self, phi: F) -> (F, F, F) {
        let (cos, sin) = self.cos_sin(phi - self.start.phi);
        (self.inverse_radius(phi), cos, sin)
    }

    #[inline(always)]
    fn inverse_radius(&self, phi: F) -> F {
        value(&self.c, phi - self.start.phi)
    }

    #[inline(always)]
    fn at_infinity(&self) -> (Polars<F>, F::Mask) {
        self.angles_at_infinity()
    }

    fn lane(&self, i: usize) -> Steps<f64> {
        Steps { c: self.c.map(|c| c.lane(i)), start: self.start.lane(i), end: self.end.lane(i) }
    }
}
