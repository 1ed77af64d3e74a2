//! How long light takes along a ray, against quadratures with 30 digits in the radius and against Hamilton's equation of time.

#![allow(clippy::excessive_precision)] // digits as computed

mod common;

use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spacetime::{Ball as Reach, Class, Place, Side, Spacetime, Spherical};
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::way::{CurvePart, Watch};
use bhs_engine::world::World;
use bhs_integrators::general::{Fate, Surroundings};
use bhs_integrators::{Adaptive, Exact, General, MicroSteps, Rk4, Straight, Tolerance};
use bhs_intersectors::reference::Reference;
use bhs_spacetimes::{Ellis, Hole, Kerr, MajumdarPapapetrou};
use common::{Ball, Dice};
use glam::DVec3;
use std::sync::Arc;

const STEPS: u64 = 1_000_000;
const CENTER: DVec3 = DVec3::new(0.1, -0.2, 0.3);

/// `spacetime` with a sphere of the radius `radius` around `center`.
fn shell(spacetime: Arc<dyn Spacetime>, center: DVec3, radius: f64) -> World {
    let sphere = || vec![Geometry::Analytic(Arc::new(Ball { center, radius }))];
    let build = |g: &[Geometry]| Reference.build(g).expect("the sphere is sound");
    let has_far_side = spacetime.has_far_side();
    let world = World::new(sphere(), build(&sphere()), DVec3::ZERO).in_spacetime(spacetime, Conventions::NATURE);
    if has_far_side { world.with_far_side(sphere(), build(&sphere())) } else { world }
}

fn time(builder: &dyn IntegratorBuilder, world: &World, ray: &Ray) -> Option<f64> {
    builder.build(world.spacetime()).expect("it follows these").travel_time(world, ray)
}

fn close(name: &str, found: Option<f64>, right: f64, tolerance: f64) {
    let found = found.expect(name);
    assert!((found / right - 1.0).abs() < tolerance, "{name}: {found} is {right}");
}

const PRECISE: Tolerance = Tolerance::Absolute(1e-9);

#[test]
fn light_past_a_round_hole_is_late_as_by_quadrature() {
    // From the areal radius 6 at the chart angle acos(-0.8) to the radius past the hole and out to 10: the integral of dr / (f sqrt(1 - b^2 f/r^2))
    // of both legs, f = 1 - rs/r + q^2/r^2, the root at the turning point taken out (mpmath, 30 digits).
    let (x, d) = (CENTER + DVec3::X * 6.0, DVec3::new(-0.8, 0.36, 0.48));
    for (charge_squared, right) in [(0.0, 20.393231221462948914), (0.16, 19.831359575625387949), (0.25, 19.546499226736775737)] {
        let hole = Spherical { center: CENTER, rs: 1.0, charge_squared };
        let world = shell(Arc::new(hole), CENTER, 10.0);
        let ray = Ray::new(x, d);
        close("adaptive", time(&Adaptive::new(PRECISE, STEPS), &world, &ray), right, 1e-11);
        close("general", time(&General::new(PRECISE, STEPS), &world, &ray), right, 1e-10);
        close("rk4", time(&Rk4::new(0.01, STEPS), &world, &ray), right, 1e-8);
        if charge_squared == 0.0 {
            close("exact", time(&Exact::new(PRECISE, STEPS), &world, &ray), right, 1e-13);
            // By segments, and to where one of them meets the sphere.
            close("micro-steps", time(&MicroSteps::new(0.01, STEPS), &world, &ray), right, 1e-4);
            close("fewer micro-steps", time(&MicroSteps::new(0.1, STEPS), &world, &ray), right, 1e-2);
        }
        if charge_squared == 0.25 {
            // The same hole in the isotropic chart, whose radius is less by the mass.
            let hole = MajumdarPapapetrou::new(&[Hole { center: CENTER, mass: 0.5 }]);
            let world = shell(Arc::new(hole), CENTER, 9.5);
            // Angles of the static observer: local = (d_r / sqrt f, d_across).
            let root = 1.0 - 0.5 / 6.0;
            let d = DVec3::new(-0.8 / root, 0.36, 0.48).normalize();
            let ray = Ray::new(CENTER + DVec3::X * 5.5, d);
            close("index", time(&Adaptive::new(PRECISE, STEPS), &world, &ray), right, 1e-10);
            close("index, general", time(&General::new(PRECISE, STEPS), &world, &ray), right, 1e-10);
        }
    }
}

