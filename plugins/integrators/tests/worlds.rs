//! The same outcome from every curved integrator, whatever the ray and the world; and no ray without an end.

mod common;

use bhs_core::integrator::{Arrival, Integrator, Ray};
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::flight::Tolerance;
use bhs_integrators::orbit::OrbitPlane;
use bhs_integrators::{Adaptive, Exact, Rk4, Straight};
use common::{Dice, ball, mesh, room, world};
use glam::DVec3;

/// Triangles and spheres of all sizes, some of them in a closed room, in a scene of the size `scale` at `at`, around, beside and across a hole.
fn random_world(dice: &mut Dice, at: DVec3, scale: f64) -> World {
    let count = 3 + (dice.unit() * 12.0) as usize;
    let mut surfaces = Vec::new();
    let triangles: Vec<[DVec3; 3]> = (0..count)
        .map(|_| {
            let (middle, size) = (dice.point(1.0), 0.05 + dice.unit());
            std::array::from_fn(|_| at + (middle + dice.point(size)) * scale)
        })
        .collect();
    surfaces.push(mesh(&triangles));
    for _ in 0..(dice.unit() * 4.0) as usize {
        surfaces.push(ball(at + dice.point(1.0) * scale, dice.within(0.02, 0.4) * scale));
    }
    if dice.unit() < 0.4 {
        surfaces.push(room(at - scale * 1.4, at + scale * 1.4));
    }
    let rs = scale * dice.within(0.002, 0.5) * dice.unit();
    world(surfaces, at + dice.point(1.2) * scale, rs)
}

/// A ray from anywhere in the scene outside the horizon: in any direction, or one aimed near the hole.
fn random_ray(dice: &mut Dice, world: &World, at: DVec3, scale: f64) -> Ray {
    let hole = world.hole.unwrap();
    loop {
        let far = if dice.unit() < 0.1 { 30.0 } else { 1.3 };
        let origin = at + dice.point(far) * scale;
        if (origin - hole.center).length() > 1.0001 * hole.rs {
            let to_hole = (hole.center - origin).normalize();
            let towards = dice.unit() < 0.3;
            let spread = dice.unit() * 4.0 * hole.rs / (origin - hole.center).length();
            let aimed = (to_hole + dice.direction() * spread).normalize();
            return Ray::new(origin, if towards { aimed } else { dice.direction() });
        }
    }
}

/// What an arrival is about, as far as two integrators must agree on it.
fn outcome(a: &Arrival) -> (u8, u32, u32) {
    match a {
        Arrival::Surface(hit) => (0, hit.geometry, hit.primitive),
        Arrival::Sky(_) => (1, 0, 0),
        Arrival::Hole => (2, 0, 0),
        Arrival::OutOfSteps => (3, 0, 0),
    }
}

fn trace(integrator: &dyn Integrator, world: &World, ray: &Ray) -> Arrival {
    let mut log = TraceLog::default();
    let arrival = integrator.trace(world, ray, &mut log);
    let finite = match &arrival {
        Arrival::Surface(h) => h.point.is_finite() && h.direction.is_normalized() && h.barycentric.is_finite(),
        Arrival::Sky(d) => d.is_normalized(),
        _ => true,
    };
    assert!(finite && log.phi.is_finite() && log.counters.steps < 5000, "{ray:?}: {arrival:?} {log:?}");
    arrival
}

