//! What stands between two points of a ray.

use crate::adaptive;
use crate::common::Dice;
use crate::rooms::{ray, spacetimes, trace, world};
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Class, Place};
use bhs_engine::connections::{Connection, ShadowRay};
use bhs_integrators::graded_index::shadow::reaches;
use glam::DVec3;

const TOLERANCE: f64 = 1e-6;

fn shadow_ray(ray: &Ray, to: Place) -> ShadowRay {
    let connection = Connection { launch: ray.direction, arrival: DVec3::X, spread: 1.0, phi: 0.0 };
    ShadowRay { start: *ray, from: ray.origin, to, target: None, connection }
}

#[test]
fn rays_reach_what_they_meet_and_nothing_behind_it() {
    for (name, spacetime) in spacetimes().into_iter().filter(|(_, s)| matches!(s.class(), Class::Index(_))) {
        let mut dice = Dice(31);
        let (mut reached, mut through) = (0, 0);
        for _ in 0..6 {
            let world = world(&mut dice, &spacetime);
            for _ in 0..10 {
                let ray = ray(&mut dice, &world);
                let (Arrival::Surface(hit), sigma) = trace(&*adaptive(TOLERANCE, &spacetime), &world, &ray) else { continue };
                let to = world.place_of(&hit);
                assert!(reaches(&world, &shadow_ray(&ray, to), sigma, TOLERANCE), "{name}: {ray:?} {hit:?}");
                // A point behind the surface, about.
                let behind = Place { x: hit.point + 0.02 * hit.direction, ..to };
                assert!(!reaches(&world, &shadow_ray(&ray, behind), sigma + 0.02, TOLERANCE), "{name}: {ray:?} {hit:?}");
                let half_way = Place { x: ray.origin, ..to };
                assert!(reaches(&world, &shadow_ray(&ray, half_way), 0.5 * sigma, TOLERANCE), "{name}");
                reached += 1;
                through += u32::from(to.side != ray.side);
            }
        }
        assert!(reached > 30 && (through > 2 || !spacetime.has_far_side()), "{name}: {reached} {through}");
    }
}
