//! `micro-steps`: the method of Aikawa, Zhou and Wang 2019 to the letter: fixed micro-steps, and a hit is where a chord meets a surface.
//!
//! Each step of the orbit is one straight segment, and each segment is put to the intersector: none is longer because nothing is near,
//! and what a segment meets counts as it is, its point and its direction those of the chord. The baseline that everything else is
//! measured against. The same as `schwarzschild-rk4` with `"string hits" "chord"`.
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

use crate::flight::Flight;
use crate::orbit::{Dense, Fate, Rk4Orbit, Stepper};
use crate::schwarzschild_rk4::build_micro_steps;
use bhs_core::Plugin;
use bhs_core::geometry::Segment;
use bhs_core::integrator::{Arrival, Integrator, Ray, SurfaceHit};
use bhs_core::intersector::PrimitiveHit;
use bhs_core::spacetime::Side;
use crate::log::TraceLog;
use bhs_core::world::World;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Integrator> = Plugin {
    name: "micro-steps",
    summary: "light around a Schwarzschild hole by straight micro-steps, as Aikawa, Zhou and Wang 2019",
    build: build_micro_steps,
};

/// How far a segment reaches beyond its end, relative to the coordinates there: as much as the single precision of meshes could tear
/// neighbours apart.
const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// Follows `ray` by steps of the angle `step` (rad), at most `max_steps` of them.
pub fn follow(world: &World, ray: &Ray, step: f64, max_steps: u64, log: &mut TraceLog) -> Arrival {
    let flight = match Flight::begin(world, ray, log) {
        Ok(flight) => flight,
        Err(arrival) => return arrival,
    };
    let (rs, plane) = (flight.hole.rs, flight.plane);
    let mut orbit = Rk4Orbit { hole: rs.into(), step, state: flight.start };
    let (mut from, mut leaving) = (ray.origin, ray.leaving);
    for _ in 0..max_steps {
        let (step, fate) = orbit.advance();
        log.counters.steps += 1;
        let end = if fate == Fate::Underway { step.end } else { step.within_space(rs).end };
        // The last segment of a ray that leaves has no end.
        let (to, way, t_max) = if fate == Fate::Escaped {
            (from, plane.radial(end.phi), f64::INFINITY)
        } else {
            let to = plane.point(&end);
            let way = to - from;
            (to, way, 1.0 + OVERLAP * to.abs().max_element() / way.length())
        };
        log.counters.queries += 1;
        let segment = Segment { origin: from, direction: way, t_min: 0.0, t_max };
        let leaving = leaving.take();
        let own = leaving.filter(|own| {
            // A first segment on the other side than the ray has come back to its surface at once.
            let normal = world.geometries[own.geometry as usize].normal(own.primitive, from);
            normal.dot(way) * normal.dot(ray.direction) <= 0.0
        });
        let own = own.map(|own| PrimitiveHit { t: 0.0, geometry: own.geometry, primitive: own.primitive, is_crowded: true });
        let ahead = || match leaving {
            None => world.intersector.closest(&segment),
            Some(_) => world.intersector.closest_from(&segment, leaving),
        };
        if let Some(hit) = own.or_else(ahead) {
            let located = world.locate(&segment, &hit);
            log.counters.hit += 1;
            log.phi = plane.angle(step.start.phi, from, located.point);
            log.point(located.point);
            return Arrival::Surface(SurfaceHit {
                point: located.point,
                direction: way.normalize(),
                geometry: hit.geometry,
                primitive: hit.primitive,
                barycentric: located.barycentric,
                is_crowded: hit.is_crowded,
            });
        }
        log.phi = end.phi;
        log.point(to);
        match fate {
            Fate::Underway => from = to,
            Fate::Escaped => {
                log.counters.escaped += 1;
                return Arrival::Sky(way, Side::Near);
            }
            Fate::Captured => {
                log.counters.captured += 1;
                return Arrival::Hole;
            }
        }
    }
    log.counters.out_of_steps += 1;
    Arrival::OutOfSteps
}
