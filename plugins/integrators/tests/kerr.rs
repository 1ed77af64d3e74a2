//! Rays around holes that spin, against quadratures, closed forms and first integrals, none of which share their code.

mod common;
#[path = "common/deflections.rs"]
mod deflections;

use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::{Conventions, Observer};
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::real::Vector;
use bhs_core::spacetime::{Place, Spacetime, Spherical};
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::world::World;
use bhs_integrators::kerr::course::KerrSetup;
use bhs_integrators::kerr::orbit::Hole;
use bhs_integrators::tracing::arc::Arc as _;
use bhs_integrators::tracing::driver::Course;
use bhs_integrators::{Adaptive, Rk4, Tolerance};
use bhs_intersectors::reference::Reference;
use bhs_spacetimes::Kerr;
use common::{Dice, ball, mesh, on_all_processors, room};
use deflections::EQUATORIAL;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::AddAssign;
use std::sync::Arc;

const STEPS: u64 = 10_000_000;

/// A hole of mass 1 that spins about +z.
fn kerr(spin: f64) -> Kerr {
    Kerr::new(Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 }, DVec3::Z, spin)
}

fn world(spin: f64, geometries: Vec<Geometry>) -> World {
    let intersector = Reference.build(&geometries).expect("the meshes are sound");
    World::new(geometries, intersector, DVec3::ZERO).in_spacetime(Arc::new(kerr(spin)), Conventions::NATURE)
}

fn adaptive(spin: f64, tolerance: f64) -> Box<dyn Integrator> {
    Adaptive::new(Tolerance::Absolute(tolerance), STEPS).build(&kerr(spin)).expect("it follows all")
}

/// A square at right angles to the unit vector `normal` in the point `normal * at`, of half the side `half`.
fn wall(normal: DVec3, at: f64, half: f64) -> Geometry {
    let (u, v) = normal.any_orthonormal_pair();
    let corner = |s: f64, t: f64| normal * at + u * (s * half) + v * (t * half);
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    mesh(&[[a, b, c], [a, c, d]])
}

/// Where a ray followed backward comes from.
fn sky(spin: f64, x: DVec3, d: DVec3) -> DVec3 {
    match adaptive(spin, 1e-13).trace(&world(spin, Vec::new()), &Ray::new(x, d)).arrival {
        Arrival::Sky(direction, _) => direction,
        other => panic!("{other:?}"),
    }
}

/// Where it meets `wall`.
fn met(spin: f64, wall: Geometry, x: DVec3, d: DVec3) -> Option<DVec3> {
    match adaptive(spin, 1e-7).trace(&world(spin, vec![wall]), &Ray::new(x, d)).arrival {
        Arrival::Surface(hit) => Some(hit.point),
        _ => None,
    }
}

/// The momentum of light that moves along `d` into the future.
fn momentum(spin: f64, x: DVec3, d: DVec3) -> DVec3 {
    kerr(spin).at(Place::near(x)).expect("a place").momentum(d)
}

/// The zero of `f`, which changes sign between `low` and `high`.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let rises = f(low) < 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == rises {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn light_in_the_equator_is_deflected_as_by_quadrature() {
    for (a, b, right) in EQUATORIAL {
        let x = DVec3::X * (3.0 * f64::abs(b)).max(12.0);
        let towards = |psi: f64| DVec3::new(-psi.cos(), psi.sin(), 0.0);
        let psi = root(|psi| x.x * momentum(a, x, towards(psi)).y - b, -1.5, 1.5);
        // Light that is followed backward around the opposite spin goes where it goes forward.
        let out = sky(-a, x, towards(psi));
        let from = -sky(a, x, -towards(psi));
        let turned = (out.y.atan2(out.x) - from.y.atan2(from.x)) * b.signum();
        let off = (turned - right + PI).rem_euclid(TAU) - PI;
        assert!(off.abs() < 1e-9, "a = {a}, b = {b}: {off:e}");
    }
}

