//! The closed form against 30-digit reference orbits (tests/reference/orbits.py), and what follows from it.

mod common;

use bhs_integrators::closed_form::{ClosedForm, ExactOrbit};
use bhs_integrators::orbit::{Dense, Fate, OrbitPlane, State, Stepper};
use bhs_integrators::taylor::TaylorOrbit;
use glam::DVec3;

/// The rows of a table: the regime, and the numbers after it (NaN for words).
fn rows(table: &str) -> impl Iterator<Item = (&str, Vec<f64>)> {
    table.lines().skip(1).map(|line| {
        let (regime, rest) = line.split_once(',').expect("a row has several columns");
        (regime, rest.split(',').map(|t| t.parse().unwrap_or(f64::NAN)).collect())
    })
}

const ORBITS: &str = include_str!("../../../tests/reference/orbits.csv");
const ENDS: &str = include_str!("../../../tests/reference/ends.csv");

#[test]
fn the_closed_form_has_twelve_digits_in_all_regimes() {
    let mut count = 0;
    for (regime, x) in rows(ORBITS) {
        let [rs, u0, du0, phi, u, du] = x[..] else { panic!("{regime}: {x:?}") };
        let (found_u, found_du) = ClosedForm::new(rs, u0, du0).at(phi);
        let place = format!("{regime}: rs {rs} u0 {u0} du0 {du0} phi {phi}: u {found_u} instead of {u}, u' {found_du}, {du}");
        assert!((found_u - u).abs() <= 1e-12 * u, "{place}");
        // Sharper: some rounding errors of u, and of what u changes by when phi is rounded.
        assert!((found_u - u).abs() <= 6.0 * f64::EPSILON * (u + du.abs() * phi), "{place}");
        let force = (1.5 * rs * u - 1.0) * u;
        assert!((found_du - du).abs() <= 1e-12 * (du.abs() + u), "{place}");
        assert!((found_du - du).abs() <= 10.0 * f64::EPSILON * (du.abs() + u + force.abs() * phi), "{place}");
        count += 1;
    }
    assert!(count > 700);
}

/// Follows an orbit to its end, without looking at its points.
fn end<S: Stepper>(rs: f64, mut orbit: S) -> (State, Fate) {
    for _ in 0..10_000 {
        let (step, fate) = orbit.advance();
        assert!(step.end().u.is_finite() && step.end().du.is_finite() && step.end().phi > step.start().phi);
        if fate != Fate::Underway {
            return (step.within_space(rs).end(), fate);
        }
    }
    panic!("the orbit does not end");
}

#[test]
fn orbits_end_where_they_must() {
    for ((regime, x), line) in rows(ENDS).zip(ENDS.lines().skip(1)) {
        let (rs, u0, du0, phi) = (x[0], x[1], x[2], x[4]);
        let captured = line.contains("captured");
        let expected = if captured { Fate::Captured } else { Fate::Escaped };
        let (last, fate) = end(rs, ExactOrbit::new(&ClosedForm::new(rs, u0, du0)));
        assert_eq!(fate, expected, "{line}");
        // u cannot be told to better than a rounding error, nor the angle at which it has a given value.
        let rounding = |last: &State| f64::EPSILON * (16.0 * phi + 4.0 * u0.max(last.u) / last.du.abs());
        assert!((last.phi - phi).abs() <= rounding(&last), "{line}: {}", last.phi);

        // Stepped in double precision, the angle is uncertain by the relative error of epsilon; on the photon sphere itself
        // rounding decides.
        let epsilon = ClosedForm::new(rs, u0, du0).epsilon().abs();
        if epsilon > 1e-13 {
            let (last, fate) = end(rs, TaylorOrbit::new(rs, State { phi: 0.0, u: u0, du: du0 }, 1e-10));
            assert_eq!(fate, expected, "{line}");
            let allowed = 1e-9 * phi + 2e-14 / epsilon + rounding(&last);
            assert!((last.phi - phi).abs() <= allowed, "{regime} {line}: {} allowed {allowed:.1e}", last.phi);
        }
    }
}

