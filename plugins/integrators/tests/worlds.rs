//! The same outcome from every curved integrator, whatever the ray and the world; and no ray without an end.

#![allow(clippy::print_stderr, reason = "tests say what they measured")]

mod common;
#[path = "worlds/random.rs"]
mod random;

use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spacetime::Spherical;
use bhs_engine::connections::ShadowRay;
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::orbit::{OrbitPlane, State};
use bhs_integrators::{Adaptive, Exact, Rk4, Straight};
use common::{Dice, ball, on_all_processors, room, world};
use glam::DVec3;
use random::{Case, End, RayKind};
use std::f64::consts::TAU;
use std::ops::AddAssign;
use std::sync::Arc;

fn trace(integrator: &dyn Integrator, world: &World, ray: &Ray) -> End {
    checked(ray, integrator.trace(world, ray))
}

/// The same of many rays at once.
fn trace_all(integrator: &dyn Integrator, world: &World, rays: &[Ray]) -> Vec<End> {
    let mut ends = vec![RayEnd::NONE; rays.len()];
    integrator.trace_all(world, rays, &mut ends);
    rays.iter().zip(ends).map(|(ray, end)| checked(ray, end)).collect()
}

fn checked(ray: &Ray, RayEnd { arrival, swept: phi, .. }: RayEnd) -> End {
    let finite = match &arrival {
        Arrival::Surface(h) => h.point.is_finite() && h.direction.is_normalized() && h.barycentric.is_finite(),
        Arrival::Sky(d, _) => d.is_normalized(),
        _ => true,
    };
    assert!(finite && phi.is_finite(), "{ray:?}: {arrival:?} {phi}");
    End { arrival, phi }
}

/// Integrators that are held against the exact one.
const NAMES: [&str; 3] = ["adaptive", "adaptive, side by side", "rk4"];

/// How many rays arrived where. Sums do not depend on the order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    /// By [`RayKind`].
    rays: [u64; 4],
    /// By what the exact integrator says: surface, sky, hole, given up.
    ends: [u64; 4],
    /// Rays that end otherwise than the exact ones, by kind, for each of [`NAMES`]: those that pass an edge within the tolerance.
    edges: [[u64; 4]; 3],
    /// Likewise, but those whose impact parameter is critical to within the integrator's error.
    critical: [[u64; 4]; 3],
    /// Rays that end as they must not.
    faults: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        let add = |a: &mut [u64; 4], b: [u64; 4]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        add(&mut self.rays, o.rays);
        add(&mut self.ends, o.ends);
        for i in 0..NAMES.len() {
            add(&mut self.edges[i], o.edges[i]);
            add(&mut self.critical[i], o.critical[i]);
        }
        self.faults += o.faults;
    }
}

/// Relative distance from `epsilon` = 0, the critical orbit, within which rounding or the steps' error decide how a ray ends.
const CRITICAL: [f64; 3] = [1e-11, 1e-11, 1e-8];

/// Error of epsilon that the steps make, where the integrator does not choose them for the ray: it turns the ray by as much as
/// epsilon changes, relative to itself.
const STEPPED: [f64; 3] = [0.0, 0.0, 1e-9];

/// Whether rays a few tolerances beside this one, or turned by as much, do not agree with it either.
fn passes_an_edge(case: &Case, exact: &Exact, ray: &Ray, truth: &End, tolerance: f64) -> bool {
    let (across, over) = ray.direction.any_orthonormal_pair();
    let bounds = case.world.bounds;
    let reach = (bounds.max - bounds.min).length() + (ray.origin - case.at).length();
    (0..32).any(|k| {
        let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
        let beside = (across * cos + over * sin) * (tolerance * f64::from(1 + k / 8));
        let moved = Ray { origin: ray.origin + beside, ..*ray };
        let turned = Ray { direction: (ray.direction + beside / reach).normalize(), ..*ray };
        [moved, turned].iter().any(|r| !case.agree(&trace(exact, &case.world, r), truth))
    })
}

/// How far beside an orbit a point is that sweeps about `phi`.
fn beside_orbit(plane: &OrbitPlane, form: &ClosedForm, point: DVec3, phi: f64) -> f64 {
    let from_center = point - plane.center;
    let angle = from_center.dot(plane.e2).atan2(from_center.dot(plane.e1));
    let phi = angle + ((phi - angle) / TAU).round() * TAU;
    let (u, du) = form.at(phi);
    let state = State { phi, u, du };
    (point - plane.point(&state)).cross(plane.direction(&state)).length()
}

