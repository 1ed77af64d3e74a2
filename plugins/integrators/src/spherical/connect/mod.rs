//! Which light rays join two points: the geodesics of a Schwarzschild hole from x to y, for light sampling.
//!
//! Seen from the hole, x and y are an angle theta apart. The geodesics between them lie in one plane with the centre and are
//! numbered by the angle that they sweep: theta (image 0, the direct one), 2 pi - theta (1, round the other side),
//! 2 pi + theta (2), 4 pi - theta (3), ... There is exactly one of each (`docs/physics.md`, section 10), wherever outside the horizon
//! x and y are. `solve` finds it in the plane; here are directions in space, and the spread
//!
//! `dA_perpendicular(y) / domega(x) = r2^3 |du2/dalpha| sin(beta) |sin(Phi)| / sin(alpha)`     [chart, scene units^2/sr]
//!
//! which is distance^2 in flat space and has `dA domega_local cos / f` equal at both ends. It is 0 at exact antipodes (the
//! Einstein ring: light of a whole circle of directions meets in y) and for images 1, 2, ... of a point behind another: a point
//! source has no finite brightness there. Callers drop a connection of spread 0; on surfaces this is a null set.

mod lanes;
pub mod sky;
mod solve;

use crate::spherical::connect::lanes::Lanes;
use crate::spherical::connect::solve::{Ends, Solved, solve};
use bhs_core::spacetime::Place;
use bhs_core::spacetime::Spherical;
use bhs_elementary::Elementary;
use bhs_engine::connections::{Connection, ConnectionPair};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Images are numbered up to here; each further winding is some 500 times fainter.
pub const MOST_IMAGES: u32 = 6;

/// A geodesic in its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Unit chart direction at the start: component outwards, component across (towards growing angle, never negative).
    pub launch: DVec2,
    /// Unit chart direction of travel at the end, likewise.
    pub arrival: DVec2,
    /// Area across the bundle at the end per solid angle at the start, both in the chart (scene units^2/sr).
    pub spread: f64,
    /// Newton steps that it took.
    pub steps: u32,
}

/// The angle that image number `image` of points `theta` apart sweeps (rad).
pub fn swept_angle(theta: f64, image: u32) -> f64 {
    let windings = f64::from(image.div_ceil(2));
    if image.is_multiple_of(2) { TAU * windings + theta } else { TAU * windings - theta }
}

/// The geodesic between radii `r1` and `r2` (scene units) that are `theta` [0, pi] apart seen from a hole of Schwarzschild
/// radius `rs` > 0. `None` at and inside the horizon, and from a point to itself.
pub fn join(rs: f64, r1: f64, r2: f64, theta: f64, image: u32) -> Option<Arc> {
    Pair { rs, r1, r2, r_rise: r2 - r1, theta, sin_theta: theta.sine() }.arcs([image])[0]
}

/// Geodesic number `image` from `x` to `y` around `hole` (`rs` > 0).
pub fn connect(hole: &Spherical, x: DVec3, y: DVec3, image: u32) -> Option<Connection> {
    let frame = PairFrame::new(hole, x, y);
    frame.pair.arcs([image])[0].map(|arc| frame.connection(&arc, image))
}

/// Images 2 `turn` and 2 `turn` + 1, for less than the price of two calls of [`connect`].
pub fn connect_pair(hole: &Spherical, x: DVec3, y: DVec3, turn: u32) -> ConnectionPair {
    let frame = PairFrame::new(hole, x, y);
    let images = [2 * turn, 2 * turn + 1];
    let [near, far] = frame.pair.arcs(images);
    [near.map(|arc| frame.connection(&arc, images[0])), far.map(|arc| frame.connection(&arc, images[1]))]
}

/// Pairs of points whose images are solved for side by side.
const GROUP: usize = 4;

