//! Where rays of a refractive index go that leave for ever (`docs/physics.md`, section 6).
//!
//! With `x = center + n/u`, `|n| = 1`, and a parameter tau with `dsigma = dtau/u^2`, the ray has
//!
//! `u'' = -g.n / u^2 - u |n'|^2`,  `n'' = (g - n g.n) / u^3 - |n'|^2 n`,  `g = grad(n^2)/2` of the index
//!
//! Infinity is an ordinary place there: u = 0, after a finite tau, with u' = -1. A few steps lead to it, where the distance itself would need
//! one for every few times that it grows.

use crate::arithmetic::dormand_prince::{error, step};
use crate::arithmetic::space::Space;
use crate::graded_index::medium::{Medium, Refracted};
use bhs_core::real::{Mask, Real, Vector};
use bhs_elementary::Elementary;

/// A place far out: inverse distance and its derivative, direction and its.
#[derive(Clone, Copy, Debug)]
struct Far<F> {
    u: F,
    w: F,
    n: Vector<F>,
    m: Vector<F>,
}

impl<F: Real> Space<F> for Far<F> {
    #[inline(always)]
    fn plus(self, o: Self, s: F) -> Self {
        Self { u: o.u.times_plus(s, self.u), w: o.w.times_plus(s, self.w), n: self.n.plus(o.n, s), m: self.m.plus(o.m, s) }
    }

    #[inline(always)]
    fn times(self, s: F) -> Self {
        Self { u: self.u * s, w: self.w * s, n: self.n * s, m: self.m * s }
    }

    #[inline(always)]
    fn or(self, o: Self, which: F::Mask) -> Self {
        Self {
            u: F::select(which, self.u, o.u),
            w: F::select(which, self.w, o.w),
            n: self.n.or(o.n, which),
            m: self.m.or(o.m, which),
        }
    }
}

#[inline(always)]
fn slope<F: Refracted>(medium: &Medium<'_>, y: Far<F>) -> Far<F> {
    let r = F::splat(1.0) / y.u;
    let (_, g) = medium.at(Vector::all(medium.center).plus(y.n, r));
    let (radial, turning) = (g.dot(y.n), y.m.length_squared());
    let w = -(radial * r * r) - y.u * turning;
    let m = (g.plus(y.n, -radial) * (r * r * r)).plus(y.n, -turning);
    Far { u: y.w, w, n: y.m, m }
}

/// Smallest share of the inverse distance that a step leaves over.
const LEFT: f64 = 0.05;

/// Attempted steps.
const MOST_STEPS: u32 = 60;

/// The directions in which the rays `which` at `x` with the tangents `v` leave, and of which of them they are right: to about `tolerance` (rad) for
/// those that move away from the middle of `medium`, outside of `medium.far`.
pub fn directions<F: Refracted>(
    medium: &Medium<'_>,
    x: Vector<F>,
    v: Vector<F>,
    tolerance: F,
    which: F::Mask,
) -> (Vector<F>, F::Mask) {
    let c = F::splat;
    let from_center = x - Vector::all(medium.center);
    let r = from_center.length();
    let n = from_center * (c(1.0) / r);
    let out = v.dot(n);
    let mut y = Far { u: c(1.0) / r, w: -out, n, m: v.plus(n, -out) * r };
    let mut slope_here = slope(medium, y);
    // What is left of the way is done with the first two derivatives; the third is of the order of these lengths cubed.
    let extent = c(0.25 * medium.far).max(y.m.length());
    let near_enough = F::from_fn(|i| tolerance.lane(i).cube_root()) / extent;
    let mut todo = which & out.gt(c(0.0));
    let asked = todo;
    // As is the first guess of the length of the steps to come.
    let mut most = c(f64::INFINITY);
    for _ in 0..MOST_STEPS {
        todo = todo & y.u.gt(near_enough);
        if !todo.any() {
            break;
        }
        let target = (y.u * c(LEFT)).max(near_enough * c(0.5));
        let h = time_to(&y, &slope_here, target).min(most);
        let attempt = step(|y| slope(medium, y), y, slope_here, h);
        let errors = attempt.errors.map(|e| e.n.length().max(e.u.abs() * extent));
        let share = error(errors) / tolerance;
        let good = todo & share.le(c(1.0)) & attempt.end.u.gt(c(0.0));
        // (1/share)^(1/8), within bounds.
        let factor = c(0.8) / share.max(c(1e-4)).sqrt().sqrt().sqrt();
        let factor = F::select(factor.ge(c(0.2)), factor, c(0.2));
        most = F::select(todo, h * F::select(good, factor.max(c(1.0)), factor.min(c(0.5))), most);
        y = attempt.end.or(y, good);
        slope_here = attempt.slope().or(slope_here, good);
    }
    let left = time_to(&y, &slope_here, c(0.0));
    let direction = y.n.plus(y.m, left).plus(slope_here.m, c(0.5) * left * left);
    (direction.normalize(), asked & !todo)
}

/// When the inverse distance is `target`, to the second order.
#[inline(always)]
fn time_to<F: Real>(y: &Far<F>, slope: &Far<F>, target: F) -> F {
    let two = F::splat(2.0);
    let fall = y.u - target;
    let root = y.w.times_plus(y.w, -(two * slope.w * fall)).max(F::splat(0.0)).sqrt();
    two * fall / (root - y.w)
}