/// Forty rays through the world number `number`.
fn compare_integrators(number: u64) -> Tally {
    let (case, mut dice) = Case::new(number);
    let (world, hole) = (&case.world, common::hole_of(&case.world));
    let tolerance = 1e-4 * case.scale;
    let exact = Exact::new(Tolerance::Absolute(tolerance), 4000);
    let adaptive = Adaptive::new(Tolerance::Absolute(tolerance), 4000);
    // Chords of the same tolerance; its orbits are better than that.
    let rk4 = Rk4::new((16.0 / 3.0 * tolerance / hole.rs).sqrt().min(0.02), 1_000_000);
    let mut tally = Tally::default();
    let rays: Vec<(RayKind, Ray)> = (0..40).map(|_| case.ray(&mut dice)).collect();
    let together = trace_all(&adaptive, world, &rays.iter().map(|r| r.1).collect::<Vec<_>>());
    for ((kind, ray), beside) in rays.into_iter().zip(together) {
        let truth = trace(&exact, world, &ray);
        tally.rays[kind as usize] += 1;
        tally.ends[case.outcome(&truth.arrival).0 as usize] += 1;
        let (plane, start) = OrbitPlane::of_ray(hole.center, ray.origin, ray.direction);
        let form = ClosedForm::new(hole.rs, start.u, start.du);
        let epsilon = form.epsilon().abs();
        let alone = [trace(&adaptive, world, &ray), beside, trace(&rk4, world, &ray)];
        assert_eq!(alone[0], alone[1], "world {number}: {ray:?} by itself, and beside others");
        for (i, found) in alone.into_iter().enumerate() {
            let mut fault = |what: &str| {
                // At once, for a run may take an hour.
                eprintln!("world {number}, {what}: {kind:?} {ray:?}, epsilon {epsilon:.1e}:\n{truth:?}\n{}: {found:?}", NAMES[i]);
                tally.faults += 1;
            };
            if case.encloses(ray.origin) && [&truth, &found].iter().any(|e| matches!(e.arrival, Arrival::Sky(..))) {
                fault("a closed room leaks");
            }
            let turn = STEPPED[i] / epsilon;
            match (&truth.arrival, &found.arrival) {
                _ if !case.agree(&found, &truth) => {
                    if epsilon < CRITICAL[i] {
                        tally.critical[i][kind as usize] += 1;
                    } else if passes_an_edge(&case, &exact, &ray, &truth, tolerance) {
                        tally.edges[i][kind as usize] += 1;
                    } else {
                        fault("another end");
                    }
                }
                _ if epsilon < CRITICAL[i] => {}
                (Arrival::Surface(t), Arrival::Surface(f)) => {
                    // From the tangent; or from the orbit itself, where hits at grazing incidence are far apart.
                    let tangent = (t.point - f.point).cross(t.direction).length();
                    let across = tangent.min(beside_orbit(&plane, &form, f.point, found.phi));
                    let allowed = tolerance + turn * case.scale;
                    if across >= allowed {
                        fault(&format!("beside it by {across:.1e}, allowed {allowed:.1e}"));
                    }
                }
                (Arrival::Sky(t, _), Arrival::Sky(f, _)) if (*t - *f).length() >= 1e-3 + turn => fault("another direction"),
                _ => {}
            }
        }
    }
    tally
}

#[test]
fn all_curved_integrators_agree_but_for_rays_that_pass_an_edge_within_the_tolerance() {
    // `BHS_WORLDS=250000 cargo test --release -p bhs-integrators --test worlds curved -- --nocapture` is ten million rays.
    let worlds = std::env::var("BHS_WORLDS").map_or(5000, |n| n.parse().expect("BHS_WORLDS is a number"));
    let tally = on_all_processors(worlds, compare_integrators);
    let rays: u64 = tally.rays.iter().sum();
    let kinds = [RayKind::Anywhere, RayKind::Aimed, RayKind::NearHorizon, RayKind::Critical];
    eprintln!("{rays} rays {kinds:?}: {:?}; surface, sky, hole, given up: {:?}", tally.rays, tally.ends);
    for (i, name) in NAMES.iter().enumerate() {
        eprintln!("{name} ends otherwise: past an edge {:?}, critical {:?}", tally.edges[i], tally.critical[i]);
        let [edges, critical] = [&tally.edges[i], &tally.critical[i]].map(|t| t.iter().sum::<u64>());
        assert!(edges * 10_000 < rays, "{name}: {edges} of {rays} rays end otherwise");
        assert!(critical * 50 < tally.rays[RayKind::Critical as usize], "{name}: {critical} critical rays end otherwise");
    }
    assert_eq!(tally.faults, 0, "see above");
    assert!(tally.ends[..3].iter().all(|n| *n > rays / 20) && tally.ends[3] == 0, "{tally:?}");
}

/// Shadow rays between random points of the world number `number`: how many are traced, how many are occluded, and of how many one by one and side by side differ.
fn compare_shadow_rays(number: u64) -> [u64; 3] {
    let (case, mut dice) = Case::new(number);
    let (world, integrator) = (&case.world, Adaptive::new(Tolerance::Absolute(1e-4 * case.scale), 4000));
    let connections = integrator.connections().expect("it joins points");
    let mut shadow_rays = Vec::new();
    for _ in 0..20 {
        let [x, y] = [case.ray(&mut dice).1.origin, case.ray(&mut dice).1.origin];
        for connection in connections
            .connect(world, bhs_core::spacetime::Place::near(x), bhs_core::spacetime::Place::near(y), 0)
            .into_iter()
            .flatten()
        {
            shadow_rays.push(ShadowRay {
                start: Ray::new(x, connection.launch),
                from: x,
                to: bhs_core::spacetime::Place::near(y),
                target: None,
                connection,
            });
        }
    }
    let mut together = vec![false; shadow_rays.len()];
    connections.occluded_all(world, &shadow_rays, &mut together);
    let mut alone = vec![false; shadow_rays.len()];
    for (ray, alone) in shadow_rays.chunks(1).zip(alone.chunks_mut(1)) {
        connections.occluded_all(world, ray, alone);
    }
    let differ = alone.iter().zip(&together).filter(|(a, b)| a != b).count();
    [shadow_rays.len(), together.iter().filter(|occluded| **occluded).count(), differ].map(|n| n as u64)
}

