//! Rays around a hole that spins that have been followed, with what becomes of them if they are launched a little otherwise.

use crate::kerr::connect::bundle::{Factors, Spin};
use crate::kerr::connect::search::{Guess, Target};
use crate::kerr::connect::series::{Followed, follow};
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::{Real, Vector};
use bhs_elementary::{Elementary, unit_vector};
use glam::{DMat3, DVec3};

/// A ray to follow.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Angular momentum over mass of the hole.
    pub a: f64,
    /// Where it begins.
    pub x: DVec3,
    /// How.
    pub guess: Guess,
    /// Two directions at right angles to the launch; with it they are right-handed.
    pub aside: [DVec3; 2],
    /// 1/r at which it ends on its way out, before its time.
    pub exit: f64,
}

/// A ray that was followed.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// How it was launched, and for how long it was followed.
    pub guess: Guess,
    /// Directions at right angles to the launch.
    pub aside: [DVec3; 2],
    /// 1/r.
    pub u: f64,
    /// The unit vector of the angles.
    pub n: DVec3,
    /// Derivatives of both by the two angles of the launch and by the time.
    pub by: [(f64, DVec3); 3],
    /// `r^2 + a^2`, `r^2 + a^2 n_z^2`
    square: f64,
    sigma: f64,
    /// `sqrt(K + a^2 + M^2)`: the parameter of rays over Mino's time.
    pub scale: f64,
    /// Angle by which it was turned about the axis (rad).
    pub twist: f64,
}

/// Errors of rays that are far from where they are to go, and of those that come near; terms of their series.
pub(super) const ROUGH: (f64, usize) = (1e-3, 8);
pub(super) const FINE: (f64, usize) = (1e-9, 13);

/// Follows at most [`LANES`] rays.
pub fn follow_all(charge_squared: f64, trials: &[Trial], is_fine: bool) -> [Option<Reached>; LANES] {
    let last = trials.len() - 1;
    // Lanes without a ray repeat the last one.
    let trial = |i: usize| &trials[i.min(last)];
    let number = |of: fn(&Trial) -> f64| <Lanes as Real>::from_fn(|i| of(trial(i)));
    let vector = |of: fn(&Trial) -> DVec3| Vector::<Lanes>::from_fn(|i| of(trial(i)));
    let spin = Spin { a: number(|t| t.a), charge_squared: Lanes::splat(charge_squared) };
    let aside = [vector(|t| t.aside[0]), vector(|t| t.aside[1])];
    let start = spin.launch(vector(|t| t.x), vector(|t| t.guess.launch), aside);
    let until = (number(|t| t.guess.tau), number(|t| t.exit));
    let followed = if is_fine {
        follow::<Lanes, { FINE.1 }, 2, { FINE.1 }>(&spin, &start, until, FINE.0)
    } else {
        follow::<Lanes, { ROUGH.1 }, 2, { ROUGH.1 }>(&spin, &start, until, ROUGH.0)
    };
    let lost = followed.lost.to_bitmask();
    let rates = Factors::new(&spin, &followed.end).twist(followed.end.u[0].v);
    std::array::from_fn(|i| {
        if i > last || lost >> i & 1 == 1 {
            return None;
        }
        let reached = reached(&followed, trial(i), i, rates.lane(i));
        (reached.u.is_finite() && reached.n.is_finite()).then_some(reached)
    })
}

/// Ray number `i`, which is `trial` and has come to where the derivative of its twist is `rate`.
pub(super) fn reached(followed: &Followed<Lanes, 2>, trial: &Trial, i: usize, rate: f64) -> Reached {
    let end = &followed.end;
    let u = end.u.map(|u| u.lane(i));
    let n = end.n.map(|n| n.map(|n| n.lane(i)));
    let chi = end.chi.lane(i);
    let turn = unit_vector(chi.v);
    let about = |v: DVec3| turn.rotate(v.truncate()).extend(v.z);
    let top = DVec3::new(n[0][0].v, n[0][1].v, n[0][2].v).normalize();
    let w = DVec3::new(-top.y, top.x, 0.0);
    let slope = DVec3::new(n[1][0].v, n[1][1].v, n[1][2].v);
    let aside = |j: usize| DVec3::new(n[0][0].d[j], n[0][1].d[j], n[0][2].d[j]) + w * chi.d[j];
    let (r, a2) = (1.0 / u[0].v, trial.a * trial.a);
    Reached {
        guess: Guess { tau: followed.tau.lane(i), ..trial.guess },
        aside: trial.aside,
        u: u[0].v,
        n: about(top),
        by: [(u[0].d[0], about(aside(0))), (u[0].d[1], about(aside(1))), (u[1].v, about(slope + w * rate))],
        square: r * r + a2,
        sigma: r * r + a2 * top.z * top.z,
        scale: (end.k.v.lane(i) + a2 + 1.0).max(0.0).sqrt(),
        twist: chi.v,
    }
}

impl Reached {
    /// The changes of the two angles of the launch and of the time that move the end across by `aside` and in 1/r by `rise`.
    pub fn change(&self, aside: DVec3, rise: f64) -> DVec3 {
        let b1 = self.n.any_orthonormal_vector();
        let b2 = self.n.cross(b1);
        let column = |(u, n): (f64, DVec3)| DVec3::new(b1.dot(n), b2.dot(n), u);
        let matrix = DMat3::from_cols(column(self.by[0]), column(self.by[1]), column(self.by[2]));
        matrix.inverse() * DVec3::new(b1.dot(aside), b2.dot(aside), rise)
    }

    /// How these changes move the end: across, and in 1/r.
    pub fn moved(&self, change: DVec3) -> (DVec3, f64) {
        let [a, b, c] = self.by;
        (a.1 * change.x + b.1 * change.y + c.1 * change.z, a.0 * change.x + b.0 * change.y + c.0 * change.z)
    }

    /// Volume that the changes of the launch and of the time span, per volume of r and n, over `r^2`: above 0 until neighbours have met.
    pub fn determinant(&self) -> f64 {
        let [(u1, n1), (u2, n2), (ut, nt)] = self.by;
        -(u1 * n2.cross(nt) + u2 * nt.cross(n1) + ut * n1.cross(n2)).dot(self.n)
    }

    /// Derivative of the place by the time.
    pub fn tangent(&self) -> DVec3 {
        let (ut, nt) = self.by[2];
        let r = 1.0 / self.u;
        let (rise, root) = (-ut * r * r, self.square.sqrt());
        let across = self.n.truncate() * (r * rise / root) + nt.truncate() * root;
        across.extend(rise * self.n.z + r * nt.z)
    }

    /// Chart area across the bundle over chart solid angle of the launch; towards the sky, solid angle over solid angle.
    pub fn spread(&self, target: Target) -> f64 {
        let across = match target {
            Target::Point(_) => self.sigma / (self.u * self.u * self.tangent().length()),
            Target::Sky(_) => 1.0 / self.by[2].0.abs(),
        };
        self.determinant().abs() * across
    }

    /// The launch turned by `change.x` and `change.y` (rad) towards the directions beside it, and the time changed by `change.z`.
    pub fn turned(&self, change: DVec3) -> Guess {
        let aside = self.aside[0] * change.x + self.aside[1] * change.y;
        let angle = aside.length();
        let (sin, cos) = angle.sine_cosine();
        let launch = self.guess.launch * cos + if angle > 0.0 { aside * (sin / angle) } else { DVec3::ZERO };
        Guess { launch: launch.normalize(), tau: self.guess.tau + change.z }
    }
}
