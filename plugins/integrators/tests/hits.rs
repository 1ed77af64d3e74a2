//! Hits on surfaces: on the true orbit and on the true surface, from the side that the light comes from.

mod common;

use bhs_core::geometry::Geometry;
use bhs_core::ray::{Arrival, Ray, SurfaceHit};
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::orbit::{OrbitPlane, State};
use bhs_integrators::{Adaptive, Exact, Rk4};
use common::{Dice, ball, faceted_ball, mesh, room, world};
use glam::DVec3;

fn exact(tolerance: f64) -> Exact {
    Exact::new(Tolerance::Absolute(tolerance), 10_000)
}

fn adaptive(tolerance: f64) -> Adaptive {
    Adaptive::new(Tolerance::Absolute(tolerance), 10_000)
}

fn surface(integrator: &dyn Integrator, world: &World, ray: &Ray) -> Option<SurfaceHit> {
    match integrator.trace(world, ray).arrival {
        Arrival::Surface(hit) => Some(hit),
        _ => None,
    }
}

/// Where the orbit of `ray` first passes through zero of `side`, found without chords: on points of the closed form, close
/// together, then by bisection. Also the direction there.
fn first_crossing(world: &World, ray: &Ray, side: impl Fn(DVec3) -> f64) -> Option<(DVec3, DVec3)> {
    let hole = common::hole_of(world);
    let (plane, start) = OrbitPlane::of_ray(hole.center, ray.origin, ray.direction);
    let form = ClosedForm::new(hole.rs, start.u, start.du);
    let state = |phi: f64| {
        let (u, du) = form.at(phi);
        State { phi, u, du }
    };
    let (mut phi, mut s) = (0.0, start);
    let first = side(ray.origin);
    while s.u * hole.rs < 1.0 && s.u > 0.02 {
        // Some 1/100 of a radian, or of the distance along a steep ray.
        let next = phi + 0.01 * s.u / (s.u.hypot(s.du));
        let ahead = state(next);
        if ahead.u > 0.02 && ahead.u * hole.rs < 1.0 && side(plane.point(&ahead)) * first < 0.0 {
            let (mut lo, mut hi) = (phi, next);
            for _ in 0..200 {
                let middle = 0.5 * (lo + hi);
                if side(plane.point(&state(middle))) * first < 0.0 { hi = middle } else { lo = middle }
            }
            let s = state(0.5 * (lo + hi));
            return Some((plane.point(&s), plane.direction(&s)));
        }
        (phi, s) = (next, ahead);
    }
    None
}

#[test]
fn hits_lie_on_the_orbit_and_on_the_plane_to_twelve_digits() {
    let [a, b, c] = [DVec3::new(-40.0, -60.0, -0.875), DVec3::new(50.0, -40.0, -0.375), DVec3::new(0.0, 70.0, -0.5)];
    let n = (b - a).cross(c - a).normalize();
    let center = DVec3::new(0.1, -0.2, 0.3);
    let floor = world(vec![mesh(&[[a, b, c]])], center, 0.15);
    let mut dice = Dice(1);
    let (mut hits, mut checked) = (0, 0);
    while hits < 3000 {
        let ray = Ray::new(dice.point(1.0) + DVec3::Z, dice.direction());
        let expected = first_crossing(&floor, &ray, |p| n.dot(p - a));
        let end = exact(1e-3).trace(&floor, &ray);
        let Arrival::Surface(hit) = end.arrival else { continue };
        hits += 1;
        let Some((point, direction)) = expected else { continue };
        checked += 1;
        // A hit at grazing incidence is that much less certain.
        let steep = n.dot(direction).abs();
        assert!((hit.point - point).length() < 1e-12 / steep, "{ray:?}: {} {point}", hit.point);
        assert!((hit.direction - direction).length() < 1e-12 / steep);
        assert!(n.dot(hit.point - a).abs() < 1e-13);
        let weights = a + (b - a) * hit.barycentric.x + (c - a) * hit.barycentric.y;
        assert!((weights - hit.point).length() < 1e-12);
        // Back from the hit, after the same angle, light is at the start again.
        let (plane, back) = OrbitPlane::of_ray(center, hit.point, -hit.direction);
        let (u, du) = ClosedForm::new(0.15, back.u, back.du).at(end.swept);
        assert!((plane.point(&State { phi: end.swept, u, du }) - ray.origin).length() < 1e-9, "{ray:?}");
        // The adaptive one is as good as it is asked to be, measured across the ray; its surface is the same plane.
        for tolerance in [1e-3, 1e-5, 1e-8] {
            let end = adaptive(tolerance).trace(&floor, &ray);
            let Arrival::Surface(found) = end.arrival else { panic!("{ray:?}") };
            let across = (found.point - point).cross(direction).length();
            assert!(across < tolerance, "{ray:?}: {across:.1e} > {tolerance}, at {point} after {}", end.swept);
            assert!(n.dot(found.point - a).abs() < 1e-13);
        }
    }
    assert!(checked > 2500, "{checked}");
}