#[test]
fn several_shadow_rays_are_occluded_as_each_is() {
    let mut sums = [0; 3];
    for number in 0..400 {
        sums.iter_mut().zip(compare_shadow_rays(number)).for_each(|(sum, n)| *sum += n);
    }
    let [all, blocked, differ] = sums;
    eprintln!("{all} connections, {blocked} blocked, {differ} differ");
    assert!(all > 10_000 && blocked > all / 5 && blocked < all - all / 5, "{sums:?}");
    assert_eq!(differ, 0, "{sums:?}");
}

#[test]
fn the_number_of_processors_does_not_matter() {
    let mut one_after_the_other = Tally::default();
    (0..50).for_each(|number| one_after_the_other += compare_integrators(number));
    assert_eq!(on_all_processors(50, compare_integrators), one_after_the_other);
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
            for other in [found, by_steps] {
                let same = match (&truth.arrival, &other.arrival) {
                    (Arrival::Surface(t), Arrival::Surface(f)) => (t.geometry, t.primitive) == (f.geometry, f.primitive),
                    (t, f) => std::mem::discriminant(t) == std::mem::discriminant(f),
                };
                assert!(same, "{line}: {truth:?} {other:?}");
            }
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
        let trace = |origin: DVec3, direction: DVec3| tracer.trace(&world, &Ray::new(origin, direction)).arrival;
        assert_eq!(trace(inside, DVec3::X), Arrival::Captured);
        assert_eq!(trace(DVec3::X * 0.2, DVec3::X), Arrival::Captured);
        assert_eq!(trace(DVec3::ZERO, DVec3::X), Arrival::Captured);
        assert_eq!(trace(DVec3::X * 0.5, -DVec3::X), Arrival::Captured);
        assert!(matches!(trace(DVec3::X * 0.5, DVec3::X), Arrival::Surface(_)));
        for (origin, direction) in [(nan, DVec3::X), (DVec3::X * 0.5, nan), (DVec3::INFINITY, DVec3::X)] {
            assert_eq!(trace(origin, direction), Arrival::OutOfSteps);
            // Whatever the place for its end held before.
            let mut ends = [RayEnd { arrival: Arrival::Captured, ..RayEnd::NONE }; 9];
            tracer.trace_all(&world, &[Ray::new(origin, direction); 9], &mut ends);
            assert!(ends.iter().all(|end| end.arrival == Arrival::OutOfSteps), "{ends:?}");
        }
    }
}

#[test]
fn a_hole_without_size_is_none() {
    let mut dice = Dice(5);
    let case = Case::sized(&mut dice, DVec3::ZERO, 1.0);
    let none = Spherical { rs: 0.0, ..common::hole_of(&case.world) };
    let flat = case.world.in_spacetime(Arc::new(none), Conventions::NATURE);
    for _ in 0..200 {
        let ray = Ray::new(dice.point(1.0), dice.direction());
        let straight = Straight.trace(&flat, &ray).arrival;
        let tolerance = Tolerance::DEFAULT;
        let tracers: [&dyn Integrator; 3] = [&Exact::new(tolerance, 1000), &Adaptive::new(tolerance, 1000), &Rk4::new(0.1, 1000)];
        for tracer in tracers {
            let end = tracer.trace(&flat, &ray);
            assert_eq!((end.arrival, end.cost.queries), (straight, 1));
        }
    }
}

#[test]
fn a_tiny_hole_changes_nothing_visible() {
    let mut dice = Dice(6);
    let mut case = Case::sized(&mut dice, DVec3::ZERO, 1.0);
    let tiny = Spherical { rs: 1e-12, ..common::hole_of(&case.world) };
    case.world = case.world.in_spacetime(Arc::new(tiny), Conventions::NATURE);
    let tiny = &case.world;
    for _ in 0..500 {
        let ray = Ray::new(dice.point(1.0), dice.direction());
        let straight = Straight.trace(tiny, &ray).arrival;
        let tolerance = Tolerance::DEFAULT;
        for tracer in [&Exact::new(tolerance, 1000) as &dyn Integrator, &Adaptive::new(tolerance, 1000)] {
            let end = tracer.trace(tiny, &ray);
            let curved = end.arrival;
            assert_eq!(case.outcome(&straight), case.outcome(&curved));
            if let (Arrival::Surface(a), Arrival::Surface(b)) = (&straight, &curved) {
                assert!((a.point - b.point).length() < 1e-9, "{a:?} {b:?}");
            }
            assert!(end.cost.queries <= 6, "{end:?}");
        }
    }
}
