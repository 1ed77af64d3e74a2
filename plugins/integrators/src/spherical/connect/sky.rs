//! Which light rays join a point with a direction of the sky: `connect.rs` in the limit where the other end is infinitely far away.
//!
//! There u2 = rs/r2 is 0, and the place of the other end, seen from the hole, is the direction of the ray itself. The spread, over
//! r2^2, tends to the solid angle of the sky over that at x,
//!
//! `dOmega(sky) / domega(x) = r1^2 |du2/dalpha| sin(beta) |sin(Phi)| / (u2 sin(alpha))`,  u2 / sin(beta) -> |v2|
//!
//! which is 1 in flat space. Everything else holds as there.

use crate::spherical::connect::lanes::Lanes;
use crate::spherical::connect::solve::{Ends, Solved, solve};
use crate::spherical::connect::{MOST_IMAGES, number, swept_angle};
use bhs_core::spacetime::Spherical;
use bhs_elementary::Elementary;
use bhs_engine::connections::{Connection, ConnectionPair};
use glam::DVec3;

/// Bending by a hole of less than this Schwarzschild radius, relative to the distance from it, is nothing.
const LEAST_U: f64 = 1e-30;

/// Directions closer together than this (rad) are one.
const RADIAL: f64 = 1e-60;

/// Geodesics number 2 `turn` and 2 `turn` + 1 from `x` around `hole` (`rs` > 0) that leave the scene in the unit chart direction
/// `direction`.
pub fn connect_sky(hole: &Spherical, x: DVec3, direction: DVec3, turn: u32) -> ConnectionPair {
    let ends = SkyEnds::new(hole, x, direction);
    let images = [2 * turn, 2 * turn + 1];
    let solved = ends.solve(images);
    std::array::from_fn(|i| ends.connection(solved[i].as_ref(), images[i]))
}

/// The spread of the geodesic that was traced from `x` in the unit chart direction `launch` and left the scene in the direction
/// `direction` after sweeping `phi` (rad): what [`connect_sky`] says of the same one. `None` where it says `None`, and if it is not
/// among the first `images` ones.
pub fn spread_sky(hole: &Spherical, x: DVec3, launch: DVec3, direction: DVec3, phi: f64, images: u32) -> Option<f64> {
    let ends = SkyEnds::new(hole, x, direction);
    let image = number(ends.theta, phi, launch.dot(ends.across) >= 0.0);
    if image >= images {
        return None;
    }
    ends.connection(ends.solve([image])[0].as_ref(), image).map(|c| c.spread)
}

/// A point and a direction of the sky, seen from the hole.
struct SkyEnds {
    /// rs/r at x.
    u: f64,
    /// Angle between them (rad), and its sine.
    theta: f64,
    sin_theta: f64,
    /// Unit vectors at x: outwards, and across it towards the direction.
    out: DVec3,
    across: DVec3,
    direction: DVec3,
}

impl SkyEnds {
    fn new(hole: &Spherical, x: DVec3, direction: DVec3) -> Self {
        let from_center = x - hole.center;
        let r = from_center.length();
        let out = from_center / r;
        let side = direction - out * direction.dot(out);
        let side = side - out * side.dot(out);
        let sin_theta = side.length();
        let across = if sin_theta > RADIAL { side / sin_theta } else { out.any_orthonormal_vector() };
        let theta = sin_theta.arctangent2(out.dot(direction));
        Self { u: (hole.rs / r).max(LEAST_U), theta, sin_theta: sin_theta.min(1.0), out, across, direction }
    }

    fn solve<const N: usize>(&self, images: [u32; N]) -> [Option<Solved>; N] {
        if self.u >= 1.0 || self.u.is_nan() {
            return [None; N];
        }
        let ends = Ends { u1: Lanes::all(self.u), u2: Lanes::all(0.0), half_rise: Lanes::all(-0.5 * self.u) };
        solve(&ends, Lanes(images.map(|image| swept_angle(self.theta, image))))
    }

    fn connection(&self, solved: Option<&Solved>, image: u32) -> Option<Connection> {
        let (arrival, phi) = (self.direction, swept_angle(self.theta, image));
        if image == 0 && self.theta < RADIAL && self.u < 1.0 {
            return Some(Connection { launch: self.out, arrival, spread: 1.0, phi });
        }
        let Solved { v1, v2, stretch, .. } = *solved.filter(|_| image < MOST_IMAGES)?;
        // 1/sin(alpha)^2 = 1 + (v1/u1)^2.
        let q = self.u * self.u + v1 * v1;
        let slope = q.sqrt().recip();
        let side = if image.is_multiple_of(2) { 1.0 } else { -1.0 };
        let launch = self.out * (-v1 * slope) + self.across * (side * self.u * slope);
        let scale = self.u.recip();
        let spread = scale * scale * stretch * self.sin_theta * q * (q * slope) / v2.abs();
        Some(Connection { launch, arrival, spread, phi })
    }
}