#[test]
fn single_rays_go_where_hamiltons_equations_say() {
    let (a, x) = (0.9, DVec3::X * 12.0);
    let eye = Observer::at_rest(&kerr(a).at(Place::near(x)).unwrap());
    for (local, y, z, leaves, l) in [
        (
            DVec3::new(-1.0, -0.45, 0.2),
            -0.554651707083637,
            0.900612072638014,
            DVec3::new(-0.781836524689932, 0.591577434128567, -0.196895373461721),
            5.130726638629703,
        ),
        (
            DVec3::new(-1.0, -0.1, 0.6),
            0.740415174196968,
            3.38187527252831,
            DVec3::new(-0.871541781037726, 0.210495657758922, -0.442839137803139),
            0.943423103976243,
        ),
        (
            DVec3::new(-1.0, 0.62, 0.1),
            -5.58176101421623,
            -1.27569237989897,
            DVec3::new(-0.168938525753629, -0.973739439128758, -0.152614806625707),
            -7.088375348045848,
        ),
    ] {
        let d = eye.chart_direction(local.normalize());
        let found = met(a, wall(-DVec3::X, 8.0, 40.0), x, d).expect("it passes the hole");
        assert!((found - DVec3::new(-8.0, y, z)).length() < 1e-9, "{found}");
        let direction = sky(a, x, d);
        assert!((direction - leaves).length() < 1e-9, "{:e}", (direction - leaves).length());
        // The physical light moves the other way.
        let p = momentum(a, x, -d);
        assert!((x.x * p.y - l).abs() < 1e-12);
    }
}

#[test]
fn time_runs_backward() {
    let (a, x) = (0.9, DVec3::X * 12.0);
    let eye = Observer::at_rest(&kerr(a).at(Place::near(x)).unwrap());
    let d = eye.chart_direction(DVec3::new(-1.0, -0.5, 0.0).normalize());
    let found = met(a, wall(-DVec3::X, 8.0, 40.0), x, d).expect("seen, it passes the hole");
    assert!((found.y - -1.385403296393).abs() < 1e-9, "{found}");
    assert_eq!(met(-a, wall(-DVec3::X, 8.0, 40.0), x, d), None, "sent, it falls in");
}

#[test]
fn rings_on_the_axis_have_their_radius() {
    for (a, ring) in [(0.5, 0.612136976283935_f64), (0.9, 0.606145445986476), (0.998, 0.604139395906933)] {
        let x = DVec3::Z * 10.0;
        let eye = Observer::at_rest(&kerr(a).at(Place::near(x)).unwrap());
        for azimuth in [0.3_f64, 2.0, 5.0] {
            let local = DVec3::new(ring.sin() * azimuth.cos(), ring.sin() * azimuth.sin(), -ring.cos());
            let found = met(a, wall(-DVec3::Z, 10.0, 40.0), x, eye.chart_direction(local)).expect("it passes the hole");
            assert!(found.truncate().length() < 2e-8, "{a}: {found}");
        }
    }
}

/// The direction in which an eye at (r, theta) sees the edge of the shadow by light that circles at the radius `s`, for both signs of its slope; `zamo`:
/// to one who is dragged along. Local components along growing r, theta and phi; `None` where there is none.
fn edge(a: f64, (r, theta): (f64, f64), zamo: bool, s: f64, up: f64) -> Option<DVec3> {
    let l = -(s.powi(3) - 3.0 * s * s + a * a * s + a * a) / (a * (s - 1.0));
    let q = s.powi(3) * (4.0 * a * a - s * (s - 3.0).powi(2)) / (a * a * (s - 1.0).powi(2));
    let (sin, cos) = theta.sin_cos();
    let b = q + a * a * cos * cos - l * l * (cos / sin).powi(2);
    if b < 0.0 {
        return None;
    }
    let (sigma, delta) = (r * r + a * a * cos * cos, r * r - 2.0 * r + a * a);
    let radial = (r * r + a * a - a * l).powi(2) - delta * (q + (l - a).powi(2));
    let (g_tphi, g_phiphi) =
        (-2.0 * a * r * sin * sin / sigma, sin * sin * (r * r + a * a + 2.0 * a * a * r * sin * sin / sigma));
    let (energy, phi) = if zamo {
        let (omega, alpha) = (-g_tphi / g_phiphi, (sigma * delta / ((r * r + a * a).powi(2) - a * a * delta * sin * sin)).sqrt());
        let energy = (1.0 - omega * l) / alpha;
        (energy, l / (g_phiphi.sqrt() * energy))
    } else {
        let lapse = (1.0 - 2.0 * r / sigma).sqrt();
        (1.0 / lapse, (l * lapse - g_tphi / lapse) * (sigma - 2.0 * r).sqrt() / (sin * (delta * sigma).sqrt()))
    };
    // The light moves outwards; the eye looks against it.
    Some(-DVec3::new(radial.max(0.0).sqrt() / ((sigma * delta).sqrt() * energy), up * (b / sigma).sqrt() / energy, phi))
}

