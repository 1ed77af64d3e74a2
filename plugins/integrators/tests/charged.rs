//! Orbits around charged holes against quadratures and Hamilton's equations.

#[path = "common/random.rs"]
mod random;

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Side, Spherical};
use bhs_integrators::general::{Fate as Final, Surroundings};
use bhs_integrators::spherical::Attraction;
use bhs_integrators::spherical::orbit::{Dense, Fate, OrbitPlane, Rk4Orbit, State, Stepper};
use bhs_integrators::spherical::plane::Planes;
use bhs_integrators::spherical::steps::{Steps, errors};
use bhs_integrators::spherical::taylor::TaylorOrbit;
use glam::DVec3;
use random::Random;
use std::f64::consts::PI;

/// A hole of mass 1 whose charge is the share `charge` of the largest.
fn hole(charge: f64) -> Spherical {
    Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: charge * charge }
}

/// The angle at which an orbit reaches infinity; `None` if it does not.
fn out<S: Stepper>(mut orbit: S, hole: Attraction) -> Option<f64> {
    for _ in 0..100_000 {
        let (step, fate) = orbit.advance();
        match fate {
            Fate::Underway => {}
            Fate::Escaped => return Some(step.within_space(hole).end().phi),
            Fate::Captured => return None,
        }
    }
    panic!("an orbit without end");
}

/// Deflection of light of impact parameter `b`: the orbits from r = 9 both ways.
fn deflection<S: Stepper>(hole: Attraction, b: f64, orbit: impl Fn(State) -> S) -> f64 {
    let u = 1.0 / 9.0;
    let du = (1.0 / (b * b) - hole.barrier(u)).sqrt();
    let swept = |du| out(orbit(State { phi: 0.0, u, du }), hole).expect("it comes back");
    swept(du) + swept(-du) - PI
}

const DEFLECTIONS: [(f64, f64, f64); 6] = [
    (0.5, 6.0, 1.551187254247158),
    (0.5, 8.9, f64::NAN),
    (0.9, 6.0, 1.272240846265183),
    (1.0, 6.0, 1.197403706675174),
    (0.9, 8.9, f64::NAN),
    (0.0, 6.0, f64::NAN),
];

/// The deflection by quadrature: `2 int du / sqrt(1/b^2 - barrier(u)) - pi` up to the turning point, with `u = u1 sin(t)`.
fn quadrature(hole: Attraction, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, hole.photon_sphere());
    for _ in 0..200 {
        let u = 0.5 * (low + high);
        if hole.barrier(u) * b * b < 1.0 {
            low = u;
        } else {
            high = u;
        }
    }
    let u1 = 0.5 * (low + high);
    // 1/b^2 - barrier(u) is (u1^2 - u^2) times this, without anything that cancels.
    let factor = |u: f64| {
        let (rs, qq) = (hole.rs, hole.charge_squared);
        1.0 - rs * (u1 * u1 + u1 * u + u * u) / (u1 + u) + qq * (u1 * u1 + u * u)
    };
    // Gauss-Legendre, 5 points, in many parts.
    let nodes = [0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
    let weights = [0.568_888_888_888_888_9, 0.478_628_670_499_366_47, 0.236_926_885_056_189_08];
    let parts = 400;
    let mut sum = 0.0;
    for k in 0..parts {
        let h = 0.5 * PI / f64::from(parts);
        for (node, weight) in nodes.iter().zip(weights) {
            for side in if *node == 0.0 { &[0.0][..] } else { &[-1.0, 1.0] } {
                let t = h * (f64::from(k) + 0.5 * (1.0 + side * node));
                sum += 0.5 * h * weight / factor(u1 * t.sin()).sqrt();
            }
        }
    }
    2.0 * sum - PI
}

#[test]
fn deflections_are_those_of_quadratures() {
    for (charge, b, published) in DEFLECTIONS {
        let hole = Attraction::from(&hole(charge));
        let right = quadrature(hole, b);
        assert!(published.is_nan() || (right - published).abs() < 1e-13, "{right} {published}");
        for (error, within) in [(1e-6, 1e-6), (1e-9, 1e-9), (1e-13, 1e-12)] {
            let off = deflection(hole, b, |state| TaylorOrbit::new(hole, state, error)) - right;
            assert!(off.abs() < within, "charge {charge}, b = {b}: {off:e} at {error:e}");
        }
    }
    for (charge, right) in [(0.5, 0.5756100502520441), (0.9, 0.5437063921910459), (1.0, 0.5332426590717215)] {
        // The published ones of b = 10 are those of the quadrature.
        assert!((quadrature((&hole(charge)).into(), 10.0) - right).abs() < 1e-13, "{charge}");
    }
}

#[test]
fn runge_kutta_is_of_order_four() {
    for charge in [0.5, 1.0] {
        let hole = Attraction::from(&hole(charge));
        let right = quadrature(hole, 6.0);
        let off = |step| (deflection(hole, 6.0, |state| Rk4Orbit { hole, step, state }) - right).abs();
        let order = (off(0.1) / off(0.05)).log2();
        assert!((order - 4.0).abs() < 0.5 && off(0.1) < 1e-4, "{charge}: {order}, {:e}", off(0.1));
    }
}