#[test]
fn on_the_photon_sphere_light_goes_round_three_times() {
    // In double precision r0 = 1.5 rs is missed by some 1e-17, which e-folds once per radian: after three turns it is 1e-9.
    for rs in [0.1, 1.0, 3.0] {
        let r0 = 1.5 * rs;
        let form = ClosedForm::new(rs, 1.0 / r0, 0.0);
        for turn in 1..=3 {
            let phi = std::f64::consts::TAU * f64::from(turn);
            let (u, du) = form.at(phi);
            let missed = 1e-16 * phi.cosh();
            assert!((u * r0 - 1.0).abs() <= missed && (du * r0).abs() <= missed, "rs {rs}, turn {turn}: {u} {du}");
        }
        assert!((form.at(6.0 * std::f64::consts::PI).0 * r0 - 1.0).abs() < 3e-8);
    }
}

#[test]
fn light_comes_back_the_way_it_went() {
    let mut dice = common::Dice(20260503);
    let mut worst = 0.0f64;
    for _ in 0..20_000 {
        let origin = dice.point(1.0);
        let rs = 0.2 * dice.unit();
        if origin.length() <= 1.001 * rs {
            continue;
        }
        let (plane, start) = OrbitPlane::of_ray(DVec3::ZERO, origin, dice.direction());
        let form = ClosedForm::new(rs, start.u, start.du);
        let (last, _) = end(rs, ExactOrbit::new(&form));
        // Anywhere on the way, inside a scene of diameter 4.
        let phi = last.phi * dice.within(0.01, 0.99);
        let (u, du) = form.at(phi);
        if u < 0.5 {
            continue;
        }
        let there = State { phi, u, du };
        let (back_plane, back) = OrbitPlane::of_ray(DVec3::ZERO, plane.point(&there), -plane.direction(&there));
        let (u, _) = ClosedForm::new(rs, back.u, back.du).at(phi);
        let home = back_plane.point(&State { phi, u, du: 0.0 });
        // The way back starts from rounded numbers, and near the photon sphere an orbit magnifies that by 1/|epsilon|.
        let magnified = 1.0 / form.epsilon().abs().min(1.0);
        worst = worst.max((home - origin).length());
        assert!((home - origin).length() < 1e-14 * magnified.max(1e3), "rs {rs} {origin} {magnified:.1e}");
    }
    eprintln!("farthest from home: {worst:.1e}");
}

#[test]
fn taylor_orbits_keep_to_their_error() {
    let mut dice = common::Dice(20260503);
    for error in [1e-3, 1e-5, 1e-8, 1e-10] {
        for _ in 0..5_000 {
            let rs = 0.3 * dice.unit();
            let origin = dice.point(1.0);
            if origin.length() <= 1.001 * rs {
                continue;
            }
            let (_, start) = OrbitPlane::of_ray(DVec3::ZERO, origin, dice.direction());
            let form = ClosedForm::new(rs, start.u, start.du);
            let mut orbit = TaylorOrbit::new(rs, start, error);
            let allowed = error + 1e-15 / form.epsilon().abs();
            loop {
                let (step, fate) = orbit.advance();
                let step = step.within_space(rs);
                let (a, b) = (step.start().phi, step.end().phi);
                for k in 1..=8 {
                    let s = step.at(a + (b - a) * f64::from(k) / 8.0);
                    let (u, du) = form.at(s.phi);
                    // Distance across the ray, relative to r.
                    let across = (s.u - u).abs() / u.hypot(du);
                    if u * rs < 0.999 {
                        assert!(across <= allowed, "rs {rs} {start:?} phi {}: {across:.1e} > {allowed:.1e}", s.phi);
                        let between = step.place(s.phi).0;
                        assert!((between - s.u).abs() <= 1e-14 * (s.u + start.u + start.du.abs()));
                    }
                }
                if fate != Fate::Underway {
                    break;
                }
            }
        }
    }
}
