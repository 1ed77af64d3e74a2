//! Where rays start, and points of their curves.

use bhs_core::intersector::Primitive;
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::Side;
use glam::DVec3;

/// A ray that is to be followed, besides its course.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Where the first chord begins: on the course, or just off a surface beside it (scene units).
    pub origin: DVec3,
    /// Unit chart direction.
    pub launch: DVec3,
    /// The side on which that is.
    pub side: Side,
    /// What the ray leaves, if the origin lies on it exactly.
    pub leaving: Option<Primitive>,
    /// The geometry on which it ends, if it does.
    pub target: Option<u32>,
    /// Largest distance between chords and course (scene units); may be infinite.
    pub gap: f64,
    /// The parameter at which the ray ends, if nothing stands in its way before.
    pub limit: f64,
}

/// Points of curves.
#[derive(Clone, Copy)]
pub(crate) struct Places<F> {
    /// Parameters.
    pub s: F,
    pub points: Vector<F>,
}

impl<F: Real> Places<F> {
    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub(crate) fn or(&self, o: &Self, which: F::Mask) -> Self {
        Self { s: F::select(which, self.s, o.s), points: self.points.or(o.points, which) }
    }

    /// The place of ray number `i`.
    pub(crate) fn lane(&self, i: usize) -> Place {
        Place { s: self.s.lane(i), point: self.points.lane(i) }
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Its parameter.
    pub s: f64,
    pub point: DVec3,
}

/// The side of ray number `i`, if the bits `far` are set of those on the far side.
#[inline]
pub(crate) fn side(far: u32, i: usize) -> Side {
    if far >> i & 1 == 1 { Side::Far } else { Side::Near }
}
