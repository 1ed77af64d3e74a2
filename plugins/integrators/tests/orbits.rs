//! Orbits against what is known of them in closed form: deflection, capture, order of convergence, chords.

use bhs_integrators::orbit::{Dense, Fate, OrbitPlane, Rk4Orbit, State, Step, Stepper};
use glam::DVec3;

/// Follows an orbit to its end.
fn follow(rs: f64, step: f64, state: State) -> (Vec<Step>, Fate) {
    let mut orbit = Rk4Orbit { hole: rs.into(), step, state };
    let mut steps = Vec::new();
    loop {
        let (step, fate) = orbit.advance();
        steps.push(step.within_space(rs));
        if fate != Fate::Underway {
            return (steps, fate);
        }
        assert!(steps.len() < 2_000_000, "the orbit does not end");
    }
}

/// A ray that comes from infinity with the impact parameter `b`: u = 0, u' = 1/b.
fn from_infinity(b: f64) -> State {
    State { phi: 0.0, u: 0.0, du: 1.0 / b }
}

fn deflection(b: f64, step: f64) -> f64 {
    let (steps, fate) = follow(1.0, step, from_infinity(b));
    assert_eq!(fate, Fate::Escaped);
    steps[steps.len() - 1].end.phi - std::f64::consts::PI
}

/// Total deflection by elliptic integrals, b in units of rs.
const DEFLECTIONS: [(f64, f64); 4] =
    [(2.7, 2.919396339609558), (3.0, 1.719388310230169), (5.0, 0.590395787605827), (100.0, 0.020299966239543)];

#[test]
fn deflections_are_those_of_the_elliptic_integrals() {
    for (b, exact) in DEFLECTIONS {
        let error = (deflection(b, 0.01) - exact).abs();
        assert!(error < 1e-6, "b = {b}: error {error:.1e}");
    }
}

#[test]
fn runge_kutta_converges_with_order_four() {
    for (b, exact) in [DEFLECTIONS[1], DEFLECTIONS[2]] {
        let error = |step: f64| (deflection(b, step) - exact).abs();
        // Steps small enough for the leading term, large enough for it to stand above rounding.
        let slope = (error(0.04) / error(0.01)).log2() / 2.0;
        assert!((3.9..=4.1).contains(&slope), "b = {b}: slope {slope:.3}");
    }
}

#[test]
fn chords_converge_with_order_two_and_have_the_sagitta_of_the_formula() {
    let plane = OrbitPlane { center: DVec3::ZERO, e1: DVec3::X, e2: DVec3::Y };
    // The largest radial gap between chord and orbit where the orbit lies well inside.
    let gap = |h: f64| {
        let (steps, _) = follow(1.0, h, State { phi: 0.0, u: 0.1, du: 0.2 });
        let whole = |s: &&Step| (s.end.phi - s.start.phi - h).abs() < 1e-12 && s.end.u > 0.1;
        let mut largest = 0.0f64;
        for step in steps.iter().filter(whole) {
            let (a, b) = (plane.point(&step.start), plane.point(&step.end));
            for k in 1..20 {
                let p = a + (b - a) * (f64::from(k) / 20.0);
                let swept = (p - plane.center)
                    .dot(plane.radial(step.start.phi + std::f64::consts::FRAC_PI_2))
                    .atan2((p - plane.center).dot(plane.radial(step.start.phi)));
                let r = 1.0 / step.at(step.start.phi + swept).u;
                largest = largest.max((p.length() - r).abs());
            }
        }
        largest
    };
    let slope = (gap(0.1) / gap(0.025)).log2() / 2.0;
    assert!((1.9..=2.1).contains(&slope), "slope {slope:.3}");
    let ratio = gap(0.05) / (3.0 / 16.0 * 0.05 * 0.05);
    assert!((0.95..1.05).contains(&ratio), "sagitta over the formula's: {ratio:.3}");
}

#[test]
fn dense_output_agrees_with_shorter_steps() {
    let start = State { phi: 0.0, u: 0.2, du: 0.3 };
    let (coarse, _) = follow(1.0, 0.05, start);
    let (fine, _) = follow(1.0, 0.05 / 16.0, start);
    for step in &fine {
        let phi = step.end.phi;
        if let Some(within) = coarse.iter().find(|c| c.start.phi <= phi && phi <= c.end.phi) {
            let s = within.at(phi);
            assert!((s.u - step.end.u).abs() < 1e-6 && (s.du - step.end.du).abs() < 1e-5, "{s:?} {:?}", step.end);
        }
    }
}

