//! A plain bounding volume hierarchy in double precision, without any cleverness: the oracle that the tests hold the fast
//! intersector against, and what is left where Embree cannot be had.
//!
//! Instances are taken apart: each of their triangles stands in the hierarchy, in render space. Everything is decided in double precision
//! (`exact`), so that rays always start exactly on the surface that they leave.
//!
//! ```bhs
//! Option "string intersector" "reference"
//! WorldBegin
//! ```

use crate::exact::Exact;
use bhs_core::Plugin;
use bhs_core::geometry::{Geometry, Segment};
use bhs_core::intersector::{Ends, Intersector, IntersectorBuilder, Primitive, PrimitiveHit};
use glam::DVec3;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn IntersectorBuilder> = Plugin {
    name: "reference",
    summary: "A plain bounding volume hierarchy in double precision; slow, the oracle of the tests",
    build: |_| Some(Box::new(Reference)),
};

/// Builder of the hierarchy.
pub struct Reference;

struct Hierarchy(Exact);

impl IntersectorBuilder for Reference {
    fn build(&self, geometries: &[Geometry]) -> Result<Box<dyn Intersector>, String> {
        crate::check(geometries)?;
        let count: usize = geometries.iter().map(|g| g.triangle_count().max(1)).sum();
        if u32::try_from(count).is_err() {
            return Err(format!("{count} triangles are more than can be numbered"));
        }
        let all = (0u32..).zip(geometries).flat_map(|(geometry, shape)| {
            let count = if let Geometry::Analytic(_) = shape { 1 } else { shape.triangle_count() as u32 };
            (0..count).map(move |primitive| Primitive { geometry, primitive })
        });
        Ok(Box::new(Hierarchy(Exact::new(geometries, all.collect()))))
    }
}

impl Intersector for Hierarchy {
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit> {
        self.0.closest(segment, None)
    }

    fn blocked(&self, segment: &Segment) -> bool {
        self.0.blocked(segment, Ends::default())
    }

    fn closest_from(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        self.0.closest(segment, leaving)
    }

    fn blocked_between(&self, segment: &Segment, ends: Ends) -> bool {
        self.0.blocked(segment, ends)
    }

    fn is_crowded(&self, _: DVec3) -> bool {
        true
    }
}
