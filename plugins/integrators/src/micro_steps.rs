//! `micro-steps`: the method of Aikawa, Zhou and Wang 2019 to the letter: fixed micro-steps, and a hit is where a chord meets a surface.
//!
//! Each step of the orbit is one straight segment, and each segment is put to the intersector: none is longer because nothing is near,
//! and what a segment meets counts as it is, its point and its direction those of the chord. The baseline that everything else is
//! measured against. The same as `rk4` with `"string hits" "chord"`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `step` | float | 0.1 | rad | angle swept by one step |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "micro-steps" "float step" 0.05
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::spherical::orbit::{Dense, Fate, OrbitPlane, Rk4Orbit, Stepper};
use crate::straight::Straight;
use crate::tolerance::{STEPS, read_max_steps};
use bhs_core::Plugin;
use bhs_core::geometry::Segment;
use bhs_core::intersector::{Primitive, PrimitiveHit};
use bhs_core::params::Params;
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd, SurfaceHit};
use bhs_core::spacetime::{Class, Side, Spacetime};
use bhs_engine::connections::Connections;
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::way::{CurvePart, Watch};
use bhs_engine::world::World;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn IntegratorBuilder> = Plugin {
    name: "micro-steps",
    summary: "light around a Schwarzschild hole by straight micro-steps, as Aikawa, Zhou and Wang 2019",
    build: |p| Some(Box::new(MicroSteps::read(p))),
};

/// Light around a Schwarzschild hole by straight micro-steps.
#[derive(Clone, Copy, Debug)]
pub struct MicroSteps {
    /// Angle swept by one step, in radians.
    step: f64,
    /// Steps after which a ray is given up.
    max_steps: u64,
    connections: SphericalConnections,
}

impl MicroSteps {
    /// With steps of that angle (rad); gives up after so many.
    pub fn new(step: f64, max_steps: u64) -> Self {
        Self { step, max_steps, connections: SphericalConnections { turns: 1, chord: Chord::Angle(step) } }
    }

    /// With the parameters of a scene.
    pub(crate) fn read(p: &Params) -> Self {
        let (step, max_steps) = read_steps(p);
        Self { connections: SphericalConnections { turns: read_turns(p), chord: Chord::Angle(step) }, step, max_steps }
    }
}

/// The parameters `step` (rad) and `maxsteps`.
pub(crate) fn read_steps(p: &Params) -> (f64, u64) {
    let step = p.get_in("step", 0.1, 1e-6..=0.5, "rad", "angle swept by one step");
    let max_steps = read_max_steps(p, STEPS);
    (step, max_steps)
}

impl IntegratorBuilder for MicroSteps {
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        match spacetime.class() {
            Class::Flat => Ok(Box::new(Straight)),
            Class::Spherical(hole) if hole.charge_squared == 0.0 => Ok(Box::new(*self)),
            _ => Err("needs a spherical spacetime without charge, for its steps are those of a published method".to_owned()),
        }
    }
}

impl Integrator for MicroSteps {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        for (ray, end) in rays.iter().zip(ends) {
            *end = follow(world, ray, self.step, self.max_steps, None);
        }
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        follow(world, ray, self.step, self.max_steps, Some(watch))
    }

    fn connections(&self) -> Option<&dyn Connections> {
        Some(&self.connections)
    }
}

/// How far a segment reaches beyond its end, relative to the coordinates there: as much as the single precision of meshes could tear
/// neighbours apart.
const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// Follows `ray` by steps of the angle `step` (rad), at most `max_steps` of them; `watch` sees its way, in which a segment is a
/// part of the curve.
fn follow(world: &World, ray: &Ray, step: f64, max_steps: u64, mut watch: Option<&mut dyn Watch>) -> RayEnd {
    let Class::Spherical(hole) = world.spacetime().class() else {
        return match watch {
            Some(watch) => Straight.watched(world, ray, watch),
            None => Straight.trace(world, ray),
        };
    };
    if let Some(watch) = &mut watch {
        watch.point(0.0, ray.origin);
    }
    let mut show = |ends: [f64; 2], from: DVec3, to: DVec3| {
        if let Some(watch) = &mut watch {
            watch.point(ends[1], to);
            let tangent = (to - from) / (ends[1] - ends[0]);
            watch.part(&CurvePart { ends, side: Side::Near, curve: &|s| [from + tangent * (s - ends[0]), tangent] });
        }
    };
    let (plane, start) = OrbitPlane::of_ray(hole.center, ray.origin, ray.direction);
    let mut cost = Cost::default();
    let end = |arrival: Arrival, swept: f64, cost: Cost| RayEnd { arrival, swept, cost };
    if start.u * hole.rs >= 1.0 {
        return end(Arrival::Captured, 0.0, cost);
    }
    if !(start.u > 0.0 && start.du.is_finite()) {
        return end(Arrival::OutOfSteps, 0.0, cost);
    }
    let mut orbit = Rk4Orbit { hole: hole.rs.into(), step, state: start };
    let (mut from, mut leaving) = (ray.origin, ray.leaving);
    let mut swept = 0.0;
    for _ in 0..max_steps {
        let (step, fate) = orbit.advance();
        let state = if fate == Fate::Underway { step.end } else { step.within_space(hole.rs).end };
        // The last segment of a ray that leaves has no end.
        let (to, way, t_max) = if fate == Fate::Escaped {
            (from, plane.radial(state.phi), f64::INFINITY)
        } else {
            let to = plane.point(&state);
            let way = to - from;
            (to, way, 1.0 + OVERLAP * to.abs().max_element() / way.length())
        };
        cost += Cost { steps: 1, queries: 1, ..Cost::default() };
        let segment = Segment { origin: from, direction: way, t_min: 0.0, t_max };
        if let Some(hit) = first_hit(world, ray, &segment, leaving.take()) {
            let located = world.locate(&segment, &hit);
            let swept = plane.angle(step.start.phi, from, located.point);
            show([step.start.phi, swept], from, located.point);
            let PrimitiveHit { geometry, primitive, is_crowded, .. } = hit;
            let (point, direction, barycentric) = (located.point, way.normalize(), located.barycentric);
            let hit = SurfaceHit { point, direction, geometry, primitive, barycentric, is_crowded };
            return end(Arrival::Surface(hit), swept, cost);
        }
        swept = state.phi;
        if fate != Fate::Escaped {
            show([step.start.phi, swept], from, to);
        }
        match fate {
            Fate::Underway => from = to,
            Fate::Escaped => return end(Arrival::Sky(way, Side::Near), swept, cost),
            Fate::Captured => return end(Arrival::Captured, swept, cost),
        }
    }
    end(Arrival::OutOfSteps, swept, cost)
}

/// What a segment of `ray` meets, which leaves the primitive `leaving` exactly at its origin, if any.
fn first_hit(world: &World, ray: &Ray, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
    let Some(left) = leaving else { return world.intersector.closest(segment) };
    // A first segment on the other side than the ray has come back to its surface at once.
    let normal = world.geometries[left.geometry as usize].normal(left.primitive, segment.origin);
    if normal.dot(segment.direction) * normal.dot(ray.direction) <= 0.0 {
        return Some(PrimitiveHit { t: 0.0, geometry: left.geometry, primitive: left.primitive, is_crowded: true });
    }
    world.intersector.closest_from(segment, leaving)
}
