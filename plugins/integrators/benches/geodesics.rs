//! What it costs to follow a ray, without any surface: steps a ray, attempts at them, time a step and a ray, of one ray and of eight.
//!
//! `cargo bench -p bhs-integrators --bench geodesics`

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::{Mask, Real, Vector};
use bhs_core::spacetime::{Ball, Class, Place, Side, Spacetime, Spherical, Throat};
use bhs_integrators::general::{Fate as Final, Surroundings};
use bhs_integrators::graded_index::medium::{Medium, Refracted};
use bhs_integrators::graded_index::path::Paths;
use bhs_integrators::spherical::Attraction;
use bhs_integrators::spherical::course::SphericalSetup;
use bhs_integrators::spherical::orbit::{Dense, Fate, OrbitPlane, Rk4Orbit, State, Stepper};
use bhs_integrators::spherical::taylor::TaylorOrbit;
use bhs_integrators::tracing::arc::Arc;
use bhs_integrators::tracing::driver::Course;
use bhs_spacetimes::{Dneg, Ellis, Hole, Kerr, MajumdarPapapetrou};
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;

type Rays = Vec<(DVec3, DVec3)>;

const REACH: Ball = Ball { center: DVec3::ZERO, radius: 12.0 };

/// Rays from around a scene through it, all the same each time (Knuth 1998, volume 2, section 3.3.4).
fn rays(spacetime: &dyn Spacetime) -> Rays {
    let mut seed = 1u64;
    let mut number = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut rays = Rays::new();
    while rays.len() < 4096 {
        let mut vector = || DVec3::new(number(), number(), number());
        let (from, at) = (vector() * 10.0, vector() * 5.0);
        if spacetime.at(Place::near(from)).is_some() && (from - at).length() > 0.1 {
            rays.push((from, (at - from).normalize()));
        }
    }
    rays
}

/// Steps, attempts.
type Counts = (u64, u64);

/// Processor time of this thread (s), where the system tells it: other programs do not count then.
fn busy() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    told.split(' ').next()?.parse().ok().map(|ns: f64| 1e-9 * ns)
}

fn report(spacetime: &str, method: &str, rays: usize, follow: impl Fn() -> Counts) {
    // Long enough for the clock of the system, which may tick as rarely as every 10 ms.
    let (start, before) = (Instant::now(), busy());
    let (mut runs, mut time) = (0.0, 0.0);
    let (mut steps, mut attempts) = (0, 0);
    while time < 0.3 {
        (steps, attempts) = black_box(follow());
        runs += 1.0;
        time = busy().zip(before).map_or(start.elapsed().as_secs_f64(), |(after, before)| after - before);
    }
    time /= runs;
    let (rays, steps) = (rays as f64, steps as f64);
    let line = format!(
        "{spacetime:<22} {method:<24} {:>6.1} steps a ray, {:>4.2} attempts a step, {:>7.0} ns a step, {:>8.0} ns a ray",
        steps / rays,
        attempts as f64 / steps,
        1e9 * time / steps,
        1e9 * time / rays
    );
    #[allow(clippy::print_stdout)] // that is what it is for
    {
        println!("{line}");
    }
}

fn planar<S: Stepper>(mut orbit: S, hole: Attraction, arc: impl Fn(&S::Step) -> f64) -> Counts {
    let mut steps = 0;
    loop {
        let (step, fate) = orbit.advance();
        steps += 1;
        black_box(arc(&step));
        if fate != Fate::Underway || steps > 10_000 {
            if fate == Fate::Escaped {
                black_box(step.within_space(hole).end());
            }
            return (steps, steps);
        }
    }
}

fn planar_lanes(hole: &Spherical, rays: &Rays, error: f64) -> Counts {
    let mut steps = 0;
    // No surface is near, so that rays are followed to the sky.
    let setting = SphericalSetup::new(hole, REACH.radius);
    for group in rays.chunks_exact(LANES) {
        let (x, d) = (Vector::from_fn(|i| group[i].0), Vector::from_fn(|i| group[i].1));
        let mut course = setting.launch(x, d).by_series(Lanes::splat(error));
        let mut going = <Lanes as Real>::Mask::ALL;
        for _ in 0..1000 {
            if !Mask::any(going) {
                break;
            }
            steps += u64::from(Mask::bits(going).count_ones());
            let next = course.advance(going);
            let piece = course.piece();
            black_box(piece.point(piece.start()));
            if Mask::any(next.escapes) {
                course.directions(next.escapes, |_, direction, _| {
                    black_box(direction);
                });
            }
            going &= !(next.escapes | next.falls);
        }
    }
    (steps, steps)
}

