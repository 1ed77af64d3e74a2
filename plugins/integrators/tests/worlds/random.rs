//! Random worlds around, beside and across a hole, with triangles that nobody should make; and rays through them.

use crate::common::{Dice, ball, mesh, room, world};
use bhs_core::ray::{Arrival, Ray};
use bhs_engine::world::World;
use glam::DVec3;

/// A random world.
pub struct Case {
    pub world: World,
    /// Its size and its middle (scene units).
    pub scale: f64,
    pub at: DVec3,
    /// Whether a closed room is around all of it.
    pub closed: bool,
    /// Of each triangle of the first surface, the first one that has the same corners.
    twins: Vec<u32>,
}

/// Half the side of the closed room, in units of the scale.
const ROOM: f64 = 1.4;

/// Triangles of all sizes and shapes: `count` ordinary ones, then slivers, copies, and some without area.
fn triangles(dice: &mut Dice, count: usize) -> (Vec<[DVec3; 3]>, Vec<u32>) {
    let mut all: Vec<[DVec3; 3]> = (0..count)
        .map(|_| {
            let (middle, size) = (dice.point(1.0), 0.05 + dice.unit());
            std::array::from_fn(|_| middle + dice.point(size))
        })
        .collect();
    let mut twins: Vec<u32> = (0..count as u32).collect();
    for _ in 0..(dice.unit() * 6.0) as usize {
        let twin = (dice.unit() * count as f64) as usize;
        let [a, b, c] = all[twin];
        twins.push(all.len() as u32);
        all.push(match (dice.unit() * 5.0) as u32 {
            // A sliver between two corners, down to less than single precision can tell.
            0 => [a, b, a.lerp(b, dice.unit()) + (c - a) * 10f64.powf(dice.within(-8.0, -1.0))],
            // Without area.
            1 => [a, b, b],
            2 => [a, b, a.lerp(b, 2.0 * dice.unit())],
            3 => [c; 3],
            _ => {
                *twins.last_mut().expect("one has just been pushed") = twin as u32;
                [a, b, c]
            }
        });
    }
    (all, twins)
}

impl Case {
    /// The world number `number`: of any scale from 1e-6 to 1e6, away from the origin by as much as single precision leaves room
    /// for; and the dice to go on with.
    pub fn new(number: u64) -> (Self, Dice) {
        let mut dice = Dice(number);
        let scale = 10f64.powf(dice.within(-6.0, 6.0));
        let at = dice.point(3.0) * scale;
        (Self::sized(&mut dice, at, scale), dice)
    }

    /// A world of the size `scale` at `at`.
    pub fn sized(dice: &mut Dice, at: DVec3, scale: f64) -> Self {
        let count = 3 + (dice.unit() * 12.0) as usize;
        let (triangles, twins) = triangles(dice, count);
        let placed: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|p| at + p * scale)).collect();
        let mut surfaces = vec![mesh(&placed)];
        let balls: Vec<(DVec3, f64)> =
            (0..(dice.unit() * 4.0) as usize).map(|_| (dice.point(1.0), dice.within(0.02, 0.4))).collect();
        surfaces.extend(balls.iter().map(|(center, radius)| ball(at + *center * scale, radius * scale)));
        let closed = dice.unit() < 0.4;
        if closed {
            surfaces.push(room(at - scale * ROOM, at + scale * ROOM));
        }
        // Anywhere, or across a triangle, a corner or a wall, or within a ball.
        let [a, b, c] = triangles[0];
        let center = match (dice.unit() * 10.0) as u32 {
            0 | 1 => (a + b + c) / 3.0,
            2 => a,
            3 => DVec3::new(ROOM, dice.within(-1.0, 1.0), dice.within(-1.0, 1.0)),
            4 | 5 => balls.first().map_or(b, |(center, _)| *center),
            _ => dice.point(1.2),
        };
        let rs = scale * dice.within(0.002, 0.5) * dice.unit();
        let mut world = world(surfaces, at + center * scale, rs);
        // Every other one has to do without knowing where free space is.
        if dice.unit() < 0.5 {
            world.clearance = None;
        }
        Self { world, scale, at, closed, twins }
    }

    /// Whether two rays end on the same surface on the same turn around the hole, or both do not. Which one of equal triangles is
    /// hit does not matter.
    pub fn agree(&self, a: &End, b: &End) -> bool {
        let same_turn = !matches!(a.arrival, Arrival::Surface(_)) || (a.phi - b.phi).abs() < 1.0;
        self.outcome(&a.arrival) == self.outcome(&b.arrival) && same_turn
    }

    /// What an arrival is about, as far as two integrators must agree on it.
    pub fn outcome(&self, a: &Arrival) -> (u8, u32, u32) {
        match a {
            Arrival::Surface(hit) if hit.geometry == 0 => (0, 0, self.twins[hit.primitive as usize]),
            Arrival::Surface(hit) => (0, hit.geometry, hit.primitive),
            Arrival::Sky(..) => (1, 0, 0),
            Arrival::Captured => (2, 0, 0),
            Arrival::OutOfSteps => (3, 0, 0),
        }
    }

    /// Whether no ray from `origin` may reach the sky.
    pub fn encloses(&self, origin: DVec3) -> bool {
        self.closed && (origin - self.at).abs().max_element() < 0.999 * ROOM * self.scale
    }

    /// A ray from anywhere outside the horizon.
    pub fn ray(&self, dice: &mut Dice) -> (RayKind, Ray) {
        let hole = crate::common::hole_of(&self.world);
        let kind = match (dice.unit() * 100.0) as u32 {
            0..45 => RayKind::Anywhere,
            45..70 => RayKind::Aimed,
            70..85 => RayKind::NearHorizon,
            _ => RayKind::Critical,
        };
        loop {
            let far = if dice.unit() < 0.1 { 30.0 } else { 1.3 };
            let origin = match kind {
                RayKind::NearHorizon => hole.center + dice.direction() * hole.rs * (1.0 + 10f64.powf(dice.within(-6.0, 0.0))),
                _ => self.at + dice.point(far) * self.scale,
            };
            let from_hole = origin - hole.center;
            let r = from_hole.length();
            if r <= (1.0 + 1e-7) * hole.rs {
                continue;
            }
            let outward = from_hole / r;
            let direction = match kind {
                RayKind::Aimed => (dice.direction() * (dice.unit() * 4.0 * hole.rs / r) - outward).normalize(),
                RayKind::Critical => {
                    let b = (1.5 * 3f64.sqrt() * hole.rs) * (1.0 + 10f64.powf(dice.within(-9.0, -1.0)) * dice.within(-1.0, 1.0));
                    // b = r / sqrt(1/sin^2(alpha) - rs/r)
                    let sin = ((r / b).powi(2) + hole.rs / r).sqrt().recip().min(1.0);
                    let cos = (1.0 - sin * sin).sqrt();
                    let across = outward.cross(dice.direction()).normalize();
                    // Towards the photon sphere.
                    across * sin - outward * cos.copysign(r - 1.5 * hole.rs)
                }
                _ => dice.direction(),
            };
            return (kind, Ray::new(origin, direction.normalize()));
        }
    }
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    pub arrival: Arrival,
    /// Angle swept until there (rad).
    pub phi: f64,
}

/// Kinds of random rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From anywhere in any direction.
    Anywhere,
    /// Aimed at the hole or past it, within four of its radii.
    Aimed,
    /// From 1.000001 to 2 radii, in any direction.
    NearHorizon,
    /// With an impact parameter within 1e-1 to 1e-9 of the critical one, towards the photon sphere.
    Critical,
}
