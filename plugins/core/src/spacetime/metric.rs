//! Spacetimes that give their metric as functions of the place.

use super::{Spherical, Stationary, Stretch};
use crate::dual::Dual;
use glam::{DMat3, DVec3};
use std::fmt::Debug;

/// The metric of a stationary spacetime as functions of the place: `ds^2 = -N^2 (dt + beta)^2 + gamma`.
#[derive(Clone, Copy, Debug)]
pub struct Fields {
    /// Square of the lapse; not above 0 where nothing can stand still.
    pub lapse_squared: Dual,
    /// Spatial metric: xx, yy, zz, yz, xz, xy.
    pub gamma: [Dual; 6],
    /// Rotation.
    pub beta: [Dual; 3],
}

impl Fields {
    /// A static metric whose spatial part is `gamma` times that of flat space.
    pub fn isotropic(lapse_squared: Dual, gamma: Dual) -> Self {
        let zero = Dual::constant(0.0);
        Self { lapse_squared, gamma: [gamma, gamma, gamma, zero, zero, zero], beta: [zero; 3] }
    }

    /// The inverse of the whole metric.
    pub fn inverse(&self) -> Inverse {
        let [xx, yy, zz, yz, xz, xy] = self.gamma;
        let minors =
            [yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy, xz * xy - xx * yz, xy * yz - yy * xz, yz * xz - zz * xy];
        let over = (xx * minors[0] + xy * minors[5] + xz * minors[4]).recip();
        let space = minors.map(|m| m * over);
        let [bx, by, bz] = self.beta;
        let raised = apply(&space, self.beta);
        let tt = raised[0] * bx + raised[1] * by + raised[2] * bz - self.lapse_squared.recip();
        Inverse { tt, t: raised.map(|b| -b), space }
    }
}

/// The inverse of a stationary metric as functions of the place: light of momentum `p` and `p_t = -1` has `2 H = g^ab p_a p_b = 0`.
#[derive(Clone, Copy, Debug)]
pub struct Inverse {
    /// `g^tt`
    pub tt: Dual,
    /// `g^ti`
    pub t: [Dual; 3],
    /// `g^ij`: xx, yy, zz, yz, xz, xy.
    pub space: [Dual; 6],
}

impl Inverse {
    /// `2 H` of light of energy 1 with the momentum `p`, which is 0; its gradient is `-2 dp/dlambda` in the affine parameter `lambda`.
    pub fn norm(&self, p: DVec3) -> Dual {
        let p = p.to_array().map(Dual::constant);
        let raised = apply(&self.space, p);
        let mut sum = self.tt;
        for i in 0..3 {
            sum += p[i] * (raised[i] - 2.0 * self.t[i]);
        }
        sum
    }

    /// `dx/dlambda` of light of energy 1 with the momentum `p`.
    pub fn velocity(&self, p: DVec3) -> DVec3 {
        let raised = apply(&self.space, p.to_array().map(Dual::constant));
        DVec3::from_array(std::array::from_fn(|i| raised[i].value - self.t[i].value))
    }
}

/// A symmetric matrix (xx, yy, zz, yz, xz, xy) times a vector.
fn apply([xx, yy, zz, yz, xz, xy]: &[Dual; 6], [x, y, z]: [Dual; 3]) -> [Dual; 3] {
    [*xx * x + *xy * y + *xz * z, *xy * x + *yy * y + *yz * z, *xz * x + *yz * y + *zz * z]
}

/// A spacetime that gives its metric, and no more: the slowest kind to follow rays through, and the easiest to write.
///
/// Light that is followed against the flow of time moves as light that follows it does with `-beta` instead of `beta`.
pub trait Metric: Debug + Send + Sync {
    /// The metric at `x`, with derivatives: `x` are the coordinates as variables.
    fn fields(&self, x: [Dual; 3]) -> Fields;

    /// The inverse metric at `x`. To be written out where [`Metric::fields`] fails and light moves all the same: in an ergosphere.
    fn inverse(&self, x: [Dual; 3]) -> Inverse {
        self.fields(x).inverse()
    }

    /// Whether light at `x` with the chart direction `d` is known to fall into a hole, deeper with every step: besides the balls of
    /// [`super::Spacetime::captures`], with the same promise.
    fn swallows(&self, x: DVec3, d: DVec3) -> bool {
        let _ = (x, d);
        false
    }
}

/// The metric of `metric` at the point `x`; `None` where nothing can stand still.
pub fn stationary(metric: &dyn Metric, x: DVec3) -> Option<Stationary> {
    let Fields { lapse_squared, gamma, beta } = metric.fields(Dual::variables(x));
    let [xx, yy, zz, yz, xz, xy] = gamma.map(|g| g.value);
    let lapse = lapse_squared.value.sqrt();
    let root = Stretch::of_metric(DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]))?;
    let beta = DVec3::from_array(beta.map(|b| b.value));
    (lapse > 0.0 && lapse.is_finite() && beta.is_finite()).then_some(Stationary { lapse, root, beta })
}

/// Light of energy 1 that moves into the future along a short chart vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightStep {
    /// Time that it takes (scene units).
    pub time: f64,
    /// Its momentum, a chart covector.
    pub momentum: DVec3,
}