fn graded<F: Refracted>(medium: &Medium<'_>, rays: &Rays, tolerance: f64, share: Option<f64>) -> Counts {
    let mut counts = (0, 0);
    for group in rays.chunks_exact(F::COUNT) {
        let (x, d) = (Vector::from_fn(|i| group[i].0), Vector::from_fn(|i| group[i].1));
        let mut paths = Paths::<F>::new(medium, x, d, 0, F::splat(tolerance), REACH);
        if let Some(share) = share {
            paths = paths.by_runge_kutta(share);
        }
        let (mut going, mut escaped) = (F::Mask::ALL, F::Mask::NONE);
        for _ in 0..10_000 {
            let advance = paths.advance(going);
            black_box(advance.arc.point(advance.arc.end()));
            escaped = escaped | advance.escaped;
            going = going & !(advance.escaped | advance.captured | advance.lost);
            if !going.any() {
                break;
            }
        }
        // Of all of them at once, which costs no more than of one.
        black_box(paths.directions(escaped));
        counts = (counts.0 + u64::from(paths.counts[0]), counts.1 + u64::from(paths.counts[1]));
    }
    counts
}

fn general(spacetime: &dyn Spacetime, throat: Option<Throat>, rays: &Rays, tolerance: f64) -> Counts {
    let around = Surroundings::new(spacetime, throat, true, REACH);
    let mut counts = (0, 0);
    for (x, d) in rays {
        let mut path = around.start(*x, *d, Side::Near, tolerance).expect("a place");
        while let Final::Underway | Final::Crossed = path.advance().fate {}
        counts = (counts.0 + u64::from(path.counts[0]), counts.1 + u64::from(path.counts[1]));
    }
    counts
}

fn main() {
    for (name, charge) in [("schwarzschild", 0.0), ("reissner-nordstrom", 0.8)] {
        let spherical = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: charge * charge };
        let hole = Attraction::from(&spherical);
        let rays = rays(&spherical);
        let all = |follow: &dyn Fn(&OrbitPlane, State) -> Counts| {
            rays.iter().fold((0, 0), |sum, (x, d)| {
                let (plane, state) = OrbitPlane::of_ray(DVec3::ZERO, *x, *d);
                let found = follow(&plane, state);
                (sum.0 + found.0, sum.1 + found.1)
            })
        };
        for error in [1e-7, 1e-12] {
            report(name, &format!("taylor, 1, {error:e}"), rays.len(), || {
                all(&|plane, state| planar(TaylorOrbit::new(hole, state, error), hole, |step| plane.point(&Dense::start(step)).x))
            });
            report(name, &format!("taylor, 8, {error:e}"), rays.len(), || planar_lanes(&spherical, &rays, error));
        }
        report(name, "rk4, 1, 0.1 rad", rays.len(), || {
            all(&|plane, state| planar(Rk4Orbit { hole, step: 0.1, state }, hole, |step| plane.point(&step.start).x))
        });
        report(name, "general, 1, 1e-9", rays.len() / 4, || general(&spherical, None, &rays[..rays.len() / 4].to_vec(), 1e-9));
    }
    let holes = |n: usize| {
        let places = [DVec3::Z, -DVec3::Z, DVec3::X * 1.5, DVec3::Y * 2.0];
        MajumdarPapapetrou::new(
            &places[..n].iter().map(|center| Hole { center: *center, mass: 1.0 / n as f64 }).collect::<Vec<_>>(),
        )
    };
    let (one, two, four) = (holes(1), holes(2), holes(4));
    let (ellis, dneg) = (Ellis { center: DVec3::ZERO, throat: 1.0 }, Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.2).expect("a wormhole"));
    let indices: [(&str, &dyn Spacetime); 5] = [
        ("one extremal hole", &one),
        ("two extremal holes", &two),
        ("four extremal holes", &four),
        ("ellis", &ellis),
        ("dneg", &dneg),
    ];
    for (name, spacetime) in indices {
        let Class::Index(index) = spacetime.class() else { unreachable!("these are indices") };
        let medium = Medium::new(index, spacetime.captures());
        let rays = rays(spacetime);
        for tolerance in [1e-6, 1e-7, 1e-9, 1e-12] {
            report(name, &format!("nystroem, 1, {tolerance:e}"), rays.len(), || graded::<f64>(&medium, &rays, tolerance, None));
            report(name, &format!("nystroem, 8, {tolerance:e}"), rays.len(), || graded::<Lanes>(&medium, &rays, tolerance, None));
        }
        report(name, "rk4, 8, 0.1 rad", rays.len(), || graded::<Lanes>(&medium, &rays, 1e-7, Some(0.1)));
        report(name, "general, 1, 1e-9", rays.len() / 4, || {
            general(spacetime, index.throat(), &rays[..rays.len() / 4].to_vec(), 1e-9)
        });
    }
    for spin in [0.5, 0.9, 0.998] {
        let spherical = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 };
        let kerr = Kerr::new(spherical, DVec3::Y, spin);
        let rays: Rays = rays(&kerr).into_iter().take(1024).collect();
        for tolerance in [1e-7, 1e-9, 1e-12] {
            report(&format!("kerr, {spin}"), &format!("general, 1, {tolerance:e}"), rays.len(), || {
                general(&kerr, None, &rays, tolerance)
            });
        }
    }
}