#[test]
fn light_falls_in_within_the_critical_impact_parameter() {
    for charge in [0.0, 0.4, 0.9, 1.0] {
        let hole = Attraction::from(&hole(charge));
        let critical = hole.critical.sqrt().recip();
        // Known: 3 sqrt(3) without charge, 4 with the largest.
        assert!(charge != 0.0 || (critical - 27f64.sqrt()).abs() < 1e-14);
        assert!(charge != 1.0 || (critical - 4.0).abs() < 1e-14);
        for (b, comes_back) in [(critical * (1.0 - 1e-9), false), (critical * (1.0 + 1e-9), true)] {
            let u = 1.0 / 30.0;
            let state = State { phi: 0.0, u, du: (1.0 / (b * b) - hole.barrier(u)).sqrt() };
            assert_eq!(out(TaylorOrbit::new(hole, state, 1e-10), hole).is_some(), comes_back, "{charge} {b}");
        }
    }
}

#[test]
fn first_integrals_are_kept() {
    let hole = Attraction::from(&hole(0.8));
    let mut random = Random(5);
    for _ in 0..500 {
        let (u, du) = (0.02 + 0.25 * random.number().abs(), 0.3 * random.number());
        let mut orbit = TaylorOrbit::new(hole, State { phi: 0.0, u, du }, 1e-12);
        let first = |s: State| s.du * s.du + hole.barrier(s.u);
        let start = first(State { phi: 0.0, u, du });
        loop {
            let (step, fate) = orbit.advance();
            let end = step.within_space(hole).end();
            let scale = start + end.du * end.du;
            assert!((first(end) - start).abs() < 1e-11 * scale, "{end:?} {:e}", (first(end) - start).abs() / scale);
            if fate != Fate::Underway {
                break;
            }
        }
    }
}

#[test]
fn without_charge_nothing_changes() {
    assert_eq!(Attraction::from(&hole(0.0)), Attraction::from(2.0));
}

#[test]
fn eight_orbits_are_as_one() {
    let attraction = Attraction::from(&hole(0.7));
    let mut random = Random(9);
    for _ in 0..50 {
        let rays: [_; LANES] = std::array::from_fn(|_| (random.vector() * 9.0 + DVec3::X * 12.0, random.vector().normalize()));
        let (x, d) = (Vector::of(rays.map(|r| r.0)), Vector::of(rays.map(|r| r.1)));
        let (planes, start) = Planes::of_rays(DVec3::ZERO, x, d);
        let steps = Steps::from(attraction, &start, errors(attraction, &start, Lanes::splat(1e-9)));
        for (i, (x, d)) in rays.into_iter().enumerate() {
            let (plane, state) = OrbitPlane::of_ray(DVec3::ZERO, x, d);
            let (step, _) = TaylorOrbit::new(attraction, state, 1e-9).advance();
            let (one, side_by_side) = (step.end(), steps.end.lane(i));
            assert!((side_by_side.phi - one.phi).abs() < 1e-12 && (side_by_side.u - one.u).abs() < 1e-13, "{one:?}");
            assert!((planes.e2.lane(i) - plane.e2).length() < 1e-12);
            // The same code for one ray gives the same bits.
            let (alone, start) = Planes::<f64>::of_rays(DVec3::ZERO, x.into(), d.into());
            let step = Steps::from(attraction, &start, errors(attraction, &start, 1e-9));
            assert_eq!((alone.e2.lane(0), step.end), (planes.e2.lane(i), side_by_side));
        }
    }
}

#[test]
fn orbits_agree_with_hamiltons_equations() {
    let count = std::env::var("BHS_GEODESICS").map_or(2_000, |n| n.parse().expect("BHS_GEODESICS is a number"));
    for charge in [0.0, 0.6, 1.0] {
        let spherical = Spherical { center: DVec3::new(0.2, -0.1, 0.3), ..hole(charge) };
        let spacetime = spherical;
        let attraction = Attraction::from(&spherical);
        let around = Surroundings::new(&spacetime, None, false, Ball { center: DVec3::ZERO, radius: 10.0 });
        let mut random = Random(21);
        let mut compared = 0;
        for _ in 0..count {
            let (x, d) = random.ray(8.0, &spacetime);
            let (plane, state) = OrbitPlane::of_ray(spherical.center, x, d);
            let sky = out(TaylorOrbit::new(attraction, state, 1e-12), attraction).map(|phi| plane.radial(phi));
            // Next to a horizon errors of places, and rounding, weigh more.
            let lapse_squared = spherical.lapse_squared((x - spherical.center).length());
            let mut path = around.start(x, d, Side::Near, (1e-11 * lapse_squared).max(1e-14)).expect("a place");
            let end = loop {
                match path.advance().fate {
                    Final::Underway => {}
                    end => break end,
                }
            };
            // How near the ray is to one that winds for ever: errors grow by the inverse.
            let inverse = state.du * state.du + attraction.barrier(state.u);
            let closeness = ((inverse - attraction.critical).abs() / inverse).min(1.0);
            // Of a ray from next to an extremal horizon the oracle has few digits: there the quadrature sides with the orbit.
            let within = (1e-9 + 1e-14 / (lapse_squared * lapse_squared)) / closeness;
            match (sky, end) {
                (Some(a), Final::Escaped(b)) => {
                    assert!((a - b).length() < within, "{charge} {x} {d}: {:e} {closeness}", (a - b).length());
                    compared += 1;
                }
                (None, Final::Captured) => {}
                other => assert!(closeness < 1e-8, "{charge} {x} {d}: {other:?}"),
            }
        }
        assert!(compared > count / 3);
    }
}
