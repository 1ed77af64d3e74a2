//! Light from far away: the geodesics between a point and a direction of the sky, against tracing them and against their neighbours.

#[path = "common/empty.rs"]
mod empty;
#[path = "connections/tracing.rs"]
#[allow(dead_code)]
mod tracing;

use bhs_core::geometry::Geometry;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::Spherical;
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::Exact;
use bhs_integrators::Tolerance;
use bhs_integrators::spherical::connect::connect;
use bhs_integrators::spherical::connect::sky::{connect_sky, spread_sky};
use empty::Empty;
use glam::DVec3;
use tracing::{Random, hole, pair};

/// Where the ray from `x` along `launch` leaves, and the angle that it sweeps.
fn traced(hole: &Spherical, x: DVec3, launch: DVec3) -> Option<(DVec3, f64)> {
    let world = World::new(Vec::<Geometry>::new(), Box::new(Empty), DVec3::ZERO)
        .in_spacetime(std::sync::Arc::new(*hole), bhs_core::observer::Conventions::NATURE);
    let end = Exact::new(Tolerance::Absolute(1e-9), 1_000_000).trace(&world, &Ray::new(x, launch));
    match end.arrival {
        Arrival::Sky(direction, _) => Some((direction, end.swept)),
        _ => None,
    }
}

#[test]
fn rays_leave_in_the_direction_that_was_asked_for_and_spread_as_their_neighbours_do() {
    let hole = hole(0.5);
    let mut random = Random(31);
    let (mut worst, mut worst_spread) = (0.0f64, 0.0f64);
    for i in 0..4000 {
        // From close to the horizon to far away; theta anywhere.
        let (r, theta) = (hole.rs * random.log(1.0 + 1e-3, 1e3).max(1.001), random.angle());
        let (x, far) = pair(&mut random, hole.center, r, r, theta);
        let direction = (far - hole.center).normalize();
        for (image, c) in connect_sky(&hole, x, direction, 0).into_iter().enumerate() {
            let c = c.unwrap_or_else(|| panic!("image {image} missing: r {r} theta {theta}"));
            let (arrived, phi) =
                traced(&hole, x, c.launch).unwrap_or_else(|| panic!("{i} {image}: captured, r {r} theta {theta}"));
            // Light that turns close to the photon sphere magnifies rounding by the inverse of its spread.
            let allowed = 1e-8 + 1e-12 / c.spread.clamp(1e-9, 1.0) + 1e-13 * phi.exp().powi(2);
            let miss = (arrived - direction).length();
            assert!(miss < allowed, "image {image}: misses by {miss:.1e}: r {r} theta {theta}");
            assert!((phi - c.phi).abs() < 1e-6, "image {image}: sweeps {phi} not {}", c.phi);
            worst = worst.max(miss);

            let spread = spread_sky(&hole, x, c.launch, direction, phi, 2).expect("among the first two");
            assert!((spread / c.spread - 1.0).abs() < 1e-9);
            // Directions around it: area of the parallelogram that they make in the sky.
            if (0.05..3.09).contains(&theta) {
                let (a, b) = c.launch.any_orthonormal_pair();
                let h = 1e-5 * c.spread.sqrt().recip().min(1.0);
                let at = |s: f64, t: f64| traced(&hole, x, (c.launch + a * (s * h) + b * (t * h)).normalize()).map(|a| a.0);
                let (Some(e), Some(w), Some(n), Some(s)) = (at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0)) else {
                    panic!("a neighbour is captured: r {r} theta {theta} image {image}")
                };
                let measured = (e - w).cross(n - s).length() / (4.0 * h * h);
                let error = (measured / c.spread - 1.0).abs();
                assert!(error < 2e-3, "image {image}: spread {} not {measured}: r {r} theta {theta}", c.spread);
                worst_spread = worst_spread.max(error);
            }
        }
    }
    eprintln!("worst miss {worst:.1e} rad, worst spread {worst_spread:.1e}");
}

#[test]
fn it_is_the_limit_of_points_ever_farther_away() {
    let hole = hole(0.5);
    let mut random = Random(32);
    for _ in 0..500 {
        let (r, theta) = (hole.rs * random.log(1.01, 100.0).max(1.01), random.angle());
        let (x, far) = pair(&mut random, hole.center, r, 1e7 * hole.rs, theta);
        let direction = (far - hole.center).normalize();
        for (image, c) in connect_sky(&hole, x, direction, 0).into_iter().enumerate() {
            let (c, near) = (c.expect("there"), connect(&hole, x, far, image as u32).expect("there"));
            assert!((c.launch - near.launch).length() < 1e-4, "image {image}: {c:?} {near:?}");
            let distance = (far - x).length();
            let ratio = near.spread / (distance * distance) / c.spread;
            assert!((ratio - 1.0).abs() < 1e-3, "image {image}: r {r} theta {theta} {ratio}");
        }
    }
}

#[test]
fn without_a_hole_to_speak_of_light_comes_straight() {
    let hole = hole(1e-14);
    let mut random = Random(33);
    for _ in 0..500 {
        let (x, far) = {
            let theta = 0.1 + 2.9 * random.angle() / std::f64::consts::PI;
            pair(&mut random, hole.center, 2.0, 2.0, theta)
        };
        let direction = (far - hole.center).normalize();
        let c = connect_sky(&hole, x, direction, 0)[0].expect("there");
        assert!((c.launch - direction).length() < 1e-11, "{c:?}");
        assert!((c.spread - 1.0).abs() < 1e-11, "{c:?}");
    }
}
