//! Rays between two points around charged holes: against orbits followed by their equation, differences of those, and the plain hole's closed form.

#![allow(clippy::print_stderr, reason = "tests say what they measured")]

#[path = "common/empty.rs"]
mod empty;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "every test file is a crate of its own and uses its part")]
mod random;

use bhs_core::geometry::Geometry;
use bhs_core::observer::{Conventions, Observer};
use bhs_core::spacetime::{Ball, Place, Side, Spherical};
use bhs_engine::connections::{Connection, Connections};
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::general::{Fate as Final, Surroundings};
use bhs_integrators::round::charged::ChargedConnections;
use bhs_integrators::spherical::Attraction;
use bhs_integrators::spherical::connect::connect_pair;
use bhs_integrators::spherical::connect::sky::connect_sky;
use bhs_integrators::spherical::orbit::{Dense, Fate, OrbitPlane, Stepper};
use bhs_integrators::spherical::taylor::TaylorOrbit;
use bhs_integrators::tracing::arc::Arc as _;
use empty::Empty;
use glam::DVec3;
use random::Random;
use std::sync::Arc;

const TURNS: u32 = 2;

fn hole(share: f64) -> Spherical {
    Spherical { center: DVec3::new(0.2, -0.1, 0.3), rs: 1.0, charge_squared: 0.25 * share * share }
}

struct Setting {
    hole: Spherical,
    world: World,
    connections: ChargedConnections,
}

impl Setting {
    fn new(share: f64) -> Self {
        let hole = hole(share);
        let world = World::new(Vec::<Geometry>::new(), Box::new(Empty), DVec3::ZERO);
        let world = world.in_spacetime(Arc::new(hole), Conventions::NATURE);
        Self { hole, world, connections: ChargedConnections::new(&hole, Tolerance::DEFAULT, TURNS) }
    }

    /// A place at up to 8 from the middle, down to just outside of the horizon.
    fn place(&self, random: &mut Random) -> Place {
        loop {
            let x = random.vector() * if random.number() > 0.5 { 1.5 } else { 8.0 };
            if (x - self.hole.center).length() > 1.1 * self.hole.horizon() {
                return Place::near(x);
            }
        }
    }

    fn images(&self, x: Place, y: Place) -> Vec<Option<Connection>> {
        (0..TURNS).flat_map(|turn| self.connections.connect(&self.world, x, y, turn)).collect()
    }

    /// Where the ray from `x` along `d` is after the angle `phi`, by series of the areal orbit equation.
    fn after(&self, x: DVec3, d: DVec3, phi: f64) -> Option<DVec3> {
        let (plane, state) = OrbitPlane::of_ray(self.hole.center, x, d);
        let mut orbit = TaylorOrbit::new(Attraction::from(&self.hole), state, 1e-14);
        for _ in 0..10_000 {
            let (step, fate) = orbit.advance();
            if step.end().phi >= phi {
                let there = step.at(phi);
                return (there.u > 0.0).then(|| plane.point(&there));
            }
            if fate != Fate::Underway {
                return None;
            }
        }
        None
    }

    /// Where the ray from `x` along `d` leaves, by Hamilton's equations.
    fn leaves(&self, x: DVec3, d: DVec3) -> Option<DVec3> {
        let reach = Ball { center: DVec3::ZERO, radius: 30.0 };
        let surroundings = Surroundings::new(&self.hole, None, true, reach);
        let mut path = surroundings.start(x, d, Side::Near, 1e-12)?;
        for _ in 0..2000 {
            match path.advance().fate {
                Final::Underway | Final::Crossed => {}
                Final::Escaped(direction) => return Some(direction),
                Final::Captured | Final::Lost => return None,
            }
        }
        None
    }

    /// How near the ray from `x` along `d` comes to `y`, by Hamilton's equations.
    fn nearest(&self, x: DVec3, d: DVec3, y: DVec3) -> f64 {
        let reach = Ball { center: DVec3::ZERO, radius: 30.0 };
        let surroundings = Surroundings::new(&self.hole, None, true, reach);
        let mut path = surroundings.start(x, d, Side::Near, 1e-12).expect("a place");
        let mut nearest = f64::INFINITY;
        for _ in 0..2000 {
            let advance = path.advance();
            let arc = advance.arc;
            let distance = |s: f64| (DVec3::from(arc.point(s)) - y).length();
            // Golden sections.
            let (mut a, mut b) = (arc.start(), arc.end());
            for _ in 0..60 {
                let third = 0.381_966 * (b - a);
                if distance(a + third) < distance(b - third) { b -= third } else { a += third }
            }
            nearest = nearest.min(distance(a));
            if !matches!(advance.fate, Final::Underway) {
                break;
            }
        }
        nearest
    }
}