#[test]
fn all_curved_integrators_agree_but_for_rays_that_pass_an_edge_within_the_tolerance() {
    // `BHS_WORLDS=250000 cargo test --release -p bhs-integrators --test worlds -- --nocapture` is ten million rays.
    let worlds = std::env::var("BHS_WORLDS").map_or(1000, |n| n.parse().expect("BHS_WORLDS is a number"));
    let (mut rays, mut different, mut ends) = (0u64, 0, [0u64; 4]);
    for case in 0..worlds {
        let mut dice = Dice(case);
        // Scales from 1e-6 to 1e6, away from the origin by as much as single precision leaves room for.
        let scale = 10f64.powf(dice.within(-6.0, 6.0));
        let at = dice.point(3.0) * scale;
        let world = random_world(&mut dice, at, scale);
        let hole = world.hole.unwrap();
        let tolerance = 1e-4 * scale;
        let exact = Exact::new(Tolerance::Absolute(tolerance), 4000);
        let adaptive = Adaptive::new(Tolerance::Absolute(tolerance), 4000);
        // Chords of the same tolerance; its orbits are better than that.
        let rk4 = Rk4::new((16.0 / 3.0 * tolerance / hole.rs).sqrt().min(0.02), 1_000_000);
        for _ in 0..40 {
            let ray = random_ray(&mut dice, &world, at, scale);
            let truth = trace(&exact, &world, &ray);
            let found = trace(&adaptive, &world, &ray);
            let by_steps = rk4.trace(&world, &ray, &mut TraceLog::default());
            rays += 1;
            ends[outcome(&truth).0 as usize] += 1;
            if outcome(&truth) == outcome(&found) && outcome(&truth) == outcome(&by_steps) {
                if let (Arrival::Surface(t), Arrival::Surface(f)) = (&truth, &found) {
                    assert!((t.point - f.point).cross(t.direction).length() < tolerance, "case {case} {ray:?}");
                }
                if let (Arrival::Sky(t), Arrival::Sky(f)) = (&truth, &found) {
                    assert!((*t - *f).length() < 1e-3, "case {case} {ray:?}: {t} {f}");
                }
                continue;
            }
            different += 1;
            // Rays a few tolerances beside this one do not agree with it either; or it is critical to within rk4's error.
            let (plane, start) = OrbitPlane::of_ray(hole.center, ray.origin, ray.direction);
            let form = ClosedForm::new(hole.rs, start.u, start.du);
            let (across, over) = ray.direction.any_orthonormal_pair();
            let reach = (world.bounds.max - world.bounds.min).length() + (ray.origin - at).length();
            let explained = form.epsilon().abs() < 1e-6
                || (0..32).any(|k| {
                    let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
                    let beside = (across * cos + over * sin) * (tolerance * f64::from(1 + k / 8));
                    let moved = Ray { origin: ray.origin + beside, ..ray };
                    let turned = Ray { direction: (ray.direction + beside / reach).normalize(), ..ray };
                    [moved, turned].iter().any(|r| outcome(&exact.trace(&world, r, &mut TraceLog::default())) != outcome(&truth))
                });
            assert!(explained, "case {case} {ray:?} {plane:?} {}:\n{truth:?}\n{found:?}\n{by_steps:?}", form.epsilon());
        }
    }
    eprintln!("{different} of {rays} rays differ; surface, sky, hole, given up: {ends:?}");
    assert!(ends[..3].iter().all(|n| *n > rays / 20) && ends[3] == 0, "{ends:?}");
    assert!(different * 100 < rays, "{different} of {rays} rays differ");
}

#[test]
fn all_regimes_of_the_reference_orbits_end_in_a_world_with_surfaces() {
    // The starts of tests/reference/ends.csv, each through a room around the hole and past a sphere.
    for line in include_str!("../../../tests/reference/ends.csv").lines().skip(1) {
        let x: Vec<f64> = line.split(',').skip(1).map(|t| t.parse().unwrap_or(f64::NAN)).collect();
        let (rs, u0, du0) = (x[0], x[1], x[2]);
        let r0 = 1.0 / u0;
        let size = (r0 * 2.0).min(50.0 * rs.max(1e-3 * r0));
        let surfaces = vec![room(DVec3::splat(-size), DVec3::splat(size)), ball(DVec3::new(0.3, 0.2, 0.1) * size, 0.2 * size)];
        let world = world(surfaces, DVec3::ZERO, rs);
        // cot(alpha) = -u'/u.
        let ray = Ray::new(DVec3::X * r0, DVec3::new(-du0, u0, 0.0).normalize());
        let tolerance = Tolerance::DEFAULT;
        let truth = trace(&Exact::new(tolerance, 4000), &world, &ray);
        let found = trace(&Adaptive::new(tolerance, 4000), &world, &ray);
        let by_steps = trace(&Rk4::new(0.05, 4000), &world, &ray);
        // Through the ray's direction, the orbit's numbers are rounded once more: that decides where it is critical to 1e-9.
        if !line.starts_with("critical") && !line.starts_with("photon") {
            assert_eq!(outcome(&truth), outcome(&found), "{line}");
            assert_eq!(outcome(&truth), outcome(&by_steps), "{line}");
        }
    }
}

