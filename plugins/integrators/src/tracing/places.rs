//! Where rays start, and points of their curves.

use crate::tracing::surfaces::BothSides;
use bhs_core::ray::Ray;
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::Side;
use glam::DVec3;

/// Rays that are to be followed, one after the other.
pub trait StartingRays {
    /// Ray number `i`: its origin is where the first chord begins, on the course or just off a surface beside it.
    fn ray(&self, i: usize) -> &Ray;

    /// The geometry on which ray number `i` ends, if it does.
    fn target(&self, i: usize) -> Option<u32>;
}

impl StartingRays for &[Ray] {
    fn ray(&self, i: usize) -> &Ray {
        &self[i]
    }

    fn target(&self, _: usize) -> Option<u32> {
        None
    }
}

/// How rays start that are followed side by side, besides their course.
#[derive(Clone, Copy)]
pub struct Start<'r, F> {
    /// The rays.
    pub rays: &'r dyn StartingRays,
    /// The surfaces of both sides.
    pub surfaces: &'r BothSides<'r>,
    /// Their origins, as numbers side by side; lanes without a ray repeat the last one.
    pub origin: Vector<F>,
    /// Bits of those that start on the far side.
    pub far: u32,
    /// Bits of those that start exactly on a surface.
    pub departing: u32,
    /// Largest distances between their chords and courses (scene units); may be infinite.
    pub gap: F,
    /// The parameters at which they end, if no surface is met before.
    pub limit: F,
}

impl<'r, F: Real> Start<'r, F> {
    /// That of `rays` among `surfaces`, each of which `ray` gives by its number below `count`.
    #[inline(always)]
    pub fn new<'a>(
        surfaces: &'r BothSides<'r>,
        rays: &'r dyn StartingRays,
        count: usize,
        ray: impl Fn(usize) -> &'a Ray,
        (gap, limit): (F, F),
    ) -> Self {
        let (mut far, mut departing) = (0, 0);
        for i in 0..count {
            let Ray { side, leaving, .. } = ray(i);
            far |= u32::from(*side == Side::Far) << i;
            departing |= u32::from(leaving.is_some()) << i;
        }
        Self { rays, surfaces, origin: Vector::from_fn(|i| ray(i.min(count - 1)).origin), far, departing, gap, limit }
    }
}

/// Points of curves.
#[derive(Clone, Copy)]
pub(crate) struct CurvePoints<F> {
    /// Parameters.
    pub s: F,
    pub points: Vector<F>,
}

impl<F: Real> CurvePoints<F> {
    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub(crate) fn or(&self, o: &Self, which: F::Mask) -> Self {
        Self { s: F::select(which, self.s, o.s), points: self.points.or(o.points, which) }
    }

    /// The place of ray number `i`.
    pub(crate) fn lane(&self, i: usize) -> CurvePoint {
        CurvePoint { s: self.s.lane(i), point: self.points.lane(i) }
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurvePoint {
    /// Its parameter.
    pub s: f64,
    pub point: DVec3,
}

/// The side of ray number `i`, if the bits `far` are set of those on the far side.
#[inline]
pub(crate) fn side(far: u32, i: usize) -> Side {
    if far >> i & 1 == 1 { Side::Far } else { Side::Near }
}