#[test]
fn shadows_have_their_outlines() {
    // A tenth of a pixel of a picture of 320 pixels over 60 degrees.
    let aside = 0.1 * 60f64.to_radians() / 320.0;
    let (mut seen, mut deep) = (0, 0);
    for a in [0.5, 0.9, 0.998] {
        let orbit = |sense: f64| 2.0 * (1.0 + (2.0 / 3.0 * (sense * a).acos()).cos());
        let (innermost, outermost) = (orbit(-1.0), orbit(1.0));
        for theta in [FRAC_PI_2, 60f64.to_radians(), 17f64.to_radians()] {
            for (r, zamo) in [(10.0, false), (10.0, true), (1.7, true)] {
                let (sin, cos) = theta.sin_cos();
                let (across, place) = (f64::hypot(r, a), f64::hypot(r, a) * sin);
                let x = DVec3::new(place, 0.0, r * cos);
                let hole = kerr(a);
                if r <= hole.horizon() {
                    continue;
                }
                let normal = hole.normal(Place::near(x)).unwrap();
                let eye = if zamo { Observer::dragged(&normal) } else { Observer::at_rest(&hole.at(Place::near(x)).unwrap()) };
                // Growing r, theta, phi.
                let e_r = DVec3::new(r * sin, 0.0, across * cos).normalize();
                let axes = [e_r, DVec3::new(across * cos, 0.0, -r * sin).normalize(), DVec3::Y];
                let integrator = adaptive(a, 1e-9);
                let world = world(a, Vec::new());
                let captured = |local: DVec3| {
                    if !eye.has_positive_energy(local) {
                        return true;
                    }
                    matches!(integrator.trace(&world, &Ray::new(x, eye.chart_direction(local))).arrival, Arrival::Captured)
                };
                for i in 1..40 {
                    let s = innermost + (outermost - innermost) * f64::from(i) / 40.0;
                    // Where the eye is within the photon orbits, edges lie elsewhere.
                    if r < 1.05 * s {
                        continue;
                    }
                    for up in [1.0, -1.0] {
                        let Some(v) = edge(a, (r, theta), zamo, s, up) else { continue };
                        let look = (axes[0] * v.x + axes[1] * v.y + axes[2] * v.z).normalize();
                        assert!((v.length() - 1.0).abs() < 1e-12, "light has no mass");
                        // Outwards across the outline, from a point well within it.
                        let middle = (-e_r - DVec3::Y * 0.15 * if r > 5.0 { 0.0 } else { 1.0 }).normalize();
                        let outwards = (look - middle * look.dot(middle)).normalize();
                        assert!(captured((look - outwards * aside).normalize()), "{a} {theta} {r} {zamo} {s} {up}");
                        assert!(!captured((look + outwards * aside).normalize()), "{a} {theta} {r} {zamo} {s} {up}");
                        seen += 1;
                        deep += u32::from(r < 2.0);
                    }
                }
            }
        }
    }
    assert!(seen > 500 && deep > 10, "{seen} {deep}");
}

#[test]
fn fixed_steps_converge_with_order_four() {
    let (a, x) = (0.9, DVec3::new(9.0, -6.0, 4.0));
    let d = DVec3::new(-0.8, 0.1, -0.45).normalize();
    let world = world(a, Vec::new());
    let right = sky(a, x, d);
    let error = |step: f64| match Rk4::new(step, STEPS).build(&kerr(a)).unwrap().trace(&world, &Ray::new(x, d)).arrival {
        Arrival::Sky(direction, _) => (direction - right).length(),
        other => panic!("{other:?}"),
    };
    let [coarse, middle, fine] = [0.08, 0.04, 0.02].map(error);
    assert!(
        fine < 1e-6 && (10.0..24.0).contains(&(coarse / middle)) && (10.0..24.0).contains(&(middle / fine)),
        "{coarse:e} {middle:e} {fine:e}"
    );
}

