//! Shadow rays: whether something stands in the way of light between two points.

use crate::tracing::driver::{Course, follow};
use crate::tracing::places::Start;
use bhs_core::geometry::Segment;
use bhs_core::intersector::{Ends, Primitive};
use bhs_core::lanes::LANES;
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd};
use bhs_core::real::Real;
use bhs_core::spacetime::Place;
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

/// The start of a shadow ray, which ends at the parameter `limit` and whose chords stray from it by at most `gap` (scene units).
pub fn start(ray: &ShadowRay, limit: f64, gap: f64) -> Start {
    let Ray { origin, side, leaving, .. } = ray.start;
    let target = ray.target.map(|target| target.geometry);
    Start { origin, launch: ray.connection.launch, side, leaving, target, gap, limit }
}

/// Whether something stands in the way of each of `rays`, which begin as `starts` say and follow `course`, written to the places of `occluded`; and what
/// that took.
pub fn occluded<F: Real, C: Course<F>>(
    world: &World,
    rays: &[ShadowRay],
    starts: &[Start],
    course: &mut C,
    occluded: &mut [bool],
) -> Cost {
    let mut ends = [RayEnd::NONE; LANES];
    let ends = &mut ends[..rays.len()];
    let reached = follow(world, starts, course, MOST_STEPS, None, ends);
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
        // Beyond all surfaces nothing stands in the way.
        Arrival::Sky(_, side) => *side == to.side,
        Arrival::Captured => true,
        Arrival::OutOfSteps => false,
    }
}
