//! Rays that leave surfaces.

use crate::adaptive;
use crate::common::Dice;
use crate::rooms::{ray, spacetimes, trace, world};
use bhs_core::ray::{Arrival, Ray};
use bhs_engine::world::World;

/// A ray that leaves what `ray` has met, to the side that it came from, often at grazing incidence; exactly or not.
fn bounced(dice: &mut Dice, world: &World, hit: &bhs_core::ray::SurfaceHit, is_exact: bool) -> Ray {
    let surface = world.surface(hit);
    let normal = if surface.normal.dot(hit.direction) < 0.0 { surface.normal } else { -surface.normal };
    let grazing = if dice.unit() < 0.5 { 10f64.powf(dice.within(-6.0, -1.0)) } else { dice.unit() };
    let along = normal.cross(dice.direction()).normalize();
    let direction = (along + normal * grazing).normalize();
    world.spawn(&bhs_core::ray::SurfaceHit { is_crowded: is_exact, ..*hit }, normal, direction)
}

#[test]
fn rays_that_leave_a_surface_do_not_end_on_it() {
    for (name, spacetime) in spacetimes() {
        for (tolerance, is_exact) in [(1e-2, false), (1e-2, true), (1e-4, false), (1e-4, true)] {
            let mut dice = Dice(41);
            let (mut bounces, mut again, mut true_again) = (0, 0, 0);
            for _ in 0..20 {
                let world = world(&mut dice, &spacetime);
                let integrator = adaptive(tolerance, &spacetime);
                let fine = adaptive(1e-7, &spacetime);
                for _ in 0..10 {
                    let mut ray = ray(&mut dice, &world);
                    for _ in 0..5 {
                        let Arrival::Surface(hit) = trace(&*integrator, &world, &ray).0 else { break };
                        ray = bounced(&mut dice, &world, &hit, is_exact);
                        assert_eq!(ray.side, world.side_of(hit.geometry));
                        bounces += 1;
                        let arrival = trace(&*integrator, &world, &ray).0;
                        assert!(!matches!(arrival, Arrival::Sky(..) | Arrival::OutOfSteps), "{name}: {ray:?} {arrival:?}");
                        let is_again =
                            |arrival: Arrival| matches!(arrival, Arrival::Surface(a) if a.primitive() == hit.primitive());
                        // Light bends towards the middle, away from the walls of the room around it: it comes back to one around the hole only.
                        let is_wall = world.geometries[hit.geometry as usize].triangle_count() == 12;
                        let goes_on = matches!(arrival, Arrival::Surface(a) if a.direction.dot(ray.direction) > 0.0);
                        assert!(!(is_wall && is_again(arrival) && goes_on), "{name}: {ray:?} {arrival:?}");
                        if is_again(arrival) {
                            again += 1;
                            true_again += u32::from(is_again(trace(&*fine, &world, &ray).0));
                        }
                    }
                }
            }
            // Those that come back do so however fine the chords.
            assert_eq!(again, true_again, "{name}: of {bounces}");
            assert!(bounces > 500 && again > 0 && again < bounces / 20, "{name}: {again} of {bounces}");
        }
    }
}
