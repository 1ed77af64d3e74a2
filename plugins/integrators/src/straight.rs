//! `straight`: light in flat space.
//!
//! One straight line a ray, one question to the intersector. Ignores a hole, and a throat: the two sides of a wormhole do not see each other. The default in a scene without one, and what
//! `rs 0` means under any integrator.
//!
//! It takes no parameters.
//!
//! ```bhs
//! Integrator "straight"
//! ```

use bhs_core::Plugin;
use bhs_core::geometry::Segment;
use bhs_core::intersector::{Ends, SHADOW_END};
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd, SurfaceHit};
use bhs_core::spacetime::{Place, Side, Spacetime};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, ShadowRay};
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::way::{CurvePart, Watch};
use bhs_engine::world::World;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn IntegratorBuilder> =
    Plugin { name: "straight", summary: "straight lines, ignoring any hole", build: |_| Some(Box::new(Straight)) };

/// Light in flat space.
#[derive(Clone, Copy, Debug)]
pub struct Straight;

impl IntegratorBuilder for Straight {
    fn build(&self, _: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        Ok(Box::new(Self))
    }

    fn is_curved(&self) -> bool {
        false
    }
}

impl Integrator for Straight {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        let cost = Cost { queries: 1, ..Cost::default() };
        for (ray, end) in rays.iter().zip(ends) {
            *end = RayEnd { arrival: arrival(world, ray), swept: 0.0, cost };
        }
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        let end = self.trace(world, ray);
        watch.point(0.0, ray.origin);
        if let Arrival::Surface(hit) = end.arrival {
            let way = hit.point - ray.origin;
            let ends = [0.0, way.length()];
            watch.point(ends[1], hit.point);
            let direction = way.normalize_or_zero();
            let curve = |s: f64| [ray.origin + direction * s, direction];
            watch.part(&CurvePart { ends, side: ray.side, curve: &curve });
        }
        end
    }

    fn escape_all(&self, world: &World, rays: &[(Ray, Side)], escaped: &mut [bool]) -> Cost {
        for ((ray, side), escaped) in rays.iter().zip(escaped) {
            let segment = Segment { origin: ray.origin, direction: ray.direction, t_min: 0.0, t_max: f64::INFINITY };
            *escaped = ray.side == *side && !blocked(world, *side, &segment, Ends { leaving: ray.leaving, target: None });
        }
        Cost { queries: rays.len() as u32, ..Cost::default() }
    }

    fn connections(&self) -> Option<&dyn Connections> {
        Some(self)
    }
}

impl Connections for Straight {
    fn turns(&self) -> u32 {
        1
    }

    fn connect(&self, _: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        // What is on different sides is joined by nothing.
        let turn = if x.side == y.side { turn } else { 1 };
        let way = y.x - x.x;
        let Some(direction) = way.try_normalize().filter(|_| turn == 0) else { return [None; 2] };
        [Some(Connection { launch: direction, arrival: direction, spread: way.length_squared(), phi: 0.0 }), None]
    }

    fn spread(&self, _: &World, x: Place, _: DVec3, y: Place, _: f64) -> Option<f64> {
        Some((y.x - x.x).length_squared())
    }

    fn connect_sky(&self, _: &World, x: Place, (direction, side): (DVec3, Side), turn: u32) -> ConnectionPair {
        [
            (turn == 0 && x.side == side).then_some(Connection { launch: direction, arrival: direction, spread: 1.0, phi: 0.0 }),
            None,
        ]
    }

    fn spread_sky(&self, _: &World, _: Place, _: DVec3, _: (DVec3, Side), _: f64) -> Option<f64> {
        Some(1.0)
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        for (ray, occluded) in shadow_rays.iter().zip(occluded) {
            let origin = ray.start.origin;
            let ends = Ends { leaving: ray.start.leaving, target: ray.target };
            // What ends on no surface must not be blocked by one that happens to be there.
            let t_max = if ends.target.is_some() { 1.0 } else { SHADOW_END };
            let segment = Segment { origin, direction: ray.to.x - origin, t_min: 0.0, t_max };
            *occluded = ray.start.side != ray.to.side || blocked(world, ray.to.side, &segment, ends);
        }
        Cost { queries: shadow_rays.len() as u32, ..Cost::default() }
    }
}

/// Where a straight ray ends.
#[inline]
fn arrival(world: &World, ray: &Ray) -> Arrival {
    let segment = Segment { origin: ray.origin, direction: ray.direction, t_min: 0.0, t_max: f64::INFINITY };
    let hit = match ray.leaving {
        _ if ray.side == Side::Far => world.half(Side::Far).and_then(|half| half.closest(&segment, ray.leaving)),
        None => world.intersector.closest(&segment),
        Some(_) => world.intersector.closest_from(&segment, ray.leaving),
    };
    let Some(hit) = hit else { return Arrival::Sky(ray.direction, ray.side) };
    let located = world.locate(&segment, &hit);
    Arrival::Surface(SurfaceHit {
        point: located.point,
        direction: ray.direction,
        geometry: hit.geometry,
        primitive: hit.primitive,
        barycentric: located.barycentric,
        is_crowded: hit.is_crowded,
    })
}

/// Whether anything on `side` stands between the ends of a segment.
fn blocked(world: &World, side: Side, segment: &Segment, ends: Ends) -> bool {
    match side {
        Side::Near => world.intersector.blocked_between(segment, ends),
        Side::Far => world.half(Side::Far).is_some_and(|half| half.blocked_between(segment, ends)),
    }
}