#[test]
fn hits_lie_on_the_orbit_and_on_the_sphere_to_twelve_digits() {
    let (center, radius) = (DVec3::new(0.7, 0.1, -0.2), 0.45);
    let shell = world(vec![ball(center, radius)], DVec3::new(-0.1, 0.1, 0.05), 0.1);
    let mut dice = Dice(2);
    let (mut checked, mut inside) = (0, 0);
    while checked < 1500 {
        let origin = dice.point(1.5);
        let ray = Ray::new(origin, dice.direction());
        let Some((point, direction)) = first_crossing(&shell, &ray, |p| (p - center).length() - radius) else { continue };
        let steep = (point - center).normalize().dot(direction).abs();
        let Some(hit) = surface(&exact(1e-3), &shell, &ray) else {
            assert!(steep < 0.1, "missed at {point}, cosine {steep}");
            continue;
        };
        if (hit.point - point).length() > 0.1 {
            // A grazing entry closer than the tolerance was passed by; the ray goes on to something else.
            assert!(steep < 0.1, "{} instead of {point}, cosine {steep}", hit.point);
            continue;
        }
        checked += 1;
        inside += u32::from((origin - center).length() < radius);
        assert!((hit.point - point).length() < 1e-12 / steep, "{ray:?}: {} {point}", hit.point);
        assert!((hit.direction - direction).length() < 1e-12 / steep);
        assert!(((hit.point - center).length() - radius).abs() < 1e-14);
        let found = surface(&adaptive(1e-5), &shell, &ray).expect("a hit of the exact ray");
        assert!((found.point - point).cross(direction).length() < 1e-5);
    }
    assert!(inside > 50, "{inside}");
}

#[test]
fn chords_stray_from_the_orbit_by_no_more_than_the_tolerance() {
    // Nothing to hit but two specks in opposite corners, which set the bounds.
    let speck = |at: DVec3| [at, at + DVec3::X * 1e-6, at + DVec3::Y * 1e-6];
    let mut dice = Dice(7);
    let (mut chords, mut farthest) = (0, 0.0f64);
    for _ in 0..1000 {
        let (center, rs) = (dice.point(1.2), 0.4 * dice.unit());
        let empty = world(vec![mesh(&[speck(DVec3::splat(-1.0)), speck(DVec3::splat(1.0))])], center, rs);
        let ray = Ray::new(dice.point(1.0), dice.direction());
        if (ray.origin - center).length() < 1.001 * rs {
            continue;
        }
        let reach = (empty.bounds.min - center).abs().max((empty.bounds.max - center).abs()).length();
        let (plane, start) = OrbitPlane::of_ray(center, ray.origin, ray.direction);
        let form = ClosedForm::new(rs, start.u, start.du);
        if form.epsilon().abs() < 1e-9 {
            continue;
        }
        for tolerance in [3e-2, 1e-3, 1e-5] {
            for tracer in [&exact(tolerance) as &dyn Integrator, &adaptive(tolerance)] {
                let (_, points) = tracer.polyline(&empty, &ray);
                let mut phi = 0.0;
                for ends in points.windows(2) {
                    let [a, b] = ends else { unreachable!() };
                    let outward = [*a, *b].map(|p| (p - center).normalize());
                    let swept = outward[0].cross(outward[1]).length().atan2(outward[0].dot(outward[1]));
                    let along = (*b - *a).normalize();
                    for k in 1..16 {
                        let at = phi + swept * f64::from(k) / 16.0;
                        let (u, du) = form.at(at);
                        let point = plane.point(&State { phi: at, u, du });
                        // Beyond the sphere around all geometry, where chords are cut, nothing can be missed.
                        if u * reach < 1.0 {
                            continue;
                        }
                        let gap = (point - *a).cross(along).length();
                        farthest = farthest.max(gap / tolerance);
                        assert!(gap <= tolerance, "{gap:.2e} > {tolerance}: {ray:?}, hole {center} {rs}, phi {at}");
                    }
                    phi += swept;
                    chords += 1;
                }
            }
        }
    }
    eprintln!("{chords} chords, farthest {farthest:.2} tolerances from the orbit");
    assert!(chords > 100_000 && farthest > 0.9, "{chords} {farthest}");
}

