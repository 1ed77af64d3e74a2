//! A world without surfaces.

use bhs_core::geometry::Segment;
use bhs_core::intersector::{Intersector, PrimitiveHit};

/// An intersector over no geometry.
pub struct Empty;

impl Intersector for Empty {
    fn closest(&self, _: &Segment) -> Option<PrimitiveHit> {
        None
    }

    fn blocked(&self, _: &Segment) -> bool {
        false
    }
}
