//! The edge of capture, seen from a point: where a turning point of 1/r and the way to the horizon become one another.

use crate::kerr::connect::bundle::{Factors, Spin};
use bhs_core::real::{Real, Vector};
use bhs_elementary::Elementary;

/// The edge in some azimuth.
#[derive(Clone, Copy, Debug)]
pub struct Edge<F> {
    /// Angle of the launch from the inward direction (rad).
    pub angle: F,
    /// Derivative of that across the azimuth, by the angle of the launch there.
    pub slope: F,
    /// 1/r at which light at the edge winds.
    pub u: F,
}

/// Azimuths in which light is launched from a point, about an inward direction.
#[derive(Clone, Copy, Debug)]
pub struct Azimuth<F> {
    /// Unit vector towards the middle.
    pub inward: Vector<F>,
    /// Unit vector at right angles to it.
    pub across: Vector<F>,
}

/// The largest change of the angle (rad) in one of them.
const LONGEST: f64 = 0.25;

/// How near to 0 `u'^2` has to be at its minimum.
const FOUND: f64 = 1e-5;

impl<F: Real> Azimuth<F> {
    /// The launch at the angle `th` from inwards, and the directions of growing angle and azimuth.
    #[inline(always)]
    pub fn direction(&self, th: F) -> (Vector<F>, [Vector<F>; 2]) {
        let sines = |th: F| {
            let th = th.to_array();
            (F::from_fn(|i| th[i].cosine()), F::from_fn(|i| th[i].sine()))
        };
        let (cos, sin) = sines(th);
        let Self { inward, across } = *self;
        let d = (inward * cos).plus(across, sin);
        (d, [(across * cos).plus(inward, -sin), inward.cross(across)])
    }

    /// The edge as seen from `x`, beginning with `guess`; and where that is one.
    pub fn edge(&self, spin: &Spin<F>, x: Vector<F>, guess: (F, F), steps: u32) -> (Edge<F>, F::Mask) {
        let c = F::splat;
        let (mut th, mut u) = guess;
        let most = spin.horizon();
        let mut slope = c(0.0);
        let mut off = c(1.0);
        for _ in 0..steps {
            let (d, aside) = self.direction(th);
            let factors = Factors::new(spin, &spin.launch(x, d, aside));
            let [value, half_slope] = factors.quartic(u);
            let bend = factors.bend(u);
            // value + 2 half_slope du + value_th dth = 0, half_slope + bend du + half_slope_th dth = 0.
            let (f, g, fu, ft, gu, gt) = (value.v, half_slope.v, half_slope.v + half_slope.v, value.d[0], bend, half_slope.d[0]);
            let over = c(1.0) / (fu * gt - ft * gu);
            let du = (g * ft - f * gt) * over;
            let dth = (f * gu - g * fu) * over;
            th += dth.max(c(-LONGEST)).min(c(LONGEST));
            u = (u + du).max(c(0.1)).min(most);
            slope = -value.d[1] / value.d[0];
            off = f.abs();
        }
        let is_one = off.lt(c(FOUND)) & slope.is_finite() & th.gt(c(0.0)) & th.lt(c(std::f64::consts::PI));
        (Edge { angle: th, slope, u }, is_one)
    }
}
