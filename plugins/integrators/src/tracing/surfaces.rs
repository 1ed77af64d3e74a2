//! The surfaces that chords are put to, and how far single precision lets them be trusted.

use bhs_core::geometry::Aabb;
use bhs_core::spacetime::Side;
use bhs_engine::world::{Half, World};

/// How far a chord reaches beyond its ends, relative to the coordinates there: neighbouring chords overlap by more than single precision can tear
/// them apart. Also how far beside its facet a hit may lie, for the same reason.
pub(crate) const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// The surfaces of one side.
#[derive(Clone, Copy)]
pub struct Surfaces<'w> {
    /// What finds them.
    pub half: Half<'w>,
    /// A box around them with room for rounding.
    pub bounds: Aabb,
}

/// Those of both sides; `None` where there are none. Told once of a world, for the rays of a batch.
pub type BothSides<'w> = [Option<Surfaces<'w>>; 2];

impl<'w> Surfaces<'w> {
    /// Those of both sides of `world`.
    pub fn of(world: &'w World) -> BothSides<'w> {
        [Side::Near, Side::Far].map(|side| {
            let half = world.half(side).filter(|half| !half.bounds.is_empty())?;
            Some(Surfaces { half, bounds: half.bounds.grown(half.margin) })
        })
    }
}
