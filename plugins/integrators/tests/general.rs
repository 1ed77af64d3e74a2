//! Hamilton's equations of any metric against quadratures and series for Kerr's hole (none of which they share anything with).

#![allow(clippy::excessive_precision)] // digits as published

#[path = "common/deflections.rs"]
mod deflections;
#[path = "common/kerr.rs"]
mod kerr;
#[path = "common/lens.rs"]
mod lens;

use bhs_core::spacetime::{Ball, Side, Spacetime, Spherical};
use bhs_integrators::arithmetic::root::root;
use bhs_integrators::general::hamilton::Light;
use bhs_integrators::general::{Fate, Surroundings};
use bhs_integrators::tracing::arc::Arc;
use deflections::EQUATORIAL;
use glam::DVec3;
use kerr::Kerr;
use lens::GaussianLens;
use std::f64::consts::{PI, TAU};

const TOLERANCE: f64 = 1e-12;

fn around(spacetime: &dyn Spacetime, backward: bool, reach: f64) -> Surroundings<'_> {
    Surroundings::new(spacetime, None, backward, Ball { center: DVec3::ZERO, radius: reach })
}

/// Where the ray from `x` along `d` ends, and its state there.
fn end(around: &Surroundings<'_>, x: DVec3, d: DVec3) -> (Fate, Light) {
    let mut path = around.start(x, d, Side::Near, TOLERANCE).expect("a place");
    for _ in 0..10_000 {
        let advance = path.advance();
        if advance.fate != Fate::Underway {
            return (advance.fate, path.light);
        }
    }
    panic!("no end of the ray from {x} along {d}");
}

fn sky(around: &Surroundings<'_>, x: DVec3, d: DVec3) -> DVec3 {
    match end(around, x, d) {
        (Fate::Escaped(direction), _) => direction,
        (other, _) => panic!("{other:?}"),
    }
}

#[test]
fn light_in_the_equator_of_a_spinning_hole_is_deflected_as_by_quadrature() {
    for (a, b, right) in EQUATORIAL {
        let hole = Kerr(a);
        let (forward, backward) = (around(&hole, false, 20.0), around(&hole, true, 20.0));
        let x = DVec3::X * (3.0 * f64::abs(b)).max(12.0);
        // Inwards, at the angle psi from the radius: L = x p_y grows with it.
        let towards = |psi: f64| DVec3::new(-psi.cos(), psi.sin(), 0.0);
        let momentum = |psi: f64| x.x * forward.hamilton.start(x, towards(psi)).expect("a place").p.y;
        let psi = root(|psi| momentum(psi) - b, -1.5, 1.5, true);
        let out = sky(&forward, x, towards(psi));
        let from = -sky(&backward, x, -towards(psi));
        let turned = (out.y.atan2(out.x) - from.y.atan2(from.x)) * b.signum();
        let off = (turned - right + PI).rem_euclid(TAU) - PI;
        // Near the photon orbit errors grow by the derivative of the deflection.
        let within = if b == 3.0 || right > 5.0 { 1e-9 } else { 1e-10 };
        assert!(off.abs() < within, "a = {a}, b = {b}: {off:e}");
    }
}