/// Light of energy 1 that moves along the short chart vector `step` at the point `x`; also in an ergosphere, where nothing can stand still. `None`
/// behind a horizon, and where no light of this energy moves so.
///
/// By the observer who does not turn with respect to space: `alpha^2 dt^2 = h(step - W dt, step - W dt)`, of which light of energy 1 is the root that
/// is regular where `g_tt` is 0 (`docs/physics.md`, section 1).
pub fn light_step(metric: &dyn Metric, x: DVec3, step: DVec3) -> Option<LightStep> {
    let Inverse { tt, t, space } = metric.inverse(Dual::variables(x));
    let alpha_squared = -1.0 / tt.value;
    let outside = alpha_squared > 0.0 && alpha_squared.is_finite();
    let w = DVec3::from_array(t.map(|t| t.value)) * if outside { -alpha_squared } else { return None };
    let [xx, yy, zz, yz, xz, xy] = space.map(|g| g.value);
    let raised = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    let dyad = DMat3::from_cols(w * w.x, w * w.y, w * w.z);
    let h = (raised + dyad * (1.0 / alpha_squared)).inverse();
    let (around, along) = (-(h * w), h * step);
    // g_tt dt^2 + 2 g_ti dt dx^i + g_ij dx^i dx^j = 0
    let (tt, t, space) = (-around.dot(w) - alpha_squared, around.dot(step), along.dot(step));
    let root = t.mul_add(t, -(tt * space)).sqrt();
    let time = if t > 0.0 { (t + root) / -tt } else { space / (root - t) };
    // p_i = g_ti dt/dlambda + g_ij dx^j/dlambda, of which the energy is `root` for dlambda = 1.
    let momentum = (around * time + along) / root;
    (time >= 0.0 && time.is_finite() && momentum.is_finite()).then_some(LightStep { time, momentum })
}

impl Metric for Spherical {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        let [x, y, z] = [x[0] - self.center.x, x[1] - self.center.y, x[2] - self.center.z];
        let square = x * x + y * y + z * z;
        let lapse_squared = 1.0 - self.rs / square.sqrt() + self.charge_squared / square;
        // (1/N^2 - 1) e_r e_r
        let stretch = (1.0 - lapse_squared) / (lapse_squared * square);
        let zero = Dual::constant(0.0);
        let gamma = [
            1.0 + stretch * x * x,
            1.0 + stretch * y * y,
            1.0 + stretch * z * z,
            stretch * y * z,
            stretch * x * z,
            stretch * x * y,
        ];
        Fields { lapse_squared, gamma, beta: [zero; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Wild;

    /// Some metric with all its parts.
    impl Metric for Wild {
        fn fields(&self, [x, y, z]: [Dual; 3]) -> Fields {
            let bump = 0.1 * (0.5 * x).sin() * (y - 0.3 * z).cos();
            let gamma =
                [1.2 + bump, 0.9 - bump * x * 0.3, 1.4 + 0.2 * y.sin(), 0.1 * z.cos(), 0.2 * bump, -0.15 + 0.05 * (x * y).sin()];
            Fields { lapse_squared: 0.8 + bump * bump, gamma, beta: [0.2 * y, -0.1 * x * z, 0.3 + bump] }
        }
    }

    #[test]
    fn momentum_and_velocity_are_those_of_the_static_observer() {
        let x = DVec3::new(0.4, -0.3, 0.7);
        let here = stationary(&Wild, x).unwrap();
        let inverse = Wild.inverse(Dual::variables(x));
        for d in [DVec3::X, DVec3::new(0.3, -0.8, 0.2), DVec3::new(-1.0, 0.1, 0.4)] {
            let p = here.momentum(d);
            assert!(inverse.norm(p).value.abs() < 1e-13);
            // dx/dlambda = d / (N |d|_g)
            let v = d / (here.lapse * here.root.apply(d).length());
            assert!((inverse.velocity(p) - v).length() < 1e-13, "{d}");
        }
        // The gradient, by finite differences.
        let p = DVec3::new(0.2, 0.5, -0.9);
        let norm = |x: DVec3| Wild.inverse(Dual::variables(x)).norm(p).value;
        let found = inverse.norm(p).gradient;
        for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let slope = (norm(x + unit * 1e-5) - norm(x - unit * 1e-5)) / 2e-5;
            assert!((found[axis] - slope).abs() < 1e-9, "{axis}");
        }
    }

    #[test]
    fn light_is_that_of_the_static_observer() {
        let x = DVec3::new(0.4, -0.3, 0.7);
        let here = stationary(&Wild, x).unwrap();
        for d in [DVec3::X, -DVec3::X, DVec3::new(0.3, -0.8, 0.2), DVec3::new(-1.0, 0.1, 0.4)] {
            let LightStep { time, momentum } = light_step(&Wild, x, d).unwrap();
            assert!((time - here.travel_time(d)).abs() < 1e-14, "{d}: {time}");
            assert!((momentum - here.momentum(d)).length() < 1e-14, "{d}: {momentum}");
        }
        let hole = Spherical { center: DVec3::ZERO, rs: 1.0, charge_squared: 0.0 };
        assert_eq!(light_step(&hole, DVec3::X * 0.9, DVec3::X), None);
    }

    #[test]
    fn round_holes_give_the_same_metric_both_ways() {
        let hole = Spherical { center: DVec3::new(1.0, 0.0, -0.5), rs: 1.0, charge_squared: 0.2 };
        for x in [DVec3::new(2.5, 1.0, -0.5), DVec3::new(1.0, -1.1, -0.5), DVec3::new(-7.0, 3.0, 1.0)] {
            let (a, b) = (hole.at(x).unwrap(), stationary(&hole, x).unwrap());
            assert!((a.lapse - b.lapse).abs() < 1e-14 && b.beta == DVec3::ZERO);
            for v in [DVec3::X, DVec3::Y, DVec3::Z] {
                assert!((a.root.apply(v) - b.root.apply(v)).length() < 1e-13, "{x}");
            }
        }
    }
}
