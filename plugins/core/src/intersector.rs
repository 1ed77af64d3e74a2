//! What finds the first surface along a straight segment.

use crate::geometry::{Geometry, Segment};

/// A surface met by a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Parameter of the segment, as accurate as the intersector makes it; [`crate::world::World::locate`] refines it.
    pub t: f64,
    /// Index of the geometry.
    pub geometry: u32,
    /// Index of the triangle in its mesh; 0 for an analytic surface.
    pub primitive: u32,
}

/// An acceleration structure over fixed geometry. Knows no curved light: it only ever sees segments.
pub trait Intersector: Send + Sync {
    /// The hit with the least `t` in the segment's range.
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit>;
    /// Whether anything is hit in the segment's range.
    fn blocked(&self, segment: &Segment) -> bool;
}

/// An intersector plugin: builds the structure once the geometry is there.
pub trait IntersectorBuilder: Send + Sync {
    /// Builds the structure; `geometries[i]` will be reported as geometry `i`.
    ///
    /// # Errors
    /// What went wrong, in a sentence.
    fn build(&self, geometries: &[Geometry]) -> Result<Box<dyn Intersector>, String>;
}