#[test]
fn light_around_a_spinning_hole_takes_as_long_as_by_quadrature() {
    // In the equator, from x = 9 along d to |x| = 12 beyond the hole, mass 1: the integral of dt/dr of both legs for the light that comes along the ray,
    // its L from the textbook's metric (mpmath, 30 digits; L of the physical light on the right). The third passes r = 1.26 in the ergosphere.
    for (spin, charge_squared, d, right) in [
        (0.9, 0.0, DVec3::new(-0.6, 0.8, 0.0), 27.4013065502110142),
        (0.9, 0.0, DVec3::new(-0.6, -0.8, 0.0), 22.489172779464202206),
        (0.998, 0.0, DVec3::new(-0.96, -0.28, 0.0), 68.3146488732674312),
        (0.8, 0.09, DVec3::new(-0.6, 0.8, 0.0), 26.703868369636042239),
        (0.8, 0.09, DVec3::new(-0.6, -0.8, 0.0), 22.561175192262304587),
    ] {
        let round = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared };
        // Looked at from behind, the spin is the other way round.
        let turned = |d: DVec3| DVec3::new(d.x, -d.y, d.z);
        for (spin, d) in [(spin, d), (-spin, turned(d))] {
            let world = shell(Arc::new(Kerr::new(round, DVec3::Z, spin)), DVec3::ZERO, 12.0);
            let name = format!("a = {spin}, {d}");
            close(&name, time(&General::new(PRECISE, STEPS), &world, &Ray::new(DVec3::X * 9.0, d)), right, 1e-9);
            close(&name, time(&Adaptive::new(PRECISE, STEPS), &world, &Ray::new(DVec3::X * 9.0, d)), right, 1e-9);
        }
    }
}

#[test]
fn light_that_goes_back_needs_a_spin_reversed() {
    let kerr = |spin| Arc::new(Kerr::new(Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.1 }, DVec3::Z, spin));
    let mut dice = Dice(3);
    let (mut different, mut compared) = (0, 0);
    while compared < 4 {
        let (x, d) = (dice.direction() * 7.0, dice.direction());
        let world = shell(kerr(0.7), DVec3::ZERO, 11.0);
        let general = General::new(PRECISE, STEPS).build(world.spacetime()).expect("it follows all");
        let there = Ray::new(x, d);
        let (Arrival::Surface(hit), Some(time)) = (general.trace(&world, &there).arrival, general.travel_time(&world, &there))
        else {
            continue;
        };
        // Back from there, past a sphere through x that stops it.
        let back = Ray::new(hit.point * (1.0 - 1e-12), -hit.direction);
        let way = |spin: f64| {
            let world = shell(kerr(spin), x * 1.5, 3.5);
            General::new(PRECISE, STEPS).build(world.spacetime()).expect("it follows all").way(&world, &back)
        };
        let (end, points) = way(-0.7);
        let Arrival::Surface(met) = end.arrival else { continue };
        if (met.point - x).length() > 1e-3 {
            // It met the sphere elsewhere first.
            continue;
        }
        let last = points.last().and_then(|p| p.time).expect("it has one");
        assert!((met.point - x).length() < 1e-7 && (last / time - 1.0).abs() < 1e-8, "{x} {d}: {last} is {time}");
        let same = way(0.7).1.last().and_then(|p| p.time);
        different += u32::from(same.is_none_or(|same| (same / time - 1.0).abs() > 1e-4));
        compared += 1;
    }
    assert!(different >= 3, "{different}");
}

#[test]
fn light_through_a_wormhole_takes_as_long_as_it_is_far() {
    // Ellis: N = 1, so the integral of dl / sqrt(1 - h^2/r^2) from rho = 3 on one side to rho = 4 on the other (mpmath).
    let (x, d) = (CENTER + DVec3::Y * 3.0, DVec3::new(0.28, -0.96, 0.0));
    for side in [Side::Near, Side::Far] {
        let world = shell(Arc::new(Ellis { center: CENTER, throat: 1.0 }), CENTER, 4.0);
        let ray = Ray { side, ..Ray::new(x, d) };
        for (name, builder, tolerance) in [
            ("adaptive", &Adaptive::new(PRECISE, STEPS) as &dyn IntegratorBuilder, 1e-10),
            ("rk4", &Rk4::new(0.01, STEPS), 1e-8),
            ("general", &General::new(PRECISE, STEPS), 1e-10),
        ] {
            let integrator = builder.build(world.spacetime()).expect("it follows these");
            let Arrival::Surface(hit) = integrator.trace(&world, &ray).arrival else { panic!("{name}") };
            assert_eq!(world.side_of(hit.geometry), side.other());
            close(name, integrator.travel_time(&world, &ray), 8.5033042060780202481, tolerance);
        }
    }
}

#[test]
fn in_flat_space_time_is_distance() {
    let world = shell(Arc::new(bhs_core::spacetime::Minkowski::default()), CENTER, 5.0);
    let mut dice = Dice(5);
    for _ in 0..20 {
        let ray = Ray::new(CENTER + dice.point(2.0), dice.direction());
        for builder in [&Straight as &dyn IntegratorBuilder, &Adaptive::new(PRECISE, STEPS), &MicroSteps::new(0.1, STEPS)] {
            let integrator = builder.build(world.spacetime()).expect("it follows all");
            let Arrival::Surface(hit) = integrator.trace(&world, &ray).arrival else { panic!("{ray:?}") };
            close("flat", integrator.travel_time(&world, &ray), (hit.point - ray.origin).length(), 1e-14);
        }
    }
    let outwards = Ray::new(CENTER + DVec3::X * 6.0, DVec3::X);
    assert_eq!(time(&Straight, &world, &outwards), None, "light from the sky takes for ever");
}