fn count() -> u32 {
    std::env::var("BHS_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(200)
}

#[test]
fn rays_lead_where_they_should_and_spread_as_they_should() {
    for share in [0.3, 0.9, 1.0] {
        let setting = Setting::new(share);
        let mut random = Random(5);
        let (mut found, mut areas, mut near) = ([0; 2 * TURNS as usize], 0, 0);
        for _ in 0..count() {
            let (x, y) = (setting.place(&mut random), setting.place(&mut random));
            let images = setting.images(x, y);
            let back = setting.images(y, x);
            for (image, c) in images.iter().enumerate() {
                let Some(c) = c else { continue };
                found[image] += 1;
                let distance = (y.x - x.x).length();
                let Some(end) = setting.after(x.x, c.launch, c.phi) else { panic!("{share} {image}: {x:?} {y:?} {c:?}") };
                let aside = |e: DVec3| {
                    let [p, m] = [1e-5, -1e-5].map(|h| {
                        let d = (c.launch + h * e).normalize();
                        // Neighbours in other planes sweep the angle in those.
                        setting.after(x.x, d, c.phi)
                    });
                    Some((p? - m?) / 2e-5)
                };
                let (e, f) = c.launch.any_orthonormal_pair();
                let Some((a, b)) = aside(e).zip(aside(f)) else { continue };
                let stretch = a.length().max(b.length());
                let off = (end - y.x).length();
                assert!(
                    off < 1e-8 * distance + 1e-11 * stretch * (stretch / distance),
                    "{share} {image}: {x:?} {y:?} {off:e} {stretch}"
                );
                if image < 2 {
                    let off = setting.nearest(x.x, c.launch, y.x);
                    assert!(off < 1e-7 * distance + 1e-9 * stretch, "{share} {image}: {x:?} {y:?} {off:e} {stretch}");
                    near += 1;
                }
                if stretch < 100.0 {
                    let area = a.cross(b).dot(c.arrival).abs();
                    assert!((area / c.spread - 1.0).abs() < 1e-5, "{share} {image}: {x:?} {y:?}: {area} {}", c.spread);
                    areas += 1;
                }
                // The same ray backwards: S N^2 is the same, all of it local.
                let same = back.iter().flatten().find(|b| (b.launch + c.arrival).length() < 1e-6);
                if let Some(b) = same.filter(|_| image < 2) {
                    let local = |c: &Connection, x: Place, y: Place| {
                        let [x, y] = [x, y].map(|p| setting.hole.at(p.x).unwrap());
                        let (from, to) = (Observer::at_rest(&x), Observer::at_rest(&y));
                        c.spread * to.bundle_area_factor(c.arrival) / from.solid_angle_factor(c.launch) * x.lapse * x.lapse
                    };
                    let ratio = local(c, x, y) / local(b, y, x);
                    assert!((ratio - 1.0).abs() < 1e-8, "{share} {image}: {x:?} {y:?}: {:e}", ratio - 1.0);
                }
                let traced = setting.connections.spread(&setting.world, x, c.launch, y, c.phi);
                assert_eq!(traced, Some(c.spread), "{share} {image}: {x:?} {y:?}");
                assert_eq!(setting.connections.spread(&setting.world, x, c.launch, y, c.phi + 1.0), None);
            }
        }
        eprintln!("charge {share}: found {found:?} of {}, {areas} areas, {near} against Hamilton", count());
        // Rounding loses some that wind from beside the photon sphere.
        let all = |i: usize| if i < 2 { count() } else { count() - count() / 200 };
        assert!(found.iter().enumerate().all(|(i, n)| *n >= all(i)), "{share}: {found:?}");
    }
}

#[test]
fn rays_to_the_sky_are_found() {
    for share in [0.5, 1.0] {
        let setting = Setting::new(share);
        let mut random = Random(15);
        for _ in 0..count() {
            let (x, sky) = (setting.place(&mut random), (random.vector().normalize(), Side::Near));
            for turn in 0..TURNS {
                for (way, c) in setting.connections.connect_sky(&setting.world, x, sky, turn).into_iter().enumerate() {
                    let c = c.expect("a ray");
                    let spread = setting.connections.spread_sky(&setting.world, x, c.launch, sky, c.phi);
                    assert_eq!(spread, Some(c.spread), "{share} {turn} {way}: {x:?} {sky:?}");
                    let aside = |e: DVec3| {
                        let [p, m] = [1e-5, -1e-5].map(|h| setting.leaves(x.x, (c.launch + h * e).normalize()));
                        Some((p? - m?) / 2e-5)
                    };
                    let (e, f) = c.launch.any_orthonormal_pair();
                    let Some((a, b)) = aside(e).zip(aside(f)).filter(|(a, b)| a.length().max(b.length()) < 30.0) else {
                        continue;
                    };
                    let direction = setting.leaves(x.x, c.launch).expect("the sky");
                    assert!((direction - sky.0).length() < 1e-7, "{share} {turn} {way}: {:e}", (direction - sky.0).length());
                    let area = a.cross(b).dot(sky.0).abs();
                    let within = 1e-5 * c.spread.max(1e-2 * a.length() * b.length());
                    assert!((area - c.spread).abs() < within, "{share} {turn} {way}: {area} {}", c.spread);
                }
            }
        }
    }
}

#[test]
fn without_charge_they_are_those_of_the_plain_hole() {
    let setting = Setting::new(0.0);
    let Spherical { center, rs, .. } = setting.hole;
    let plain = Spherical { center, rs, charge_squared: 0.0 };
    let mut random = Random(25);
    for _ in 0..count() {
        let (x, y) = (setting.place(&mut random), setting.place(&mut random));
        let sky = random.vector().normalize();
        for turn in 0..TURNS {
            let found = setting.connections.connect(&setting.world, x, y, turn).into_iter();
            let to_sky = setting.connections.connect_sky(&setting.world, x, (sky, Side::Near), turn);
            let right = connect_pair(&plain, x.x, y.x, turn).into_iter().chain(connect_sky(&plain, x.x, sky, turn));
            for (found, right) in found.chain(to_sky).zip(right) {
                let (Some(found), Some(right)) = (found, right) else { panic!("{found:?} {right:?}") };
                let off = (found.launch - right.launch).length().max((found.arrival - right.arrival).length());
                let spread = (found.spread / right.spread - 1.0).abs();
                assert!(off < 1e-9 && spread < 2e-6, "{x:?} {y:?} {turn}: {off:e} {spread:e} {found:?} {right:?}");
                assert!((found.phi - right.phi).abs() < 1e-9, "{found:?} {right:?}");
            }
        }
    }
}
