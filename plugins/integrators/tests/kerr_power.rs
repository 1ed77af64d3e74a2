//! What one disc sends to another around a hole that spins, by rays that are traced from the one, and by connections from the other around the
//! opposite spin: lamp and eye change places.

#![allow(clippy::print_stderr, reason = "tests say what they measured")]

#[path = "common/empty.rs"]
mod empty;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "every test file is a crate of its own and uses its part")]
mod random;

use bhs_core::geometry::Geometry;
use bhs_core::observer::{Conventions, Observer};
use bhs_core::spacetime::{Kerr, Place, Spacetime, Spherical};
use bhs_engine::connections::Connections;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::arithmetic::root::root;
use bhs_integrators::kerr::connections::KerrConnections;
use bhs_integrators::kerr::course::KerrSetup;
use bhs_integrators::tracing::arc::Arc as _;
use bhs_integrators::tracing::driver::Course as _;
use empty::Empty;
use glam::DVec3;
use random::Random;
use std::f64::consts::PI;
use std::sync::Arc;

fn hole(spin: f64) -> Kerr {
    Kerr::new(Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 }, DVec3::Y, spin)
}

/// A flat disc.
#[derive(Clone, Copy)]
struct Disc {
    center: DVec3,
    normal: DVec3,
    radius: f64,
}

impl Disc {
    fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// A random point of it.
    fn point(&self, random: &mut Random) -> DVec3 {
        let (e, f) = self.normal.any_orthonormal_pair();
        loop {
            let (a, b) = (random.number(), random.number());
            if a * a + b * b < 1.0 {
                return self.center + (e * a + f * b) * self.radius;
            }
        }
    }

    /// Local over chart area where `observer` is.
    fn stretch(&self, observer: &Observer) -> f64 {
        // Along the normal, the bundle's area is that of the disc but for the tilt of the direction against the local normal.
        let tilt = observer.local_normal(self.normal).dot(observer.local_direction(self.normal)).abs();
        observer.bundle_area_factor(self.normal) / tilt
    }
}

/// How often the ray from `x` along `d` passes `disc` from the front.
fn passes(setup: &KerrSetup, x: DVec3, d: DVec3, disc: &Disc) -> u32 {
    let mut course = setup.by_series::<f64>(x.into(), d.into(), 1e-9);
    let mut count = 0;
    for _ in 0..300 {
        let next = course.advance(true);
        let piece = course.piece();
        let height = |s: f64| (disc.center - DVec3::from(piece.point(s))).dot(disc.normal);
        for k in 0..4 {
            let at = |k: i32| piece.start() + (piece.end() - piece.start()) * f64::from(k) / 4.0;
            let (a, b) = (at(k), at(k + 1));
            if b > a && height(a) < 0.0 && height(b) >= 0.0 {
                let point = DVec3::from(piece.point(root(height, a, b, true)));
                count += u32::from(point.distance(disc.center) < disc.radius);
            }
        }
        if next.escapes || next.falls || next.lost {
            break;
        }
    }
    count
}

fn observer(spacetime: &dyn Spacetime, x: DVec3) -> (Observer, f64) {
    let here = spacetime.at(Place::near(x)).unwrap();
    (Observer::at_rest(&here), here.lapse)
}

/// By rays from `from`, of all directions of its front: the integral of area, cosine and solid angle over the square of the lapse, of those that pass
/// `to`; and its standard error.
fn by_tracing(hole: &Kerr, from: &Disc, to: &Disc, rays: u32) -> (f64, f64) {
    let setup = KerrSetup::around(hole, true, 60.0, 0.0);
    let mut random = Random(2024);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..rays {
        let x = from.point(&mut random);
        let (observer, lapse) = observer(hole, x);
        let up = observer.local_normal(from.normal);
        // A cosine's density: the unit vector of the normal and a point of the sphere.
        let sphere = loop {
            let v = DVec3::new(random.number(), random.number(), random.number());
            if v.length_squared() < 1.0 && v.length_squared() > 1e-4 {
                break v.normalize();
            }
        };
        let d = observer.chart_direction((up + sphere).normalize());
        let found = f64::from(passes(&setup, x, d, to)) * from.area() * from.stretch(&observer) * PI / (lapse * lapse);
        sum += found;
        squares += found * found;
    }
    let n = f64::from(rays);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

/// The same by connections from points of `to` to points of `from` around `hole`.
fn by_connections(hole: Kerr, from: &Disc, to: &Disc, pairs: u32) -> (f64, f64) {
    let spacetime: Arc<dyn Spacetime> = Arc::new(hole);
    let world = World::new(Vec::<Geometry>::new(), Box::new(Empty), DVec3::ZERO).in_spacetime(spacetime, Conventions::NATURE);
    let connections = KerrConnections { tolerance: Tolerance::DEFAULT };
    let mut random = Random(77);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..pairs {
        let (x, y) = (to.point(&mut random), from.point(&mut random));
        let ((at_x, lapse), (at_y, _)) = (observer(&hole, x), observer(&hole, y));
        let mut found = 0.0;
        for c in connections.connect(&world, Place::near(x), Place::near(y), 0).iter().flatten() {
            let cos_x = at_x.local_normal(to.normal).dot(at_x.local_direction(c.launch));
            let cos_y = -at_y.local_normal(from.normal).dot(at_y.local_direction(c.arrival));
            let spread = c.spread * at_y.bundle_area_factor(c.arrival) / at_x.solid_angle_factor(c.launch);
            found += cos_x.max(0.0) * cos_y.max(0.0) / spread;
        }
        found *= to.area() * to.stretch(&at_x) * from.area() * from.stretch(&at_y) / (lapse * lapse);
        sum += found;
        squares += found * found;
    }
    let n = f64::from(pairs);
    let mean = sum / n;
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

#[test]
fn lamp_and_eye_change_places_if_the_spin_is_reversed() {
    let lamp = Disc { center: DVec3::new(8.0, 1.0, 2.0), normal: DVec3::new(-1.0, 0.0, 0.1).normalize(), radius: 2.5 };
    let eye = Disc { center: DVec3::new(-2.0, -1.5, 9.0), normal: DVec3::new(0.5, 0.1, -1.0).normalize(), radius: 2.5 };
    let mut ways = Vec::new();
    for spin in [0.9, -0.9] {
        let (traced, error) = by_tracing(&hole(spin), &lamp, &eye, 60_000);
        let (found, noise) = by_connections(hole(-spin), &lamp, &eye, 6_000);
        eprintln!("{spin}: {traced:.4} +- {error:.4} by rays of the lamp, {found:.4} +- {noise:.4} by connections of the eye");
        // What winds further is a share of some 1e-3.
        assert!((traced - found).abs() < 4.0 * error.hypot(noise) + 4e-3 * traced, "{spin}: {traced} {found}");
        ways.push((found, noise));
    }
    // The spin shows, or nothing would be tested.
    let difference = (ways[0].0 - ways[1].0).abs();
    assert!(difference > 8.0 * ways[0].1.hypot(ways[1].1), "{ways:?}");
}