/// [`connect_pair`] of each of `pairs`, written to its place in `found`, for less than the price of one after the other.
pub fn connect_pairs(hole: &Spherical, pairs: &[[Place; 2]], turn: u32, found: &mut [ConnectionPair]) {
    const LANES: usize = 2 * GROUP;
    let images = [2 * turn, 2 * turn + 1];
    for (pairs, found) in pairs.chunks(GROUP).zip(found.chunks_mut(GROUP)) {
        // Places without a pair repeat the first one; pairs without a geodesic have the ends of some other one solved.
        let frames: [PairFrame; GROUP] = std::array::from_fn(|k| {
            let [x, y] = pairs[if k < pairs.len() { k } else { 0 }].map(|place| place.x);
            PairFrame::new(hole, x, y)
        });
        let ends: [_; GROUP] = std::array::from_fn(|k| frames[k].pair.ends());
        let end = |which: usize| {
            Lanes::<LANES>(std::array::from_fn(|lane| ends[lane / 2].map_or([0.5, 0.25, -0.125][which], |e| e[which])))
        };
        let ends_in_lanes = Ends { u1: end(0), u2: end(1), half_rise: end(2) };
        let swept = Lanes(std::array::from_fn(|lane| swept_angle(frames[lane / 2].pair.theta, images[lane % 2])));
        let solved = solve(&ends_in_lanes, swept);
        for (k, found) in found.iter_mut().enumerate() {
            *found = std::array::from_fn(|side| {
                let [u1, u2, _] = ends[k]?;
                let arc = frames[k].pair.image(images[side], [u1, u2], solved[2 * k + side].as_ref())?;
                Some(frames[k].connection(&arc, images[side]))
            });
        }
    }
}

/// Which image a ray is that left `x` in the unit chart direction `direction` and arrived at `y` after the angle `phi`.
pub fn image_of(hole: &Spherical, x: DVec3, direction: DVec3, y: DVec3, phi: f64) -> u32 {
    PairFrame::new(hole, x, y).image_of(direction, phi)
}

/// The spread of the geodesic that was traced from `x` in the unit chart direction `direction` to `y`, sweeping `phi`: what
/// [`connect`] says of the same one. `None` where it says `None`, and if it is not among the first `images` ones.
pub fn spread_of(hole: &Spherical, x: DVec3, direction: DVec3, y: DVec3, phi: f64, images: u32) -> Option<f64> {
    let frame = PairFrame::new(hole, x, y);
    let image = frame.image_of(direction, phi);
    frame.pair.arcs([image])[0].filter(|_| image < images).map(|arc| arc.spread)
}

/// Two points seen from the hole.
struct Pair {
    rs: f64,
    r1: f64,
    r2: f64,
    /// r2 - r1, to the precision of the distance between the points.
    r_rise: f64,
    theta: f64,
    sin_theta: f64,
}

/// Bending by a hole of less than this Schwarzschild radius, relative to the distance from it, is nothing: a larger one is put in
/// its place, so that no power of rs/r underflows.
const LEAST_U: f64 = 1e-30;

/// Points closer together than this angle (rad) lie on one radius.
const RADIAL: f64 = 1e-60;

impl Pair {
    /// rs, or what is put in its place.
    #[inline(always)]
    fn rs(&self) -> f64 {
        self.rs.max(LEAST_U * self.r1.max(self.r2))
    }

    /// rs/r1, rs/r2, and half the difference; `None` where no geodesic has its ends.
    #[inline(always)]
    fn ends(&self) -> Option<[f64; 3]> {
        let over = self.rs() / (self.r1 * self.r2);
        let (u1, u2) = (self.r2 * over, self.r1 * over);
        (u1 > 0.0 && u1 < 1.0 && u2 > 0.0 && u2 < 1.0).then_some([u1, u2, -0.5 * self.r_rise * over])
    }

    #[inline(always)]
    fn arcs<const N: usize>(&self, images: [u32; N]) -> [Option<Arc>; N] {
        let Some([u1, u2, half_rise]) = self.ends() else { return [None; N] };
        let ends = Ends { u1: Lanes::all(u1), u2: Lanes::all(u2), half_rise: Lanes::all(half_rise) };
        let solved = solve(&ends, Lanes(images.map(|image| swept_angle(self.theta, image))));
        std::array::from_fn(|i| self.image(images[i], [u1, u2], solved[i].as_ref()))
    }

    /// Image number `image`, of which the orbit is known.
    #[inline(always)]
    fn image(&self, image: u32, ends: [f64; 2], solved: Option<&Solved>) -> Option<Arc> {
        match image {
            0 if self.theta < RADIAL => self.radial(),
            0..MOST_IMAGES => solved.map(|s| self.arc(ends, s)),
            _ => None,
        }
    }

