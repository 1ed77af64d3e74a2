//! Where rays go that leave for ever, if space is flat far away.
//!
//! As in a refractive index (`graded_index/escape.rs`): `x = center + n/u`, `dlambda = dtau/u^2`. What is wanted is the momentum at infinity, which
//! is the direction there.

use crate::arithmetic::dormand_prince::{error, step};
use crate::arithmetic::space::Space;
use crate::general::hamilton::{Hamilton, Light};
use bhs_core::real::Vector;
use bhs_elementary::Elementary;
use glam::DVec3;

/// A place far out: inverse distance, direction, momentum.
#[derive(Clone, Copy, Debug)]
struct Far {
    u: f64,
    n: Vector<f64>,
    p: Vector<f64>,
}

impl Space<f64> for Far {
    fn plus(self, o: Self, s: f64) -> Self {
        Self { u: self.u + o.u * s, n: self.n.plus(o.n, s), p: self.p.plus(o.p, s) }
    }

    fn times(self, s: f64) -> Self {
        Self { u: self.u * s, n: self.n * s, p: self.p * s }
    }

    fn or(self, o: Self, which: bool) -> Self {
        if which { self } else { o }
    }
}

/// Smallest share of the inverse distance that a step leaves over.
const LEFT: f64 = 0.1;

/// Attempted steps.
const MOST_STEPS: u32 = 200;

/// The direction in which the ray `light` leaves, which moves away from `center`, to about `tolerance` (rad); `extent` is the size of what
/// bends it. `None` if it comes to no end.
pub fn direction(hamilton: &Hamilton<'_>, light: &Light, center: DVec3, extent: f64, tolerance: f64) -> Option<DVec3> {
    let from_center = light.x - center.into();
    let r = from_center.length();
    let mut y = Far { u: 1.0 / r, n: from_center * (1.0 / r), p: light.p };
    let slope = |y: Far| {
        let r = 1.0 / y.u;
        let Light { x, p, .. } = hamilton.slope(Light { x: Vector::from(center).plus(y.n, r), p: y.p, t: 0.0 });
        let out = x.dot(y.n);
        Far { u: -out, n: x.plus(y.n, -out) * r, p: p * (r * r) }
    };
    let mut here = slope(y);
    let extent = extent.max(here.n.length());
    let near_enough = tolerance.sqrt() / extent;
    let mut most = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        if here.u.is_nan() || here.u >= 0.0 {
            return None;
        }
        if y.u <= near_enough {
            let p = y.p.plus(here.p, -y.u / here.u);
            return Some(DVec3::from(p).normalize());
        }
        let target = (LEFT * y.u).max(0.5 * near_enough);
        let h = ((y.u - target) / -here.u).min(most);
        let attempt = step(slope, y, here, h);
        let errors = attempt.errors.map(|e| e.p.length().max(e.n.length()).max(e.u.abs() * extent));
        let share = error(errors) / tolerance;
        let factor = (0.8 * share.max(1e-6).power(-0.125)).clamp(0.2, 4.0);
        if share <= 1.0 && attempt.end.u > 0.0 {
            (y, here) = (attempt.end, attempt.slope());
            most = h * factor.max(1.0);
        } else {
            most = h * if factor.is_nan() { 0.2 } else { factor.min(0.5) };
        }
    }
    None
}