#[test]
fn what_is_conserved_stays() {
    let mut dice = Dice(23);
    let (mut orbits, mut worst) = (0, 0.0_f64);
    for spin in [0.5, 0.9, 0.998, -0.7] {
        let hole = kerr(spin);
        let setup = KerrSetup::around(&hole, true, 40.0, 0.0);
        let axes = Hole::new(&hole, true);
        for _ in 0..2500 {
            let r = dice.within(2.2, 20.0);
            let x = dice.direction() * r;
            let d = dice.direction();
            let before = axes.light::<f64>(x.into(), d.into());
            let mut course = setup.by_series::<f64>(x.into(), d.into(), 1e-10);
            if course.begin().0 || course.begin().1 {
                continue;
            }
            for step in 0.. {
                assert!(step < 1000, "{x} {d} winds for ever");
                let next = course.advance(true);
                let piece = course.piece();
                if piece.end() > piece.start() {
                    let (point, tangent) = piece.point_and_tangent(piece.end());
                    // Next to the horizon tangents tell little of the constants: they lose as F = D/R^2 does, twice.
                    let here = hole.oblate::<f64>(point);
                    let falling = 1.0 - here.m / here.square;
                    if falling < 0.1 {
                        break;
                    }
                    let after = axes.light::<f64>(point, Vector::from(DVec3::from(tangent).normalize()));
                    let scale = before.orbit.scale;
                    let off = (after.orbit.l * after.orbit.scale - before.orbit.l * scale).abs() / scale;
                    let off = off.max((after.orbit.k * after.orbit.scale.powi(2) / (scale * scale) - before.orbit.k).abs());
                    let off = off * falling * falling;
                    worst = worst.max(off);
                    // A derivative of a series of sixteen terms is right to some ten times less than the series.
                    assert!(off < 1e-8, "{spin}: {x} {d}: {off:e}");
                }
                if next.escapes || next.falls || next.lost {
                    break;
                }
            }
            orbits += 1;
        }
    }
    assert!(orbits > 9_000, "{orbits} {worst:e}");
}

/// Rays a spin; `BHS_RAYS` asks for more.
fn count(usual: u64) -> u64 {
    std::env::var("BHS_RAYS").ok().and_then(|n| n.parse().ok()).map_or(usual, |n: u64| n.max(usual))
}

#[derive(Default)]
struct Ends {
    met: u64,
    captured: u64,
}

impl AddAssign for Ends {
    fn add_assign(&mut self, o: Self) {
        self.met += o.met;
        self.captured += o.captured;
    }
}

/// Rays in a closed room with a hole, half of them towards it, some from the ergosphere: none gets out, none goes on for ever, nothing is no number.
#[test]
fn rays_leak_nowhere() {
    const RAYS_AT_ONCE: u64 = 1000;
    for spin in [0.5, 0.9, 0.998] {
        let hole = kerr(spin);
        let things = [
            room(DVec3::splat(-15.0), DVec3::splat(15.0)),
            ball(DVec3::new(6.0, 2.0, -1.0), 2.0),
            ball(DVec3::new(-4.0, -5.0, 3.0), 1.5),
            mesh(&[[DVec3::new(-6.0, 4.0, -3.0), DVec3::new(3.0, 6.0, 2.0), DVec3::new(2.0, 3.0, 7.0)]]),
        ];
        let world = world(spin, things.to_vec());
        let integrator = adaptive(spin, 1e-2);
        let sum = on_all_processors(count(20_000).div_ceil(RAYS_AT_ONCE), |number| {
            let mut dice = Dice(500 + number);
            let rays: Vec<Ray> = (0..RAYS_AT_ONCE)
                .map(|i| {
                    loop {
                        // Every tenth from where everything turns with the hole.
                        let x = if i % 10 == 0 { dice.point(2.0) } else { dice.point(14.9) };
                        let place = Place::near(x);
                        let far_from_things =
                            (x - DVec3::new(6.0, 2.0, -1.0)).length() > 2.0 && (x - DVec3::new(-4.0, -5.0, 3.0)).length() > 1.5;
                        let (Some(normal), true) = (hole.normal(place), far_from_things) else { continue };
                        let eye = Observer::dragged(&normal);
                        let local =
                            if i % 2 == 0 { dice.direction() } else { (-x.normalize() + 0.5 * dice.point(1.0)).normalize() };
                        if eye.has_positive_energy(local) {
                            return Ray::new(x, eye.chart_direction(local));
                        }
                    }
                })
                .collect();
            let mut found = vec![RayEnd::NONE; rays.len()];
            integrator.trace_all(&world, &rays, &mut found);
            let mut ends = Ends::default();
            for (ray, end) in rays.iter().zip(&found) {
                assert!(end.swept.is_finite(), "{spin} {ray:?} {end:?}");
                match end.arrival {
                    Arrival::Surface(hit) => {
                        assert!(hit.point.is_finite() && (hit.direction.length() - 1.0).abs() < 1e-9, "{spin} {ray:?} {hit:?}");
                        ends.met += 1;
                    }
                    Arrival::Captured => ends.captured += 1,
                    other => panic!("{spin} {ray:?}: {other:?}"),
                }
            }
            ends
        });
        assert!(sum.met > sum.captured && sum.captured * 10 > sum.met, "{} {}", sum.met, sum.captured);
    }
}
