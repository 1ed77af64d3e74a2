//! Hamilton's equations of light of energy 1.
//!
//! `H = g^ab p_a p_b / 2 = 0` with `p_t = -1`, in an affine parameter: `dx/dlambda = dH/dp`, `dp/dlambda = -dH/dx`, and
//! `dt/dlambda = g^ti p_i - g^tt`. Light that is followed against the flow of time moves as light that follows it does where `beta` has the other
//! sign, and what it takes of time is counted as positive.

use crate::arithmetic::space::Space;
use bhs_core::dual::Dual;
use bhs_core::observer::Observer;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Inverse, Metric, Normal, stationary};
use glam::DVec3;

/// A metric, and which way light goes through it.
#[derive(Clone, Copy, Debug)]
pub struct Hamilton<'a> {
    /// The metric.
    pub metric: &'a dyn Metric,
    /// Whether rays lead to where light comes from.
    pub backward: bool,
}

/// A ray at a point.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// The point (scene units).
    pub x: Vector<f64>,
    /// The momentum, a chart covector.
    pub p: Vector<f64>,
    /// The time underway (scene units).
    pub t: f64,
}

impl Space<f64> for Light {
    #[inline(always)]
    fn plus(self, o: Self, s: f64) -> Self {
        Self { x: self.x.plus(o.x, s), p: self.p.plus(o.p, s), t: self.t + o.t * s }
    }

    #[inline(always)]
    fn times(self, s: f64) -> Self {
        Self { x: self.x * s, p: self.p * s, t: self.t * s }
    }

    #[inline(always)]
    fn or(self, o: Self, which: bool) -> Self {
        if which { self } else { o }
    }
}

impl Hamilton<'_> {
    /// The inverse metric at `x`, as the ray has it.
    pub fn inverse(&self, x: DVec3) -> Inverse {
        let mut inverse = self.metric.inverse(Dual::variables(x));
        if self.backward {
            inverse.t = inverse.t.map(|b| -b);
        }
        inverse
    }

    /// The ray from `x` along the chart direction `d`; `None` where there is no light of positive energy along it.
    pub fn start(&self, x: DVec3, d: DVec3) -> Option<Light> {
        let Some(mut here) = stationary(self.metric, x) else {
            return Some(Light { x: x.into(), p: self.dragged(x, d)?.into(), t: 0.0 });
        };
        if self.backward {
            here.beta = -here.beta;
        }
        Some(Light { x: x.into(), p: here.momentum(d).into(), t: 0.0 })
    }

    /// The momentum of light of energy 1 at `x` along the unit chart direction `d`, where nothing can stand still: as the observer has it who is
    /// dragged with space.
    #[cold]
    fn dragged(&self, x: DVec3, d: DVec3) -> Option<DVec3> {
        let mut here = Normal::of_metric(self.metric, x)?;
        // Who looks along `d` sees light that moves against it, in a space that is dragged the other way.
        if !self.backward {
            here.drag = -here.drag;
        }
        let observer = Observer::dragged(&here);
        let p = here.root.apply(observer.local_direction(d)) / observer.ratio(d);
        (observer.bundle_area_factor(d) > 0.0 && p.is_finite() && observer.ratio(d) > 0.0).then_some(p)
    }

    /// The derivative by the affine parameter.
    pub fn slope(&self, y: Light) -> Light {
        let inverse = self.inverse(y.x.into());
        let p = DVec3::from(y.p);
        let dp = inverse.norm(p).gradient * -0.5;
        let t = DVec3::from_array(inverse.t.map(|t| t.value)).dot(p) - inverse.tt.value;
        Light { x: inverse.velocity(p).into(), p: dp.into(), t }
    }

    /// Twice the Hamiltonian over what its terms amount to: 0 but for errors.
    pub fn violation(&self, y: &Light) -> f64 {
        let inverse = self.inverse(y.x.into());
        inverse.norm(y.p.into()).value / inverse.tt.value.abs().max(f64::MIN_POSITIVE)
    }

    /// Square of the lapse of the observers that do not turn with respect to space: 0 on horizons, and in ergospheres above 0.
    pub fn lapse_squared(&self, x: DVec3) -> f64 {
        -1.0 / self.inverse(x).tt.value
    }
}
