//! Segments and boxes in single precision, as Embree wants them, losing as little as can be.

use bhs_core::geometry::{Aabb, Segment};
use embree4_sys::{RTCBounds, RTCRay};
use glam::DVec3;

/// Coordinates beyond this are cut off: their squares must be single-precision numbers.
const FAR: f64 = 1e18;

/// Growth of boxes around analytic surfaces, relative to the scene: the rounding of a segment's ends to single precision.
const GROWTH: f64 = 8.0 * f32::EPSILON as f64;

/// How far from the origin, in units of the scene's size, segments may start without losing precision that matters.
const NEAR: f64 = 4.0;

/// The part of space that the scene takes up.
#[derive(Clone, Copy)]
pub struct Room {
    /// Around everything, with a margin that keeps the outermost surfaces off the ends of segments that are cut at it.
    bounds: Aabb,
    /// Greatest coordinate.
    extent: f64,
}

/// How Embree's parameter relates to the segment's: `t = start + unit * tfar`.
#[derive(Clone, Copy)]
pub struct Scale {
    start: f64,
    unit: f64,
}

impl Scale {
    const SAME: Self = Self { start: 0.0, unit: 1.0 };

    /// The segment's parameter.
    pub fn t(self, tfar: f32) -> f64 {
        self.start + self.unit * f64::from(tfar)
    }

    /// Embree's parameter.
    pub fn tfar(self, t: f64) -> f32 {
        ((t - self.start) / self.unit) as f32
    }
}

/// A box of ordinary size; None if there is nothing in it.
pub fn clamp(b: Aabb) -> Option<Aabb> {
    let (min, max) = (b.min.max(DVec3::splat(-FAR)), b.max.min(DVec3::splat(FAR)));
    (!b.is_empty()).then_some(Aabb { min, max })
}

impl Room {
    /// Around these bounds.
    pub fn new(bounds: Aabb) -> Self {
        let extent = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        Self { bounds: bounds.grown(1e-3 * extent), extent }
    }

    /// A box in which the segment meets the content of `b` for certain, rounded or not.
    pub fn single_bounds(&self, b: Aabb) -> RTCBounds {
        let b = b.grown(GROWTH * self.extent);
        let [lower_x, lower_y, lower_z] = b.min.to_array().map(|x| (x as f32).next_down());
        let [upper_x, upper_y, upper_z] = b.max.to_array().map(|x| (x as f32).next_up());
        RTCBounds { lower_x, lower_y, lower_z, align0: 0.0, upper_x, upper_y, upper_z, align1: 0.0 }
    }

    /// Writes the segment to `ray`; None if it is no piece of a line, or passes the scene.
    ///
    /// It is written where Embree reads it, number by number: a copy of numbers just written, made in larger pieces, has to wait for them.
    #[inline(always)]
    pub fn cast(&self, segment: &Segment, ray: &mut RTCRay) -> Option<Scale> {
        let Segment { origin, direction, t_min, t_max } = *segment;
        // Each comparison fails for what is not a number.
        let is_near = origin.abs().cmple(DVec3::splat(NEAR * self.extent)).all() && t_min >= 0.0;
        let size = direction.abs();
        let is_sensible = size.cmple(DVec3::splat(1e6)).all() && size.cmpge(DVec3::splat(1e-6)).any();
        if is_near && is_sensible {
            write(ray, origin, direction, [t_min, t_max]);
            return (t_min <= t_max).then_some(Scale::SAME);
        }
        self.cast_unusual(segment, ray)
    }

    /// As [`Room::cast`], for a segment that starts far off or behind its origin, or has an extreme direction: it is cut to the
    /// room and stretched to a sensible direction in double precision.
    #[cold]
    #[inline(never)]
    fn cast_unusual(&self, segment: &Segment, ray: &mut RTCRay) -> Option<Scale> {
        let Segment { origin, direction, t_min, t_max } = *segment;
        let unit = direction.abs().max_element().recip();
        let is_piece = origin.is_finite() && direction.is_finite() && unit.is_finite() && t_min <= t_max;
        if !is_piece || self.bounds.is_empty() {
            return None;
        }
        let (start, end) = self.bounds.clip(origin, direction, t_min, t_max)?;
        let origin = segment.at(start);
        write(ray, origin, direction * unit, [0.0, (end - start) / unit]);
        origin.is_finite().then_some(Scale { start, unit })
    }
}

/// A ray that is to be written.
pub const UNWRITTEN: RTCRay = RTCRay {
    org_x: 0.0,
    org_y: 0.0,
    org_z: 0.0,
    tnear: 0.0,
    dir_x: 0.0,
    dir_y: 0.0,
    dir_z: 0.0,
    time: 0.0,
    tfar: 0.0,
    mask: u32::MAX,
    id: 0,
    flags: 0,
};

#[inline(always)]
fn write(ray: &mut RTCRay, origin: DVec3, direction: DVec3, [t_min, t_max]: [f64; 2]) {
    [ray.org_x, ray.org_y, ray.org_z] = origin.as_vec3().to_array();
    [ray.dir_x, ray.dir_y, ray.dir_z] = direction.as_vec3().to_array();
    (ray.tnear, ray.tfar) = (t_min as f32, t_max as f32);
}
