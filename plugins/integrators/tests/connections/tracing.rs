//! Random pairs of points, and orbits to hold connections against.

use bhs_core::spacetime::Spherical;
use bhs_engine::connections::Connection;
use bhs_integrators::spherical::connect::swept_angle;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Splitmix64: the same pairs on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, TAU * self.next());
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), z)
    }

    /// Log-uniform between `a` and `b`.
    pub fn log(&mut self, a: f64, b: f64) -> f64 {
        a * (b / a).powf(self.next())
    }

    /// A radius in units of rs: log-uniform from 1.0001 to a million, now and then close to the horizon.
    pub fn radius(&mut self) -> f64 {
        if self.next() < 0.2 { 1.0 + self.log(1e-4, 1.0) } else { self.log(1.0001, 1e6) }
    }

    /// An angle in (0, pi), now and then close to an end.
    pub fn angle(&mut self) -> f64 {
        match self.next() {
            x if x < 0.8 => PI * self.next(),
            x if x < 0.9 => self.log(1e-12, 1.0),
            _ => PI - self.log(1e-12, 1.0),
        }
    }
}

pub const CENTER: DVec3 = DVec3::new(0.3, -0.2, 0.7);

pub fn hole(rs: f64) -> Spherical {
    Spherical { center: CENTER, rs, charge_squared: 0.0 }
}

/// Two points at the given distances from the hole, `theta` apart, in a random plane.
pub fn pair(random: &mut Random, center: DVec3, r1: f64, r2: f64, theta: f64) -> (DVec3, DVec3) {
    let e1 = random.direction();
    let e2 = e1.cross(random.direction()).normalize();
    (center + e1 * r1, center + (e1 * theta.cos() + e2 * theta.sin()) * r2)
}

/// An orbit in units of rs, with `s = dU/dV(0)`.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    pub u: f64,
    pub v: f64,
    pub s: f64,
}

/// Follows U'' = 3/2 U^2 - U over the angle `phi`: stops with U < 0 where the orbit escapes, with U >= 1 where it is captured.
pub fn follow(u: f64, v: f64, phi: f64) -> Orbit {
    const ORDER: usize = 30;
    let mut left = phi;
    let (mut u, mut v, mut s, mut w) = (u, v, 0.0, 1.0);
    let (mut a, mut b) = ([0.0; ORDER + 1], [0.0; ORDER + 1]);
    while left > 0.0 {
        (a[0], a[1], b[0], b[1]) = (u, v, s, w);
        for k in 0..ORDER - 1 {
            let (mut square, mut product) = (0.0, 0.0);
            for i in 0..=k {
                square += a[i] * a[k - i];
                product += a[i] * b[k - i];
            }
            let over = 1.0 / ((k + 1) * (k + 2)) as f64;
            a[k + 2] = (1.5 * square - a[k]) * over;
            b[k + 2] = (3.0 * product - b[k]) * over;
        }
        let size = |c: &[f64; ORDER + 1], k: usize| (c[k].abs() / (c[0].abs() + c[1].abs())).powf(1.0 / k as f64);
        let rate = size(&a, ORDER).max(size(&a, ORDER - 1)).max(size(&b, ORDER)).max(size(&b, ORDER - 1));
        let h = f64::min(left, 0.25 / rate);
        let sum = |c: &[f64; ORDER + 1]| c.iter().rev().fold(0.0, |sum, c| sum * h + c);
        let slope = |c: &[f64; ORDER + 1]| (1..=ORDER).rev().fold(0.0, |sum, k| sum * h + k as f64 * c[k]);
        (u, v, s, w) = (sum(&a), slope(&a), sum(&b), slope(&b));
        left -= h;
        if !(0.0..1.0).contains(&u) {
            break;
        }
    }
    Orbit { u, v, s }
}

/// What following the launch direction of a connection finds near y.
pub struct Followed {
    /// Distance between y and the traced ray.
    pub miss: f64,
    /// Angle between the traced ray and the arrival direction [rad].
    pub turn: f64,
    /// By how much rounding of the launch direction moves the ray at y, per rounding error.
    pub sensitivity: f64,
}