#[test]
fn light_that_ends_nowhere_has_no_time() {
    let world = shell(Arc::new(Spherical { center: CENTER, rs: 1.0, charge_squared: 0.0 }), CENTER, 2.0);
    for builder in
        [&Adaptive::new(PRECISE, STEPS) as &dyn IntegratorBuilder, &Exact::new(PRECISE, STEPS), &MicroSteps::new(0.1, STEPS)]
    {
        let integrator = builder.build(world.spacetime()).expect("it follows these");
        for (x, d, wanted) in [(3.0, 1.0, "sky"), (1.5, -1.0, "hole")] {
            let ray = Ray::new(CENTER + DVec3::X * x, DVec3::X * d);
            let found = integrator.trace(&world, &ray).arrival;
            assert!(matches!((wanted, found), ("sky", Arrival::Sky(..)) | ("hole", Arrival::Captured)), "{found:?}");
            assert_eq!(integrator.travel_time(&world, &ray), None, "{wanted}");
        }
    }
}

/// What Hamilton's equation for t has at the end of every step, against the quadrature up to there.
struct Clock {
    world: World,
    times: Vec<(f64, f64)>,
}

impl Watch for Clock {
    fn part(&mut self, part: &CurvePart<'_>) {
        // Another rule than that of the engine: Simpson's, with many points.
        let [a, b] = part.ends;
        let n = 400;
        let rate = |k: u32| {
            let [x, d] = (part.curve)(a + (b - a) * f64::from(k) / f64::from(n));
            self.world.spacetime().at(Place { x, side: part.side }).expect("something can stand there").travel_time(-d)
        };
        let sum: f64 = (0..=n).map(|k| rate(k) * if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) }).sum();
        let before = self.times.last().map_or(0.0, |t| t.1);
        self.times.push((b, before + sum * (b - a) / (3.0 * f64::from(n))));
    }
}

#[test]
fn times_of_any_direction_are_those_of_hamiltons_equation() {
    let spacetime: Arc<dyn Spacetime> =
        Arc::new(Kerr::new(Spherical { center: CENTER, rs: 2.0, charge_squared: 0.1 }, DVec3::new(0.48, 0.6, 0.64), 0.8));
    assert!(!matches!(spacetime.class(), Class::Flat | Class::Spherical(_)));
    let mut dice = Dice(9);
    let mut compared = 0;
    while compared < 6 {
        let world = shell(spacetime.clone(), CENTER, 12.0);
        let ray = Ray::new(CENTER + dice.direction() * 8.0, dice.direction());
        let general = General::new(PRECISE, STEPS);
        let (RayEnd { arrival, .. }, points) = general.way(&world, &ray);
        if !matches!(arrival, Arrival::Surface(_)) {
            continue;
        }
        let mut clock = Clock { world: shell(spacetime.clone(), CENTER, 12.0), times: Vec::new() };
        general.watched(&world, &ray, &mut clock);
        let end = clock.times.last().expect("it goes somewhere").1;
        let found = general.travel_time(&world, &ray).expect("it arrives");
        assert!((found / end - 1.0).abs() < 1e-9, "{found} {end}");
        assert_eq!(points.last().and_then(|p| p.time).map(|t| (t / found - 1.0).abs() < 1e-13), Some(true));
        assert_eq!(points[0].time, Some(0.0));
        assert!(points.windows(2).all(|pair| pair[0].time <= pair[1].time && pair[0].swept <= pair[1].swept));
        // The same ray by itself, with its time among its unknowns.
        let around = Surroundings::new(&*spacetime, None, true, Reach { center: CENTER, radius: 12.0 });
        let mut path = around.start(ray.origin, ray.direction, Side::Near, 1e-12).expect("a place");
        let mut before = (path.light.t, DVec3::from(path.light.x));
        while path.advance().fate == Fate::Underway && (DVec3::from(path.light.x) - CENTER).length() < 12.0 {
            before = (path.light.t, path.light.x.into());
        }
        // On from its last point inside the sphere.
        let ball = shell(spacetime.clone(), CENTER, 12.0);
        let mut here = around.start(ray.origin, ray.direction, Side::Near, 1e-12).expect("a place");
        while here.light.t < before.0 {
            here.advance();
        }
        let rest = Ray::new(before.1, DVec3::from(around.hamilton.slope(here.light).x).normalize());
        let whole = before.0 + General::new(PRECISE, STEPS).travel_time(&ball, &rest).expect("it arrives");
        assert!((found / whole - 1.0).abs() < 1e-9, "{found} {whole}");
        compared += 1;
    }
}
