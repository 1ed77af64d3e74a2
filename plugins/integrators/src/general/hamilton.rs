//! Hamilton's equations of light of energy 1.
//!
//! `H = g^ab p_a p_b / 2 = 0` with `p_t = -1`, in an affine parameter: `dx/dlambda = dH/dp`, `dp/dlambda = -dH/dx`, and
//! `dt/dlambda = g^ti p_i - g^tt`. Light that is followed against the flow of time moves as light that follows it does where `beta` has the other
//! sign, and what it takes of time is counted as positive.

use crate::arithmetic::space::Space;
use bhs_core::dual::Dual;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Inverse, Metric, stationary};
use glam::{DMat3, DVec3};

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

    /// The momentum of light of energy 1 at `x` along the chart direction `d`, where nothing can stand still: by the split of the metric whose
    /// observers do not turn with respect to space, `ds^2 = -alpha^2 dt^2 + h (dx - W dt)(dx - W dt)`.
    #[cold]
    fn dragged(&self, x: DVec3, d: DVec3) -> Option<DVec3> {
        let inverse = self.inverse(x);
        let alpha_squared = -1.0 / inverse.tt.value;
        let drag = DVec3::from_array(inverse.t.map(|t| -t.value)) * alpha_squared;
        let [xx, yy, zz, yz, xz, xy] = inverse.space.map(|g| g.value);
        let space = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
        let dyad = DMat3::from_cols(drag * drag.x, drag * drag.y, drag * drag.z);
        let h = (space + dyad * (1.0 / alpha_squared)).inverse();
        // g_tt, g_ti d^i and g_ij d^i d^j; light along d takes the time t per length for which their polynomial vanishes.
        let (tt, mixed, along) = (drag.dot(h * drag) - alpha_squared, -drag.dot(h * d), d.dot(h * d));
        let speed = (mixed * mixed - tt * along).sqrt();
        let time = if mixed <= 0.0 { along / (speed - mixed) } else { -(mixed + speed) / tt };
        let velocity = d / speed;
        let p = h * (velocity - drag * (time / speed));
        (alpha_squared > 0.0 && speed > 0.0 && time > 0.0 && p.is_finite()).then_some(p)
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
