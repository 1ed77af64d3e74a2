//! Kerr's hole in the Boyer-Lindquist chart drawn oblate, spin along +z, with mass 1.

use bhs_core::dual::Dual;
use bhs_core::spacetime::{Ball, Class, Fields, Inverse, Metric, Place, Spacetime, Stationary, stationary};
use glam::DVec3;
use std::sync::Arc;

/// The hole, by its spin.
#[derive(Clone, Copy, Debug)]
pub struct Kerr(pub f64);

/// What metric and inverse are made of.
struct Parts {
    /// `r^2 + a^2`, its root, `r^2 + a^2 n_z^2` and `2 r`
    square: Dual,
    root: Dual,
    s: Dual,
    m: Dual,
    /// Unit vector of growing r, and `z x n`
    e: [Dual; 3],
    w: [Dual; 3],
}

impl Kerr {
    fn parts(&self, [x, y, z]: [Dual; 3]) -> Parts {
        let a = self.0;
        let c = x * x + y * y + z * z - a * a;
        let d = (c * c + 4.0 * a * a * z * z).sqrt();
        let r2 = if c.value > 0.0 { (c + d) * 0.5 } else { 2.0 * a * a * z * z / (d - c) };
        let r = r2.sqrt();
        let square = r2 + a * a;
        let root = square.sqrt();
        let n = [x / root, y / root, z / r];
        let s = r2 + a * a * n[2] * n[2];
        let of_s = s.sqrt();
        let e = [r * n[0] / of_s, r * n[1] / of_s, root * n[2] / of_s];
        Parts { square, root, s, m: 2.0 * r, e, w: [-n[1], n[0], Dual::constant(0.0)] }
    }
}

/// `1 + along e e + around w w`
fn with(along: Dual, e: [Dual; 3], around: Dual, w: [Dual; 3]) -> [Dual; 6] {
    let entry = |i: usize, j: usize| along * e[i] * e[j] + around * w[i] * w[j] + f64::from(i == j);
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(1, 2), entry(0, 2), entry(0, 1)]
}

impl Metric for Kerr {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        let a = self.0;
        let Parts { square, root, s, m, e, w } = self.parts(x);
        let f = (square - m) / square;
        let gamma = with(1.0 / f - 1.0, e, m * a * a / (square * (s - m)), w);
        let b = m * a / (root * (s - m));
        Fields { lapse_squared: 1.0 - m / s, gamma, beta: w.map(|w| b * w) }
    }

    /// The textbook's, which is regular in the ergosphere: `g^tt = -((r^2+a^2)^2 - a^2 D sin^2)/(S D)`, `g^tphi = -2 a r/(S D)`,
    /// `g^phiphi = (S - 2 r)/(S D sin^2)`.
    fn inverse(&self, x: [Dual; 3]) -> Inverse {
        let a = self.0;
        let Parts { square, root, s, m, e, w } = self.parts(x);
        let d = square - m;
        let sin_squared = w[0] * w[0] + w[1] * w[1];
        let tt = -(square * square - a * a * d * sin_squared) / (s * d);
        let turning = -(m * a) / (s * d);
        let space = with(d / square - 1.0, e, turning * a, w);
        Inverse { tt, t: w.map(|w| turning * root * w), space }
    }

    /// Within the prograde photon orbit no light turns.
    fn swallows(&self, x: DVec3, d: DVec3) -> bool {
        let Parts { square, e, .. } = self.parts(Dual::variables(x));
        let photons = 2.0 * (1.0 + (2.0 / 3.0 * (-self.0.abs()).acos()).cos());
        square.value < photons * photons + self.0 * self.0 && DVec3::from_array(e.map(|e| e.value)).dot(d) < 0.0
    }
}

impl Spacetime for Kerr {
    fn at(&self, place: Place) -> Option<Stationary> {
        stationary(self, place.x)
    }

    fn captures(&self) -> Vec<Ball> {
        // The largest that the horizon holds.
        vec![Ball { center: DVec3::ZERO, radius: 1.0 + (1.0 - self.0 * self.0).sqrt() }]
    }

    fn class(&self) -> Class<'_> {
        Class::General(self)
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn moved(&self, _: DVec3) -> Arc<dyn Spacetime> {
        panic!("not needed here")
    }
}