#[test]
fn what_comes_within_b_crit_is_captured_after_winding() {
    let b_crit = 1.5 * 3f64.sqrt();
    for epsilon in [1e-2, 1e-4, 1e-6] {
        let (steps, fate) = follow(1.0, 0.01, from_infinity(b_crit * (1.0 - epsilon)));
        assert_eq!(fate, Fate::Captured);
        assert!((steps[steps.len() - 1].end.u - 1.0).abs() < 1e-12);
        assert_eq!(follow(1.0, 0.01, from_infinity(b_crit * (1.0 + epsilon))).1, Fate::Escaped);
    }
    // Darwin 1959: delta ~ -ln(b/b_crit - 1) + ln(216 (7 - 4 sqrt 3)) - pi near b_crit.
    let x = 1e-4;
    let expected = -f64::ln(x) + (216.0 * (7.0 - 4.0 * 3f64.sqrt())).ln() - std::f64::consts::PI;
    let found = deflection(b_crit * (1.0 + x), 0.01);
    assert!(found > std::f64::consts::TAU && (found - expected).abs() < 2e-3, "{found} {expected}");
}

#[test]
fn radial_rays_go_straight_in_or_straight_out() {
    let center = DVec3::new(3.0, -2.0, 7.0);
    let origin = center + DVec3::new(0.0, 4.0, 3.0);
    let out = DVec3::new(0.0, 0.8, 0.6);
    for tilt in [0.0, 1e-16, 1e-12, 1e-8, 1e-4] {
        let away = (out + DVec3::X * tilt).normalize();
        let (plane, state) = OrbitPlane::of_ray(center, origin, away);
        let (steps, fate) = follow(1.0, 0.1, state);
        assert_eq!(fate, Fate::Escaped, "tilt {tilt}");
        let end = plane.radial(steps[steps.len() - 1].end.phi);
        // Starting at r = 5 rs, the direction changes by about (rs/r) times the tilt.
        assert!((end - away).length() <= 0.5 * tilt + 1e-15, "tilt {tilt}: {end} {away}");
        assert!(steps.iter().all(|s| s.end.u.is_finite() && s.end.du.is_finite()));

        let (_, state) = OrbitPlane::of_ray(center, origin, -away);
        let (steps, fate) = follow(1.0, 0.1, state);
        assert_eq!(fate, Fate::Captured, "tilt {tilt}");
        assert!(steps[steps.len() - 1].end.phi < 10.0 * tilt + 1e-15);
    }
}

#[test]
fn from_inside_the_photon_sphere_only_steep_rays_escape() {
    // sin(theta_shadow) in the local frame, b = r sin(alpha_local)/sqrt(f): escape iff outward and b < b_crit.
    let b_crit = 1.5 * 3f64.sqrt();
    for r in [1.0001, 1.01, 1.2, 1.45f64] {
        let f = 1.0 - 1.0 / r;
        for (factor, expected) in [(0.999, Fate::Escaped), (1.001, Fate::Captured)] {
            let sin_local = factor * b_crit * f.sqrt() / r;
            assert!(sin_local < 1.0, "r = {r}");
            let tan_chart = sin_local / (1.0 - sin_local * sin_local).sqrt() / f.sqrt();
            let state = State { phi: 0.0, u: 1.0 / r, du: -1.0 / (tan_chart * r) };
            assert_eq!(follow(1.0, 0.01, state).1, expected, "r = {r}, factor {factor}");
        }
    }
}

#[test]
fn without_a_hole_orbits_are_straight_lines() {
    let origin = DVec3::new(2.0, 1.0, -1.0);
    let direction = DVec3::new(-0.6, 0.64, 0.48);
    let (plane, state) = OrbitPlane::of_ray(DVec3::ZERO, origin, direction);
    let (steps, _) = follow(1e-12, 0.01, state);
    for step in steps.iter().filter(|s| s.end.u > 0.01) {
        let away = plane.point(&step.end) - origin;
        assert!(away.cross(direction).length() < 1e-8 * away.length().max(1.0));
        assert!((plane.direction(&step.end) - direction).length() < 1e-8);
    }
}
