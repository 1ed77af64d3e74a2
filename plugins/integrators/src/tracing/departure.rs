//! Rays that begin exactly on a surface.

use crate::tracing::arc::Arc;
use crate::tracing::places::CurvePoint;
use bhs_core::intersector::Primitive;
use bhs_core::ray::Ray;
use bhs_engine::world::World;
use glam::DVec3;

/// How often the first chord of a ray that leaves a surface is halved at most to be on the right side of that.
const MOST_HALVINGS: u32 = 60;

/// How a ray leaves the surface on which it begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Departure {
    pub primitive: Primitive,
    /// A normal of the surface, on the side to which the ray goes.
    side: DVec3,
    /// Where the first chord was cut short, if it was (its parameter).
    pub cut: Option<f64>,
}

impl Departure {
    /// That of `ray`, if it begins exactly on a surface.
    #[cold]
    pub fn of(world: &World, ray: &Ray) -> Option<Self> {
        let primitive = ray.leaving?;
        let normal = world.geometries[primitive.geometry as usize].normal(primitive.primitive, ray.origin);
        Some(Self { primitive, side: normal * ray.direction.dot(normal).signum(), cut: None })
    }

    /// Where to cut the first chord, that from `from` to `to`, if the curve is not there on that side of the surface which it leaves to which
    /// it set out. So that surface is not in the chord's way, and where the curve comes back to it, a later chord meets it.
    pub fn cut_short<A: Arc<f64>>(&self, piece: &A, from: &CurvePoint, to: &CurvePoint) -> Option<CurvePoint> {
        let is_on_side = |place: &CurvePoint| self.side.dot(place.point - from.point) > 0.0;
        if is_on_side(to) {
            return None;
        }
        let mut length = to.s - from.s;
        for _ in 0..MOST_HALVINGS {
            length *= 0.5;
            let s = from.s + length;
            let place = CurvePoint { s, point: piece.point(s).into() };
            if is_on_side(&place) {
                return Some(place);
            }
        }
        None
    }
}
