//! Shadow rays: whether a surface occludes one point from another along the geodesic between them.

use crate::tracing::driver::{Course, follow};
use crate::tracing::places::{Start, StartingRays};
use crate::tracing::surfaces::BothSides;
use bhs_core::geometry::Segment;
use bhs_core::intersector::{Ends, Primitive};
use bhs_core::lanes::LANES;
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Place, Side};
use bhs_engine::connections::ShadowRay;
use bhs_engine::world::World;

/// How close to its end a shadow ray may meet a surface without being occluded by it, relative to the coordinates there: the surface at the end must
/// not shadow itself.
const SHADOW_END: f64 = 64.0 * f32::EPSILON as f64;

/// How much farther than that a surface may be met that is the end.
const AT_END: f64 = 4.0;

/// Relative error of a shadow ray between its ends; it is to meet its end closer than `SHADOW_END`.
pub const ERROR: f64 = 1e-7;

/// Steps after which a shadow ray is given up.
const MOST_STEPS: u64 = 100_000;

/// Distance from its end within which the last chord of `ray` ends (scene units).
pub fn close(ray: &ShadowRay) -> f64 {
    SHADOW_END * ray.to.x.abs().max_element().max(ray.from.abs().max_element())
}

impl StartingRays for &[ShadowRay] {
    fn ray(&self, i: usize) -> &Ray {
        &self[i].start
    }

    fn target(&self, i: usize) -> Option<u32> {
        self[i].target.map(|target| target.geometry)
    }
}

/// How up to [`LANES`] shadow rays are followed side by side.
pub struct Sought<F> {
    /// Where their geodesics begin; lanes without a ray repeat the last one.
    pub x: Vector<F>,
    /// Unit chart directions there.
    pub d: Vector<F>,
    /// Bits of those that start on the far side.
    pub far: u32,
    limit: F,
    gap: F,
}

impl<F: Real> Sought<F> {
    /// That of `rays`; `end` says of each the parameter at which it ends, and how far its chords may stray from it (scene units).
    pub fn new(rays: &[ShadowRay], end: impl Fn(&ShadowRay) -> (f64, f64)) -> Self {
        let ray = |i: usize| &rays[i.min(rays.len() - 1)];
        let mut ends = [(0.0, 0.0); LANES];
        for (ray, place) in rays.iter().zip(&mut ends) {
            *place = end(ray);
        }
        let number = |f: fn((f64, f64)) -> f64| F::from_fn(|i| f(ends[i.min(rays.len() - 1)]));
        Self {
            x: Vector::from_fn(|i| ray(i).from),
            d: Vector::from_fn(|i| ray(i).connection.launch),
            far: rays.iter().enumerate().map(|(i, ray)| u32::from(ray.start.side == Side::Far) << i).sum(),
            limit: number(|(limit, _)| limit),
            gap: number(|(_, gap)| gap),
        }
    }

    /// Whether each of `rays` is occluded, which follow `course`, written to the places of `occluded`; and what that took.
    pub fn occluded<C: Course<F>>(
        &self,
        (world, surfaces): (&World, &BothSides<'_>),
        rays: &[ShadowRay],
        course: &mut C,
        occluded: &mut [bool],
    ) -> Cost {
        let start = Start::new(surfaces, &rays, rays.len(), |i| &rays[i].start, (self.gap, self.limit));
        let mut ends = [RayEnd::NONE; LANES];
        let ends = &mut ends[..rays.len()];
        let reached = follow(world, &start, course, MOST_STEPS, None, ends);
        let mut cost = Cost::default();
        for (i, (ray, occluded)) in rays.iter().zip(occluded).enumerate() {
            // Steps are counted of rays only.
            cost += Cost { steps: 0, ..ends[i].cost };
            *occluded = !match reached.place(i) {
                Some(place) => arrives_from(world, ray, place, &mut cost),
                None => arrives(world, ray, &ends[i].arrival),
            };
        }
        cost
    }
}

/// What a shadow ray ends on, if other surfaces may be as near to its end as rounding.
fn crowded_target(world: &World, ray: &ShadowRay) -> Option<Primitive> {
    ray.target.filter(|_| world.half(ray.to.side).is_some_and(|half| half.is_crowded(ray.to.x)))
}

/// Whether nothing stands between the end of a shadow ray and `last`, where its last chord ended.
fn arrives_from(world: &World, ray: &ShadowRay, last: Place, cost: &mut Cost) -> bool {
    let (Some(target), Some(half)) = (crowded_target(world, ray), world.half(last.side)) else { return true };
    cost.queries += 1;
    let segment = Segment { origin: last.x, direction: ray.to.x - last.x, t_min: 0.0, t_max: 1.0 };
    !half.blocked_between(&segment, Ends { leaving: None, target: Some(target) })
}

/// Whether a shadow ray that ended before its limit has come to where it was to.
fn arrives(world: &World, ray: &ShadowRay, arrival: &Arrival) -> bool {
    let to = ray.to;
    match arrival {
        Arrival::Surface(hit) => {
            let is_there = (hit.point - to.x).length() <= AT_END * close(ray);
            is_there
                && world.side_of(hit.geometry) == to.side
                && crowded_target(world, ray).is_none_or(|target| target.geometry == hit.geometry)
        }
        // Beyond all surfaces nothing occludes it.
        Arrival::Sky(_, side) => *side == to.side,
        Arrival::Captured => true,
        Arrival::OutOfSteps => false,
    }
}
