//! What finds the first surface along a straight segment.
//!
//! Two surfaces may touch, or be nearer to each other than single precision can tell. A ray that leaves one of them must meet the
//! other if that lies ahead, and must not if it lies behind. So a segment says which primitive it starts on (and, if it is a shadow
//! ray, which it ends on): that primitive is not met there, and every other one is ordered against it in double precision.
//!
//! Surfaces that coincide are crossed in a defined order, the same from both sides: of two surfaces that face away from each other,
//! as those of two solids in contact do, the light leaves the first solid before it enters the second; of two that face the same way
//! the geometry of the lower number lies in front, as seen along a fixed direction (see `bhs_intersectors::exact`).

use crate::geometry::{Geometry, Segment};
use glam::DVec3;

/// A surface met by a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Parameter of the segment, as accurate as the intersector makes it; `World::locate` of bhs-engine refines it.
    pub t: f64,
    /// Index of the geometry.
    pub geometry: u32,
    /// Index of the triangle in its mesh; 0 for an analytic surface.
    pub primitive: u32,
    /// Whether other surfaces may be as near to it there as rounding: see [`Intersector::is_crowded`].
    pub is_crowded: bool,
}

/// A triangle or an analytic surface, by its numbers in a [`PrimitiveHit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Primitive {
    /// Index of the geometry.
    pub geometry: u32,
    /// Index of the triangle in its mesh; 0 for an analytic surface.
    pub primitive: u32,
}

/// The primitives that a segment starts and ends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends {
    /// The primitive that the segment leaves at its origin, in full precision.
    pub leaving: Option<Primitive>,
    /// The primitive on which it ends at `t_max`, in full precision.
    pub target: Option<Primitive>,
}

/// How close to its end a shadow ray stops where the end is not known exactly, relative to its length: the surface at the end must not
/// shadow itself.
pub const SHADOW_END: f64 = 1.0 - 64.0 * f32::EPSILON as f64;

/// An acceleration structure over fixed geometry. Knows no curved light: it only ever sees segments.
pub trait Intersector: Send + Sync {
    /// The hit with the least `t` in the segment's range.
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit>;
    /// Whether anything is hit in the segment's range.
    fn blocked(&self, segment: &Segment) -> bool;

    /// [`Intersector::closest`] of a segment that starts in a crowd: other surfaces may be as near to its origin as rounding. If that lies on
    /// the primitive `leaving`: the first surface ahead; surfaces that coincide with that primitive at the origin are met, at 0, if they lie
    /// ahead in the order of coincident surfaces.
    fn closest_from(&self, segment: &Segment, _leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        self.closest(segment)
    }

    /// Whether anything stands between the ends of a segment that starts or ends on primitives.
    fn blocked_between(&self, segment: &Segment, ends: Ends) -> bool {
        let t_max = if ends.target.is_some() { SHADOW_END * segment.t_max } else { segment.t_max };
        self.blocked(&Segment { t_max, ..*segment })
    }

    /// Whether other surfaces may be as near to the point `point` of a surface as rounding, so that rays have to start
    /// exactly there, with [`Intersector::closest_from`]. Where it is not, a ray may be moved off its surface by
    /// [`Geometry::step_off`].
    fn is_crowded(&self, _point: DVec3) -> bool {
        false
    }
}

/// An intersector plugin: builds the structure once the geometry is there.
pub trait IntersectorBuilder: Send + Sync {
    /// Builds the structure; `geometries[i]` will be reported as geometry `i`.
    ///
    /// # Errors
    /// What went wrong, in a sentence.
    fn build(&self, geometries: &[Geometry]) -> Result<Box<dyn Intersector>, String>;
}
