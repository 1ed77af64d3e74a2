//! Zones: where two surfaces are near each other.

use bhs_core::geometry::{Aabb, Segment};
use glam::DVec3;

/// The part of space within reach of two primitives.
#[derive(Clone, Copy)]
pub(crate) struct Zone {
    pub bounds: Aabb,
    /// Planes of those primitives that are flat: unit normal and distance from the origin.
    pub planes: [Option<(DVec3, f64)>; 2],
    pub reach: f64,
}

impl Zone {
    pub fn holds(&self, point: DVec3) -> bool {
        let near = |(n, distance): &(DVec3, f64)| (n.dot(point) - distance).abs() <= self.reach;
        self.bounds.contains(point) && self.planes.iter().flatten().all(near)
    }

    /// Whether it may reach into a box.
    pub fn may_hold(&self, middle: DVec3, half: DVec3) -> bool {
        let near = |(n, distance): &(DVec3, f64)| (n.dot(middle) - distance).abs() <= self.reach + n.abs().dot(half);
        self.planes.iter().flatten().all(near)
    }

    /// Whether the segment passes it.
    pub fn is_passed(&self, segment: &Segment) -> bool {
        let Segment { origin, direction, t_min, t_max } = *segment;
        let Some((mut enter, mut leave)) = self.bounds.clip(origin, direction, t_min, t_max) else { return false };
        for (n, distance) in self.planes.iter().flatten() {
            let (off, across) = (n.dot(origin) - distance, n.dot(direction));
            if across == 0.0 {
                if off.abs() > self.reach {
                    return false;
                }
                continue;
            }
            let (a, b) = ((-self.reach - off) / across, (self.reach - off) / across);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }
}