#[test]
fn light_along_the_axis_of_a_spinning_hole_is_deflected_and_twisted_as_by_elliptic_integrals() {
    for (a, b, deflection, twist) in [
        (0.9, 6.0, 1.605440035879281, 0.3242193674799751),
        (0.9, 10.0, 0.5875759752890947, 0.06008171272449056),
        (0.998, 6.0, 1.582142288385299, 0.3545236320977475),
        (0.5, 6.0, 1.681815883460555, 0.1883604392665153),
    ] {
        let hole = Kerr(a);
        let (forward, backward) = (around(&hole, false, 1e5), around(&hole, true, 1e5));
        // A ray without momentum about the axis and with K = b^2 - a^2, moving inwards at r = 12 and the polar angle theta.
        let start = |theta: f64| {
            let (r, (sin, cos)) = (12.0, theta.sin_cos());
            let across = f64::hypot(r, a);
            let x = DVec3::new(across * sin, 0.0, r * cos);
            let inverse = forward.hamilton.inverse(x);
            let p_theta = (b * b - a * a + a * a * cos * cos).sqrt();
            // p_r from the norm, p_x and p_z from both.
            let (s, d) = (r * r + a * a * cos * cos, across * across - 2.0 * r);
            let p_r = -((-inverse.tt.value * s - p_theta * p_theta) / d).sqrt();
            let (dr, dtheta) = (DVec3::new(r / across * sin, 0.0, cos), DVec3::new(across * cos, 0.0, -r * sin));
            let determinant = dr.x * dtheta.z - dr.z * dtheta.x;
            let p = DVec3::new(p_r * dtheta.z - p_theta * dr.z, 0.0, p_theta * dr.x - p_r * dtheta.x) / determinant;
            (x, inverse.velocity(p))
        };
        let from = |theta: f64| {
            let (x, d) = start(theta);
            end(&backward, x, -d)
        };
        // It comes along the axis: its direction there, which is small, is nearly in the plane where it starts.
        let slant = |theta: f64| match from(theta).0 {
            Fate::Escaped(direction) => direction.x,
            other => panic!("{other:?}"),
        };
        let (mut t0, mut t1) = (0.4, 0.5);
        let (mut s0, mut s1) = (slant(t0), slant(t1));
        while (t1 - t0).abs() > 1e-13 && s0 != s1 {
            (t0, t1) = (t1, t1 - s1 * (t1 - t0) / (s1 - s0));
            (s0, s1) = (s1, slant(t1));
        }
        let (fate, light) = from(t1);
        let Fate::Escaped(direction) = fate else { panic!("{fate:?}") };
        assert!(direction.truncate().length() < 1e-10 && direction.z > 0.0, "{direction}");
        let (x, d) = start(t1);
        let out = sky(&forward, x, d);
        let bent = out.truncate().length().atan2(-out.z);
        assert!((bent - deflection).abs() < 1e-9, "a = {a}, b = {b}: {:e}", bent - deflection);
        let (came, went) = (light.x.y.atan2(light.x.x), (-out.y).atan2(-out.x));
        assert!((went - came - twist).abs() < 1e-9, "a = {a}, b = {b}: {:e}", went - came - twist);
    }
}

#[test]
fn single_rays_around_a_spinning_hole_pass_where_they_should() {
    let round = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 };
    pass_where_they_should(&Kerr(0.9));
    pass_where_they_should(&bhs_spacetimes::Kerr::new(round, DVec3::Z, 0.9));
}

/// Rays around `hole` of mass 1 and spin 0.9 along z.
fn pass_where_they_should(hole: &dyn Spacetime) {
    let back = around(hole, true, 20.0);
    let x = DVec3::X * 12.0;
    let here = hole.at(bhs_core::spacetime::Place::near(x)).unwrap();
    // Local direction; y and z where x = -8; direction in the sky; L/E of the trace.
    for (local, at, out, l) in [
        (
            [-1.0, -0.45, 0.2],
            [-0.554651707083637, 0.900612072638014],
            [-0.781836524689932, 0.591577434128567, -0.196895373461721],
            5.130726638629703,
        ),
        (
            [-1.0, -0.1, 0.6],
            [0.740415174196968, 3.38187527252831],
            [-0.871541781037726, 0.210495657758922, -0.442839137803139],
            0.943423103976243,
        ),
        (
            [-1.0, 0.62, 0.1],
            [-5.58176101421623, -1.27569237989897],
            [-0.168938525753629, -0.973739439128758, -0.152614806625707],
            -7.088375348045848,
        ),
    ] {
        let d = here.root.chart_direction(local.into());
        let mut path = back.start(x, d, Side::Near, 1e-13).unwrap();
        // L of the light is minus that of the trace.
        assert!((x.length() * path.light.p.y + l).abs() < 1e-11, "{}", x.length() * path.light.p.y);
        let mut met = None;
        let direction = loop {
            let advance = path.advance();
            let arc = advance.arc;
            if met.is_none() && arc.point(arc.end()).x < -8.0 {
                met = Some(arc.point(root(|s| arc.point(s).x + 8.0, arc.start(), arc.end(), false)));
            }
            match advance.fate {
                Fate::Underway => assert!(back.hamilton.violation(&path.light).abs() < 1e-12),
                Fate::Escaped(direction) => break direction,
                other => panic!("{other:?}"),
            }
        };
        let met = met.expect("it comes by");
        assert!(f64::hypot(met.y - at[0], met.z - at[1]) < 1e-10, "{met:?}");
        assert!((direction - DVec3::from(out)).length() < 1e-11, "{direction}");
    }
}

