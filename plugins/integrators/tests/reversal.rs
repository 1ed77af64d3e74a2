//! Deflection by whole rays, the photon sphere, and the way back.

mod common;

use bhs_core::ray::{Arrival, Ray, SurfaceHit};
use bhs_engine::integrator::Integrator;
use bhs_integrators::Tolerance;
use bhs_integrators::{Adaptive, Exact, Rk4};
use common::{Dice, ball, room, world};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

#[test]
fn rays_through_a_world_are_deflected_by_the_elliptic_integrals() {
    // Total deflection by 30-digit elliptic integrals, b in units of rs. A ray from its pericentre sweeps half of pi + delta, whatever the
    // world around it: with nothing in it, and with a surface far out of the way.
    let table = [(2.7, 2.919396339609558), (3.0, 1.719388310230169), (5.0, 0.590395787605827), (100.0, 0.020299966239543)];
    let far = world(vec![ball(DVec3::new(0.0, 0.0, 500.0), 1.0)], DVec3::ZERO, 1.0);
    let empty = world(vec![], DVec3::ZERO, 1.0);
    let tracers: [(&dyn Integrator, f64, &str); 4] = [
        (&Exact::new(Tolerance::DEFAULT, 10_000), 1e-12, "exact"),
        // Where there is no surface, there is no distance to keep: its steps then have a relative error of 1e-2 at most, and much less in fact.
        (&Adaptive::new(Tolerance::Absolute(1e-6), 10_000), 1e-5, "adaptive"),
        (&Adaptive::new(Tolerance::DEFAULT, 10_000), 1e-3, "adaptive by default"),
        (&Rk4::new(0.01, 1_000_000), 1e-6, "rk4"),
    ];
    for (b, delta) in table {
        // The greatest root of r^3 = b^2 (r - 1), by Newton's method from above.
        let mut r: f64 = b;
        for _ in 0..60 {
            r -= (r * r * r - b * b * (r - 1.0)) / (3.0 * r * r - b * b);
        }
        for (tracer, tolerance, name) in &tracers {
            for (world, what) in [(&empty, "empty"), (&far, "far")] {
                let ray = Ray::new(DVec3::X * r, DVec3::Y);
                let Arrival::Sky(d, _) = tracer.trace(world, &ray).arrival else { panic!("{name}, b {b}") };
                let off = (d.y.atan2(d.x).rem_euclid(TAU) - 0.5 * (PI + delta)).abs();
                eprintln!("b {b}, {what} world, {name}: {off:.1e}");
                assert!(off < *tolerance, "b {b}, {what} world, {name}: {off:.1e}");
            }
        }
    }
}

#[test]
fn rays_stay_on_the_photon_sphere_for_three_turns() {
    // What is missing at the start grows by e per radian: rounding of 1.5 rs, from 1e-16 to 1.5e-8 after three turns, and the error that a
    // tolerance of 1e-7 leaves room for, a quarter of it over the distance of the farthest surface: 3e-10 at most, and in fact (steps of high order) below 1e-12.
    let shell = world(vec![ball(DVec3::ZERO, 50.0)], DVec3::ZERO, 1.0);
    let tracers: [(&dyn Integrator, f64, &str); 2] = [
        (&Exact::new(Tolerance::Absolute(1e-3), 10_000), 1e-15, "exact"),
        // It may stay there for ever: hence few steps.
        (&Adaptive::new(Tolerance::Absolute(1e-7), 300), 1e-12, "adaptive"),
    ];
    for (tracer, start, name) in tracers {
        for k in 0..4 {
            let e1 = DVec3::new(f64::from(k).cos(), f64::from(k).sin(), 0.3 * f64::from(k)).normalize();
            let e2 = e1.any_orthonormal_vector();
            let (_, points) = tracer.polyline(&shell, &Ray::new(e1 * 1.5, e2));
            let (mut phi, mut last, mut worst) = (0.0f64, e1, 0.0f64);
            for p in points {
                phi += p.angle_between(last);
                last = p;
                if phi > 3.0 * TAU {
                    break;
                }
                let off = (p.length() / 1.5 - 1.0).abs();
                worst = worst.max(off / phi.exp());
                assert!(off < start * phi.exp(), "{name}, ray {k}: {off:.1e} after {phi:.2} rad");
            }
            assert!(phi > 3.0 * TAU, "{name}, ray {k} ends after {phi:.2} rad");
            eprintln!("{name}, ray {k}: off by at most {worst:.1e} e^phi");
        }
    }
}

#[test]
fn light_goes_back_the_way_it_came() {
    // From a point within a closed room both ways to its walls; then from one end back through the point to the other.
    let hole = DVec3::new(0.1, -0.05, 0.2);
    let closed = world(vec![room(DVec3::splat(-1.0), DVec3::splat(1.0))], hole, 0.12);
    let diameter = 12f64.sqrt();
    let tracers: [(&dyn Integrator, f64, &str); 3] = [
        (&Exact::new(Tolerance::Absolute(1e-4), 10_000), 1e-9, "exact"),
        (&Adaptive::new(Tolerance::Absolute(1e-9), 100_000), 1e-9, "adaptive"),
        (&Rk4::new(0.005, 1_000_000), 1e-9, "rk4"),
    ];
    let mut dice = Dice(8);
    let (mut count, mut worst) = (0, [0.0f64; 3]);
    while count < 400 {
        let (origin, direction) = (dice.point(0.95), dice.direction());
        let from_hole = origin - hole;
        // Away from critical rays, which magnify rounding without bound: those that pass the hole at more than 1.2 b_crit, as in flat space.
        if from_hole.length() < 0.4 || (from_hole.cross(direction).length() < 1.2 * 1.5 * 3f64.sqrt() * 0.12) {
            continue;
        }
        count += 1;
        for (i, (tracer, tolerance, name)) in tracers.iter().enumerate() {
            let end = |origin: DVec3, direction: DVec3| match tracer.trace(&closed, &Ray::new(origin, direction)).arrival {
                Arrival::Surface(hit) => hit,
                other => panic!("{name}: {other:?} from {origin} along {direction}"),
            };
            let (there, back) = (end(origin, direction), end(origin, -direction));
            // A step off the wall along the ray, over which it bends by less than a thousandth of what is allowed.
            let home = end(there.point - there.direction * 1e-11, -there.direction);
            // A hit just beside its facet, within the rounding of single precision, is moved onto it.
            let on_edge = |hit: &SurfaceHit| {
                let b = hit.barycentric;
                b.min_element().min(1.0 - b.x - b.y) < 1e-5
            };
            if [there, back, home].iter().any(on_edge) {
                continue;
            }
            let off = (home.point - back.point).cross(back.direction).length();
            assert!(off < tolerance * diameter, "{name}: {off:.1e} from {origin} along {direction}");
            worst[i] = worst[i].max(off / diameter / tolerance);
        }
    }
    eprintln!("farthest from home, over the diameter and the tolerance: {worst:.5?}");
}