#[test]
fn odd_rays_end_too() {
    let world = world(vec![room(DVec3::splat(-1.0), DVec3::splat(1.0))], DVec3::ZERO, 0.2);
    let (inside, nan) = (DVec3::X * 0.1, DVec3::NAN);
    let tolerance = Tolerance::DEFAULT;
    let tracers: [&dyn Integrator; 3] = [&Exact::new(tolerance, 1000), &Adaptive::new(tolerance, 1000), &Rk4::new(0.1, 1000)];
    for tracer in tracers {
        let trace =
            |origin: DVec3, direction: DVec3| tracer.trace(&world, &Ray::new(origin, direction), &mut TraceLog::default());
        assert_eq!(trace(inside, DVec3::X), Arrival::Hole);
        assert_eq!(trace(DVec3::X * 0.2, DVec3::X), Arrival::Hole);
        assert_eq!(trace(DVec3::ZERO, DVec3::X), Arrival::Hole);
        assert_eq!(trace(DVec3::X * 0.5, -DVec3::X), Arrival::Hole);
        assert!(matches!(trace(DVec3::X * 0.5, DVec3::X), Arrival::Surface(_)));
        for (origin, direction) in [(nan, DVec3::X), (DVec3::X * 0.5, nan), (DVec3::INFINITY, DVec3::X)] {
            assert_eq!(trace(origin, direction), Arrival::OutOfSteps);
        }
    }
}

#[test]
fn a_hole_without_size_is_none() {
    let mut dice = Dice(5);
    let world = random_world(&mut dice, DVec3::ZERO, 1.0);
    let flat = World { hole: world.hole.map(|h| bhs_core::blackhole::BlackHole { rs: 0.0, ..h }), ..world };
    for _ in 0..200 {
        let ray = Ray::new(dice.point(1.0), dice.direction());
        let straight = Straight.trace(&flat, &ray, &mut TraceLog::default());
        let tolerance = Tolerance::DEFAULT;
        let tracers: [&dyn Integrator; 3] = [&Exact::new(tolerance, 1000), &Adaptive::new(tolerance, 1000), &Rk4::new(0.1, 1000)];
        for tracer in tracers {
            let mut log = TraceLog::default();
            assert_eq!(tracer.trace(&flat, &ray, &mut log), straight);
            assert_eq!(log.counters.queries, 1);
        }
    }
}

#[test]
fn a_tiny_hole_changes_nothing_visible() {
    let mut dice = Dice(6);
    let world = random_world(&mut dice, DVec3::ZERO, 1.0);
    let tiny = World { hole: world.hole.map(|h| bhs_core::blackhole::BlackHole { rs: 1e-12, ..h }), ..world };
    for _ in 0..500 {
        let ray = Ray::new(dice.point(1.0), dice.direction());
        let straight = Straight.trace(&tiny, &ray, &mut TraceLog::default());
        let tolerance = Tolerance::DEFAULT;
        for tracer in [&Exact::new(tolerance, 1000) as &dyn Integrator, &Adaptive::new(tolerance, 1000)] {
            let mut log = TraceLog::default();
            let curved = tracer.trace(&tiny, &ray, &mut log);
            assert_eq!(outcome(&straight), outcome(&curved));
            if let (Arrival::Surface(a), Arrival::Surface(b)) = (&straight, &curved) {
                assert!((a.point - b.point).length() < 1e-9, "{a:?} {b:?}");
            }
            assert!(log.counters.queries <= 6, "{log:?}");
        }
    }
}