#[test]
fn the_direction_of_time_matters() {
    let hole = Kerr(0.9);
    let x = DVec3::X * 12.0;
    let here = hole.at(bhs_core::spacetime::Place::near(x)).unwrap();
    let d = here.root.chart_direction(DVec3::new(-1.0, -0.5, 0.0));
    let (back, forth) = (around(&hole, true, 20.0), around(&hole, false, 20.0));
    assert_eq!(end(&forth, x, d).0, Fate::Captured);
    let mut path = back.start(x, d, Side::Near, TOLERANCE).unwrap();
    loop {
        let arc = path.advance().arc;
        if arc.point(arc.end()).x < -8.0 {
            let y = arc.point(root(|s| arc.point(s).x + 8.0, arc.start(), arc.end(), false)).y;
            assert!((y + 1.385403296393).abs() < 1e-10, "{y}");
            break;
        }
    }
}

#[test]
fn light_takes_its_time() {
    // Along the radius of a hole without spin: r + rs ln(r - rs) is the time underway.
    let hole = Spherical { center: DVec3::ZERO, rs: 1.0, charge_squared: 0.0 };
    let around = around(&hole, true, 30.0);
    for (from, d) in [(2.0, DVec3::X), (20.0, -DVec3::X)] {
        let mut path = around.start(DVec3::X * from, d, Side::Near, TOLERANCE).unwrap();
        while path.light.x.x > 1.1 && path.light.x.x < 25.0 {
            path.advance();
            let tortoise = |r: f64| r + (r - 1.0).ln();
            let (r, t) = (path.light.x.x, path.light.t);
            assert!((t - (tortoise(r) - tortoise(from)).abs()).abs() < 1e-10, "{from} to {r}: {t}");
        }
        assert!(path.light.t > 5.0);
    }
}

/// Angle by which a ray of the impact parameter `b` > 0 is turned by `lens`, by Bouguer's law: `n r sin = b`. The root's singularity at the turning point is
/// taken out by `r = r0 + s^2`, and `s = t / (1 - t)` brings infinity near.
fn turned_by(lens: &GaussianLens, b: f64) -> f64 {
    let n = |r: f64| (2.0 * lens.strength * (-0.5 * (r / lens.width).powi(2)).exp()).exp();
    let r0 = root(|r| n(r) * r - b, 1e-9, b, true);
    let count = 200_000;
    let sum: f64 = (0..count)
        .map(|i| {
            let t = (f64::from(i) + 0.5) / f64::from(count);
            let s = t / (1.0 - t);
            let r = r0 + s * s;
            let per_t = 2.0 * s / (1.0 - t).powi(2);
            b / (r * ((n(r) * r).powi(2) - b * b).sqrt()) * per_t
        })
        .sum();
    2.0 * sum / f64::from(count) - PI
}

#[test]
fn a_lens_without_a_hole_turns_light_wherever_it_is() {
    for (center, width) in [(DVec3::ZERO, 1.0), (DVec3::new(0.5, 0.0, 0.0), 1.0), (DVec3::new(-40.0, 300.0, 7.0), 0.01)] {
        let lens = GaussianLens { center, strength: 0.3, width };
        // With no surface at all, and with some.
        for reach in [0.0, 5.0] {
            let around = around(&lens, false, reach);
            for share in [0.3, 1.0, 2.0] {
                let b = share * width;
                let start = center + DVec3::new(b, 0.0, -60.0 * width);
                let to = sky(&around, start, DVec3::Z);
                // Towards the axis.
                let angle = (-to.x).atan2(to.z);
                let right = turned_by(&lens, b);
                assert!(right > 0.05 && (angle - right).abs() < 1e-8, "{center} {reach} {share}: {angle}, {right}");
            }
            // From where nothing bends light, and from the very middle.
            for x in [DVec3::ZERO, center] {
                let d = DVec3::new(0.6, 0.0, 0.8);
                let to = sky(&around, x, d);
                assert!(to.is_finite() && (x != center || (to - d).length() < 1e-9), "{center} {reach}: {to}");
            }
        }
    }
}