#[test]
fn refined_hits_of_runge_kutta_converge_with_order_four() {
    let floor = [[DVec3::new(-9.0, -9.0, -1.0), DVec3::new(9.0, -9.0, -0.5), DVec3::new(0.0, 30.0, -0.5)]];
    let floor = world(vec![mesh(&floor)], DVec3::ZERO, 0.2);
    let ray = Ray::new(DVec3::new(-1.0, 0.2, 0.75), DVec3::new(0.9, 0.8, -0.5).normalize());
    let truth = surface(&exact(1e-3), &floor, &ray).unwrap().point;
    let error = |step: f64| (surface(&Rk4::new(step, 10_000), &floor, &ray).unwrap().point - truth).length();
    let slope = (error(0.04) / error(0.01)).log2() / 2.0;
    assert!((3.9..=4.1).contains(&slope), "slope {slope:.3}: chords are of order 2, refined hits of the orbit's order");
}

#[test]
fn a_grazing_ray_does_not_end_on_the_surface_that_it_leaves() {
    // Light that leaves a floor at a small angle and bends down to a hole beneath it: the first chord dips below the floor at
    // once, the light itself comes back to it farther away.
    let (min, max) = (DVec3::new(-4.0, -4.0, 0.0), DVec3::new(4.0, 4.0, 0.0));
    let corners = [min, DVec3::new(max.x, min.y, 0.0), max, DVec3::new(min.x, max.y, 0.0)];
    let floor = || mesh(&[[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
    let center = DVec3::new(0.0, 0.0, -0.5);
    let wall = mesh(&[[DVec3::new(0.0, -4.0, 0.0), DVec3::new(0.0, 4.0, 0.0), DVec3::new(0.0, 0.0, 9.0)]]);
    let bare = world(vec![floor()], center, 0.1);
    let divided = world(vec![floor(), wall], center, 0.1);
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let tracers: [&dyn Integrator; 3] = [&exact(tolerance), &adaptive(tolerance), &Rk4::new(0.05, 10_000)];
        for tracer in tracers {
            for slope in [0.02, 0.04, 0.06, 0.08] {
                let direction = DVec3::new(1.0, 0.2, slope).normalize();
                let ray = Ray::new(DVec3::new(-0.7, -0.1, 4e-6), direction);
                let (truth, _) = first_crossing(&bare, &ray, |p| p.z).expect("it comes back to the floor");
                assert!((truth - ray.origin).length() > 0.2, "{truth}");
                let hit = surface(tracer, &bare, &ray).expect("a hit on the floor");
                assert!((hit.point - truth).length() < 1e-3, "slope {slope}, tolerance {tolerance}: {} {truth}", hit.point);
                // A wall in between is not passed by.
                if truth.x > 0.01 {
                    let hit = surface(tracer, &divided, &ray).expect("a hit on the wall");
                    assert!(hit.geometry == 1 && hit.point.x.abs() < 1e-12, "{hit:?}");
                }
            }
        }
    }
}

#[test]
fn light_that_skims_a_faceted_ball_around_the_hole_ends_where_the_orbit_does() {
    // A ball of 512 facets with the hole inside: rays that leave it at grazing angles bend around its curve, chords cut it.
    let center = DVec3::new(0.2, -0.1, 0.3);
    let shell = world(vec![faceted_ball(center, 0.5, 3)], center, 0.12);
    let mut dice = Dice(3);
    let (mut same, mut count) = (0, 0);
    for _ in 0..600 {
        let outward = dice.direction();
        let Some(start) = surface(&exact(1e-4), &shell, &Ray::new(center + outward * 0.8, -outward)) else {
            panic!("the ball is closed");
        };
        let normal = shell.surface(&start).normal;
        let along = normal.cross(dice.direction()).normalize();
        let ray = shell.spawn(&start, normal, (along + normal * dice.within(0.01, 0.4)).normalize());
        let truth = exact(1e-6).trace(&shell, &ray).arrival;
        let found = exact(1e-3).trace(&shell, &ray).arrival;
        count += 1;
        match (truth, found) {
            (Arrival::Surface(t), Arrival::Surface(f)) => {
                same += i32::from(t.primitive == f.primitive && (t.point - f.point).length() < 1e-9);
                assert!((t.point - f.point).length() < 0.3, "{t:?} {f:?}");
            }
            (Arrival::Sky(a, _), Arrival::Sky(b, _)) => {
                assert!((a - b).length() < 1e-12);
                same += 1;
            }
            // Passing an edge within the tolerance.
            _ => {}
        }
    }
    assert!(same * 100 > count * 98, "{same} of {count}");
}

#[test]
fn nothing_leaks_from_a_closed_room() {
    let mut dice = Dice(4);
    let (mut bounces, mut worst_queries) = (0u64, 0u64);
    for case in 0..600 {
        let half = DVec3::new(dice.within(0.3, 1.0), dice.within(0.3, 1.0), dice.within(0.3, 1.0));
        let at = dice.point(1.0);
        let mut surfaces: Vec<Geometry> = vec![room(at - half, at + half)];
        if case % 2 == 0 {
            surfaces.push(faceted_ball(at + dice.point(0.1), 0.15, 1));
        }
        if case % 3 == 0 {
            surfaces.push(ball(at + dice.point(0.15), 0.1));
        }
        // Inside the room, across its walls, or outside of it.
        let hole = at + dice.point(1.5);
        let rs = 0.3 * dice.unit() * dice.unit();
        let closed = world(surfaces, hole, rs);
        let tracers: [&dyn Integrator; 3] = [&exact(1e-3), &adaptive(1e-3), &Rk4::new(0.1, 10_000)];
        let tracer = tracers[case % 3];
        for _ in 0..20 {
            let mut ray = Ray::new(at + half * 0.99 * dice.point(1.0), dice.direction());
            for _ in 0..6 {
                let end = tracer.trace(&closed, &ray);
                let hit = match end.arrival {
                    Arrival::Surface(hit) => hit,
                    Arrival::Captured => break,
                    other => panic!("case {case}: {ray:?} leaves the room: {other:?}, hole {hole} rs {rs}"),
                };
                worst_queries = worst_queries.max(u64::from(end.cost.queries));
                assert!((hit.direction.length() - 1.0).abs() < 1e-12 && hit.point.is_finite());
                assert!(end.swept.is_finite());
                let normal = closed.surface(&hit).normal;
                let normal = if hit.direction.dot(normal) > 0.0 { -normal } else { normal };
                ray = closed.spawn(&hit, normal, (dice.direction() + normal * 1.0001).normalize());
                bounces += 1;
                if (ray.origin - hole).length() <= rs {
                    break;
                }
            }
        }
    }
    eprintln!("{bounces} bounces, at most {worst_queries} queries a ray");
    assert!(bounces > 30_000);
}

#[test]
fn light_that_leaves_a_ball_around_the_hole_ends_on_it_only_where_it_comes_back() {
    // Outside of 1.5 rs light that moves outwards never turns back. Within, what leaves with b > b_crit does, and arrives from outside:
    // with sin(alpha) > b_crit sqrt(f)/r in the local frame, whose tangents are those of the chart times sqrt(f).
    for (radius, returns) in [(1.05, true), (1.2, true), (1.45, true), (1.5001, false), (1.6, false), (4.0, false)] {
        let shell = world(vec![ball(DVec3::ZERO, radius), room(DVec3::splat(-6.0), DVec3::splat(6.0))], DVec3::ZERO, 1.0);
        let sqrt_f = (1.0f64 - 1.0 / radius).sqrt();
        let escape = 1.5 * 3f64.sqrt() * sqrt_f / radius;
        let steepest = if returns { 0.95 * sqrt_f * (1.0 - escape * escape).sqrt() / escape } else { 0.25 };
        for tolerance in [0.1, 1e-2, 1e-3] {
            let tracers: [&dyn Integrator; 3] = [&exact(tolerance), &adaptive(tolerance), &Rk4::new(0.1, 10_000)];
            for tracer in tracers {
                let mut dice = Dice(6);
                for _ in 0..2000 {
                    let n = dice.direction();
                    let across = n.cross(dice.direction()).normalize();
                    // As far off the surface as rays begin; steeper than the angle at which it is left by the rounding of that.
                    let slope = dice.within(0.005, steepest);
                    let ray = Ray::new(n * (radius + 2e-6), (across + n * slope).normalize());
                    let hit = surface(tracer, &shell, &ray).expect("the room is closed, and so is the ball");
                    assert_eq!(hit.geometry == 0, returns, "radius {radius}, tolerance {tolerance}, slope {slope}: {hit:?}");
                    if returns {
                        let normal = shell.surface(&hit).normal;
                        assert!(hit.direction.dot(normal) < 0.0, "radius {radius}, slope {slope}: from inside, {hit:?}");
                    }
                }
            }
        }
    }
}
