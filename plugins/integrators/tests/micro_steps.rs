//! The plain method, hits on chords of fixed steps: second order in the step, and one question a step.

mod common;

use bhs_core::geometry::Geometry;
use bhs_core::ray::{Arrival, Ray};
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::{Exact, MicroSteps};
use common::{Dice, ball, mesh, room, world};
use glam::DVec3;

const CENTER: DVec3 = DVec3::new(0.1, -0.2, 0.3);

/// Root mean square of the distances between hits with the given step and the true ones, of rays that start well away from `surface`.
fn error(world: &World, step: f64, rays: &[Ray]) -> f64 {
    let exact = Exact::new(Tolerance::Absolute(1e-9), 100_000);
    let chords = MicroSteps::new(step, 100_000);
    let (mut sum, mut count) = (0.0, 0);
    for ray in rays {
        let [true_end, found] = [&exact as &dyn Integrator, &chords].map(|i| i.trace(world, ray).arrival);
        let (Arrival::Surface(t), Arrival::Surface(f)) = (true_end, found) else { continue };
        // Grazing incidence makes small errors large, in its own order.
        if (t.primitive, t.geometry) == (f.primitive, f.geometry) && world.surface(&t).normal.dot(t.direction).abs() > 0.3 {
            sum += (t.point - f.point).length_squared();
            count += 1;
        }
    }
    assert!(count > rays.len() / 4, "{count}");
    (sum / f64::from(count as u32)).sqrt()
}

fn rays(count: usize) -> Vec<Ray> {
    let mut dice = Dice(7);
    let mut ray = || loop {
        let (origin, direction) = (dice.point(0.8), dice.direction());
        if (origin - CENTER).length() > 0.3 {
            return Ray::new(origin, direction);
        }
    };
    (0..count).map(|_| ray()).collect()
}

fn converges_with_order_two(surface: Geometry) {
    let world = world(vec![surface], CENTER, 0.1);
    let rays = rays(400);
    let errors = [0.08, 0.04, 0.02, 0.01].map(|step| error(&world, step, &rays));
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.25, "{errors:?}");
    }
    // Refined hits of the same orbits are better by far.
    assert!(errors[0] > 1e-6, "{errors:?}");
}

#[test]
fn hits_on_walls_converge_with_order_two() {
    converges_with_order_two(room(DVec3::splat(-1.0), DVec3::splat(1.0)));
}

#[test]
fn hits_on_a_sphere_converge_with_order_two() {
    converges_with_order_two(ball(DVec3::ZERO, 1.5));
}

#[test]
fn every_step_is_a_question() {
    let world = world(vec![room(DVec3::splat(-1.0), DVec3::splat(1.0))], CENTER, 0.1);
    for ray in rays(200) {
        let cost = MicroSteps::new(0.02, 100_000).trace(&world, &ray).cost;
        assert_eq!(cost.queries, cost.steps);
        assert_eq!((cost.leaps, cost.chords_skipped), (0, 0));
    }
}

#[test]
fn light_that_leaves_and_light_that_falls_in_ends_as_it_should() {
    // A wall far behind the rays: none of these meets it.
    let corners = [DVec3::new(-5.0, -5.0, -90.0), DVec3::new(5.0, -5.0, -90.0), DVec3::new(0.0, 5.0, -90.0)];
    let world = world(vec![mesh(&[corners])], DVec3::ZERO, 0.1);
    let chords = MicroSteps::new(0.01, 100_000);
    let exact = Exact::new(Tolerance::Absolute(1e-9), 100_000);
    let (mut fallen, mut escaped) = (0, 0);
    for i in 0..100 {
        // Impact parameters on both sides of 3 sqrt(3)/2 rs = 0.2598.
        let ray = Ray::new(DVec3::new(0.01 * f64::from(i), 0.0, -5.0), DVec3::Z);
        let [a, b] = [&chords as &dyn Integrator, &exact].map(|i| i.trace(&world, &ray).arrival);
        match (a, b) {
            (Arrival::Captured, Arrival::Captured) => fallen += 1,
            (Arrival::Sky(a, _), Arrival::Sky(b, _)) => {
                assert!((a - b).length() < 1e-4, "{i}: {a} {b}");
                escaped += 1;
            }
            _ => panic!("{i}: {a:?}, {b:?}"),
        }
    }
    assert_eq!((fallen, escaped), (26, 74));
}