    #[inline(always)]
    fn arc(&self, [u1, u2]: [f64; 2], solved: &Solved) -> Arc {
        let Solved { v1, v2, stretch, steps } = *solved;
        // 1/sin(alpha)^2 = 1 + (v1/u1)^2.
        let (q1, q2) = (u1 * u1 + v1 * v1, u2 * u2 + v2 * v2);
        let (i1, i2) = (1.0 / q1.sqrt(), 1.0 / q2.sqrt());
        let scale = self.rs() / (u1 * u2);
        Arc {
            launch: DVec2::new(-v1 * i1, u1 * i1),
            arrival: DVec2::new(-v2 * i2, u2 * i2),
            // r2^3 s sin(beta) sin(Phi)/sin(alpha), s = dV1/dalpha dU2/dV1 / rs, dV1/dalpha = u1/sin(alpha)^2.
            spread: scale * scale * stretch * self.sin_theta * q1 * q1 * i1 * i2,
            steps,
        }
    }

    /// Straight along the radius: r is an affine parameter of radial light.
    fn radial(&self) -> Option<Arc> {
        if self.r_rise == 0.0 {
            return None;
        }
        let direction = DVec2::new(self.r_rise.signum(), 0.0);
        Some(Arc { launch: direction, arrival: direction, spread: self.r_rise * self.r_rise, steps: 0 })
    }
}

/// Two points and the plane that they make with the hole's centre.
struct PairFrame {
    pair: Pair,
    /// Unit vectors at x: outwards, and across it towards y.
    out_x: DVec3,
    across_x: DVec3,
    /// The same at y, across it away from x.
    out_y: DVec3,
    across_y: DVec3,
}

impl PairFrame {
    #[inline(always)]
    fn new(hole: &Spherical, x: DVec3, y: DVec3) -> Self {
        let (from_x, from_y, way) = (x - hole.center, y - hole.center, y - x);
        let (r1, r2) = (from_x.length(), from_y.length());
        let (out_x, out_y) = (from_x / r1, from_y / r2);
        // From the shorter way to y: neighbours far from the hole keep all digits of their distance.
        let to_y = if way.length_squared() < r2 * r2 { way } else { from_y };
        let side = to_y - out_x * to_y.dot(out_x);
        let side = side - out_x * side.dot(out_x);
        let aside = side.length();
        let across_x = if aside > RADIAL * r2 { side / aside } else { out_x.any_orthonormal_vector() };
        let sin_theta = (aside / r2).min(1.0);
        let cos_theta = out_x.dot(out_y);
        let pair = Pair {
            rs: hole.rs,
            r1,
            r2,
            r_rise: way.dot(from_x + from_y) / (r1 + r2),
            theta: sin_theta.arctangent2(cos_theta),
            sin_theta,
        };
        Self { pair, out_x, across_x, out_y, across_y: across_x * cos_theta - out_x * sin_theta }
    }

    #[inline(always)]
    fn connection(&self, arc: &Arc, image: u32) -> Connection {
        let side = if image.is_multiple_of(2) { 1.0 } else { -1.0 };
        Connection {
            launch: self.out_x * arc.launch.x + self.across_x * (side * arc.launch.y),
            arrival: self.out_y * arc.arrival.x + self.across_y * (side * arc.arrival.y),
            spread: arc.spread,
            phi: swept_angle(self.pair.theta, image),
        }
    }

    fn image_of(&self, direction: DVec3, phi: f64) -> u32 {
        number(self.pair.theta, phi, direction.dot(self.across_x) >= 0.0)
    }
}

/// The number of the image that sweeps `phi` (rad) between ends that are `theta` apart; `across`: whether it leaves on the side of
/// the other end.
pub(crate) fn number(theta: f64, phi: f64, across: bool) -> u32 {
    let windings = |turns: f64, least: f64| turns.round().clamp(least, 1e6) as u32;
    let even = 2 * windings((phi - theta) / TAU, 0.0);
    let odd = 2 * windings((phi + theta) / TAU, 1.0) - 1;
    let miss = |image: u32| (swept_angle(theta, image) - phi).abs();
    // Near theta = 0 and pi the angles agree, and the side on which the ray leaves decides; elsewhere so do both.
    if (miss(even) - miss(odd)).abs() < 0.1 {
        return if across { even } else { odd };
    }
    if miss(even) < miss(odd) { even } else { odd }
}