/// Follows `c` from `x` to `y`.
pub fn trace(hole: &Spherical, x: DVec3, y: DVec3, c: &Connection, image: u32) -> Followed {
    let (from_x, from_y) = (x - hole.center, y - hole.center);
    let (r1, r2) = (from_x.length(), from_y.length());
    let e1 = from_x / r1;
    let across = c.launch - e1 * c.launch.dot(e1);
    let across = across - e1 * across.dot(e1);
    let sin = across.length();
    if sin < 1e-15 {
        // Radial, as far as numbers can say.
        return Followed {
            miss: (from_y - e1 * from_y.dot(e1)).length(),
            turn: (c.launch - c.arrival).length(),
            sensitivity: r1 + r2,
        };
    }
    let e2 = across / sin;
    let (u1, v1) = (hole.rs / r1, -hole.rs * c.launch.dot(e1) / (sin * r1));
    // The angle of y in the plane of the ray, with its windings. From the difference of the points where they are close.
    let swept = (y - x).dot(e2).atan2(from_y.dot(e1));
    let swept = swept + TAU * ((swept_angle(from_x.angle_between(from_y), image) - swept) / TAU).round();
    let end = follow(u1, v1, swept);
    let (sin_phi, cos_phi) = swept.sin_cos();
    let e_r = e1 * cos_phi + e2 * sin_phi;
    let e_phi = e2 * cos_phi - e1 * sin_phi;
    let tangent = (e_phi * end.u - e_r * end.v).normalize();
    // y minus the ray's point, radial part from u, the rest out of the plane.
    let gap = e_r * ((end.u - hole.rs / r2) / (end.u * hole.rs / r2) * hole.rs) + (from_y - e_r * from_y.dot(e_r));
    let miss = (gap - tangent * gap.dot(tangent)).length();
    // ds/dalpha in the plane, r dphi across it.
    let sin_beta = end.u / end.u.hypot(end.v);
    let in_plane = r2 * r2 / hole.rs * (end.s * u1 / (sin * sin)).abs() * sin_beta;
    Followed { miss, turn: (tangent - c.arrival).length(), sensitivity: in_plane + r2 * sin_phi.abs() / sin }
}

/// Rounding errors allowed in a launch direction, its components and those of the points.
pub const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The area between four rays around a connection, in space, per solid angle.
pub fn spread_in_space(hole: &Spherical, x: DVec3, y: DVec3, c: &Connection, image: u32, h: f64) -> f64 {
    let at = |direction: DVec3| {
        // Where a ray crosses the plane through y across the connection.
        let from_x = x - hole.center;
        let r1 = from_x.length();
        let e1 = from_x / r1;
        let across = direction - e1 * direction.dot(e1);
        let e2 = across.normalize();
        let (u1, v1) = (hole.rs / r1, -hole.rs * direction.dot(e1) / (across.length() * r1));
        let target = y - hole.center;
        let mut swept = target.dot(e2).atan2(target.dot(e1));
        swept += TAU * ((swept_angle(from_x.angle_between(target), image) - swept) / TAU).round();
        for _ in 0..4 {
            let end = follow(u1, v1, swept);
            let e_r = e1 * swept.cos() + e2 * swept.sin();
            let e_phi = e2 * swept.cos() - e1 * swept.sin();
            let rate = (e_phi * end.u - e_r * end.v) * (hole.rs / (end.u * end.u));
            let ahead = (target - e_r * (hole.rs / end.u)).dot(c.arrival);
            swept += ahead / rate.dot(c.arrival);
        }
        let end = follow(u1, v1, swept);
        (e1 * swept.cos() + e2 * swept.sin()) * (hole.rs / end.u)
    };
    let (a, b) = c.launch.any_orthonormal_pair();
    let moved = |d: DVec3| (at((c.launch + d * h).normalize()) - at((c.launch - d * h).normalize())) / (2.0 * h);
    moved(a).cross(moved(b)).dot(c.arrival).abs()
}
