//! Rays between two points around a hole that spins, against Hamilton's equations, against the hole without spin and among themselves.

#![allow(clippy::print_stderr, reason = "tests say what they measured")]

#[path = "common/empty.rs"]
mod empty;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "every test file is a crate of its own and uses its part")]
mod random;

use bhs_core::geometry::Geometry;
use bhs_core::observer::Conventions;
use bhs_core::spacetime::{Ball, Kerr, Place, Side, Spacetime, Spherical};
use bhs_engine::connections::{Connection, Connections};
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::arithmetic::root::root;
use bhs_integrators::general::{Fate, Surroundings};
use bhs_integrators::kerr::connections::KerrConnections;
use bhs_integrators::spherical::connect::connect_pair;
use bhs_integrators::spherical::connect::sky::connect_sky;
use bhs_integrators::tracing::arc::Arc as _;
use empty::Empty;
use glam::DVec3;
use random::Random;
use std::sync::Arc;

const CENTER: DVec3 = DVec3::new(0.4, -0.3, 0.7);
const MASS: f64 = 1.3;
const REACH: Ball = Ball { center: CENTER, radius: 120.0 };

fn hole(spin: f64, charge: f64) -> Kerr {
    let round = Spherical { center: CENTER, rs: 2.0 * MASS, charge_squared: (charge * MASS).powi(2) };
    Kerr::new(round, DVec3::new(0.48, 0.6, -0.64), spin)
}

struct Setting {
    world: World,
    spacetime: Arc<dyn Spacetime>,
    connections: KerrConnections,
}

impl Setting {
    fn new(hole: Kerr) -> Self {
        let spacetime: Arc<dyn Spacetime> = Arc::new(hole);
        let world = World::new(Vec::<Geometry>::new(), Box::new(Empty), DVec3::ZERO);
        let world = world.in_spacetime(spacetime.clone(), Conventions::NATURE);
        Self { world, spacetime, connections: KerrConnections { tolerance: Tolerance::DEFAULT } }
    }

    fn images(&self, x: DVec3, y: DVec3) -> [Option<Connection>; 2] {
        self.connections.connect(&self.world, Place::near(x), Place::near(y), 0)
    }

    /// Where the ray from `x` along `d` passes the plane through `y` across `along`, next to `y`: by Hamilton's equations.
    fn passes(&self, x: DVec3, d: DVec3, y: DVec3, along: DVec3) -> Option<DVec3> {
        let surroundings = Surroundings::new(&*self.spacetime, None, true, REACH);
        let mut path = surroundings.start(x, d, Side::Near, 1e-12)?;
        let mut best: Option<DVec3> = None;
        for _ in 0..4000 {
            let advance = path.advance();
            let arc = advance.arc;
            let height = |s: f64| (DVec3::from(arc.point(s)) - y).dot(along);
            for k in 0..4 {
                let at = |k: i32| arc.start() + (arc.end() - arc.start()) * f64::from(k) / 4.0;
                let (a, b) = (at(k), at(k + 1));
                if b > a && height(a) <= 0.0 && height(b) >= 0.0 {
                    let point: DVec3 = arc.point(root(height, a, b, true)).into();
                    if best.is_none_or(|best| point.distance(y) < best.distance(y)) {
                        best = Some(point);
                    }
                }
            }
            if !matches!(advance.fate, Fate::Underway) {
                break;
            }
        }
        best
    }

    /// Where the ray from `x` along `d` leaves, by Hamilton's equations.
    fn leaves(&self, x: DVec3, d: DVec3) -> Option<DVec3> {
        let surroundings = Surroundings::new(&*self.spacetime, None, true, REACH);
        let mut path = surroundings.start(x, d, Side::Near, 1e-12)?;
        for _ in 0..4000 {
            match path.advance().fate {
                Fate::Underway | Fate::Crossed => {}
                Fate::Escaped(direction) => return Some(direction),
                Fate::Captured | Fate::Lost => return None,
            }
        }
        None
    }

    /// `N` times the length of the chart direction `d` as the static observer measures it.
    fn measure(&self, x: DVec3, d: DVec3) -> f64 {
        let here = self.spacetime.at(Place::near(x)).unwrap();
        here.lapse * here.root.apply(d).length()
    }
}

/// A place 4 to 12 masses from the centre.
fn place(random: &mut Random) -> DVec3 {
    let distance = MASS * (8.0 + 4.0 * random.number());
    CENTER + random.vector().normalize() * distance
}

fn count(few: u32) -> u32 {
    std::env::var("BHS_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

/// Area, or solid angle, between the rays beside `launch`, over solid angle: `end` says where they come to.
fn area(launch: DVec3, along: DVec3, end: impl Fn(DVec3) -> Option<DVec3>) -> Option<(f64, f64)> {
    const ASIDE: f64 = 4e-6;
    let (e, f) = launch.any_orthonormal_pair();
    let by = |e: DVec3| Some((end((launch + e * ASIDE).normalize())? - end((launch - e * ASIDE).normalize())?) / (2.0 * ASIDE));
    let (a, b) = (by(e)?, by(f)?);
    Some((a.cross(b).dot(along).abs(), a.length() * b.length()))
}

#[test]
fn rays_arrive_with_the_spread_that_is_said() {
    for (spin, charge) in [(0.5, 0.0), (0.9, 0.0), (-0.9, 0.0), (0.998, 0.0), (0.7, 0.4)] {
        let setting = Setting::new(hole(spin, charge));
        let mut random = Random(77);
        let mut areas = [0; 2];
        for _ in 0..count(25) {
            let (x, y) = (place(&mut random), place(&mut random));
            for (image, c) in setting.images(x, y).iter().enumerate() {
                let Some(c) = c else { continue };
                let distance = x.distance(y);
                let passes = |d: DVec3| setting.passes(x, d, y, c.arrival).filter(|p| p.distance(y) < 0.1 * distance);
                let Some((area, lengths)) = area(c.launch, c.arrival, passes) else { continue };
                // The rounding of a launch moves the ends of some rays further than that.
                let off = passes(c.launch).map_or(f64::INFINITY, |p| p.distance(y));
                assert!(off < 1e-7 * distance + 1e-9 * lengths.sqrt(), "{spin} {image}: {x:?} {y:?}: {off:e} of {distance}");
                if lengths < 1e6 {
                    let error = (area - c.spread).abs();
                    assert!(error < 2e-5 * c.spread.max(1e-2 * lengths), "{spin} {image}: {x:?} {y:?}: {area} {}", c.spread);
                    areas[image] += 1;
                }
            }
        }
        eprintln!("{spin} {charge}: areas {areas:?}");
        assert!(areas[0] > count(25) * 9 / 10 && areas[1] > count(25) / 3, "{spin}: {areas:?}");
    }
}

#[test]
fn light_goes_back_around_the_opposite_spin() {
    for spin in [0.5, 0.9, 0.998] {
        let (setting, back) = (Setting::new(hole(spin, 0.0)), Setting::new(hole(-spin, 0.0)));
        let mut random = Random(5);
        let mut both = [0; 2];
        for _ in 0..count(300) {
            let (x, y) = (place(&mut random), place(&mut random));
            let returning = back.images(y, x);
            for (image, c) in setting.images(x, y).iter().enumerate() {
                let (Some(c), Some(b)) = (c, returning[image]) else { continue };
                if (b.launch + c.arrival).length() > 1e-4 {
                    continue;
                }
                let there = c.spread * setting.measure(x, c.launch).powi(4);
                let again = b.spread * setting.measure(y, c.arrival).powi(4);
                // Next to the line through the centre, where the spread is small, it changes fast.
                let error = (there / again - 1.0).abs();
                assert!(
                    error < 1e-3 && (error < 2e-5 || c.spread < 0.1 * x.distance_squared(y)),
                    "{spin} {image} {x:?} {y:?}: {error:e}"
                );
                assert!((b.launch + c.arrival).length() < 2e-5 && (b.arrival + c.launch).length() < 2e-5);
                both[image] += 1;
            }
        }
        eprintln!("{spin}: both ways {both:?}");
        assert!(both[0] > count(300) * 98 / 100 && both[1] > count(300) / 2, "{spin}: {both:?}");
    }
}

#[test]
fn rays_that_are_traced_by_chance_are_known_exactly_if_they_are_offered() {
    use bhs_integrators::kerr::course::KerrSetup;
    use bhs_integrators::tracing::driver::Course as _;
    for spin in [0.6, -0.95] {
        let hole = hole(spin, 0.0);
        let setting = Setting::new(hole);
        let setup = KerrSetup::around(&hole, true, 60.0, 0.0);
        let mut random = Random(123);
        let (mut offered, mut others) = (0, 0);
        while offered + others < count(400) {
            let (x, d) = (place(&mut random), random.vector().normalize());
            let mut course = setup.by_series::<f64>(x.into(), d.into(), 1e-12);
            if course.begin().0 {
                continue;
            }
            let s = 0.3 + 2.9 * (random.number() + 1.0);
            let mut y = None;
            for _ in 0..200 {
                let next = course.advance(true);
                let piece = course.piece();
                if piece.start() <= s && s <= piece.end() {
                    y = Some(DVec3::from(piece.point(s)));
                    break;
                }
                if next.escapes || next.falls || next.lost {
                    break;
                }
            }
            let Some(y) = y.filter(|y| hole.at(Place::near(*y)).is_some() && y.distance(CENTER) < 20.0 * MASS) else { continue };
            let spread = setting.connections.spread(&setting.world, Place::near(x), d, Place::near(y), s);
            let images = setting.images(x, y);
            let image = images.iter().flatten().find(|c| (c.launch - d).length() < 1e-5 && (c.phi / s - 1.0).abs() < 1e-5);
            match (image, spread) {
                (Some(c), Some(spread)) => {
                    assert_eq!(spread, c.spread, "{spin}: {x:?} {d}");
                    // A ray that has strayed a little is the same one.
                    let aside = (d + d.any_orthonormal_vector() * 1e-8).normalize();
                    assert!(setting.connections.spread(&setting.world, Place::near(x), aside, Place::near(y), s) == Some(spread));
                    offered += 1;
                }
                (None, None) => others += 1,
                _ => panic!("{spin}: {x:?} {d} {s} {y:?}: {image:?} {spread:?} {images:?}"),
            }
        }
        eprintln!("{spin}: {offered} offered, {others} not");
        assert!(offered > 4 * others);
    }
}

#[test]
fn rays_to_the_sky_are_found() {
    for spin in [0.5, 0.95] {
        let setting = Setting::new(hole(spin, 0.0));
        let mut random = Random(9);
        let (mut shares, mut areas) = ([0; 2], 0);
        for k in 0..count(150) {
            let (x, sky) = (place(&mut random), random.vector().normalize());
            let images = setting.connections.connect_sky(&setting.world, Place::near(x), (sky, Side::Near), 0);
            for (image, c) in images.iter().enumerate() {
                let Some(c) = c else { continue };
                shares[image] += 1;
                assert!((c.arrival - sky).length() < 1e-15);
                let spread = setting.connections.spread_sky(&setting.world, Place::near(x), c.launch, (sky, Side::Near), c.phi);
                assert_eq!(spread, Some(c.spread), "{spin} {image}");
                if k >= 20 {
                    continue;
                }
                let Some((area, lengths)) = area(c.launch, sky, |d| setting.leaves(x, d)) else { continue };
                if lengths < 30.0 {
                    let out = setting.leaves(x, c.launch).expect("the sky");
                    assert!((out - sky).length() < 1e-6, "{spin} {image}: {x:?} {sky} {:e}", (out - sky).length());
                    let error = (area - c.spread).abs();
                    assert!(error < 3e-5 * c.spread.max(1e-2 * lengths), "{spin} {image}: {area} {}", c.spread);
                    areas += 1;
                }
            }
        }
        eprintln!("{spin}: of the sky {shares:?}, {areas} solid angles");
        assert!(shares[0] > count(150) * 98 / 100 && shares[1] > count(150) * 9 / 10 && areas > 15, "{shares:?} {areas}");
    }
}

#[test]
fn without_spin_rays_are_those_of_the_plain_hole() {
    let setting = Setting::new(hole(1e-9, 0.0));
    let plain = Spherical { center: CENTER, rs: 2.0 * MASS, charge_squared: 0.0 };
    let mut random = Random(31);
    for _ in 0..count(200) {
        let (x, y) = (place(&mut random), place(&mut random));
        for (image, (c, p)) in setting.images(x, y).iter().zip(connect_pair(&plain, x, y, 0)).enumerate() {
            let (c, p) = (c.expect("a ray"), p.unwrap());
            assert!((c.launch - p.launch).length() < 1e-6 && (c.arrival - p.arrival).length() < 1e-5, "{image} {x:?} {y:?}");
            assert!((c.spread / p.spread - 1.0).abs() < 1e-3, "{image} {x:?} {y:?}: {} {}", c.spread, p.spread);
        }
        let sky = random.vector().normalize();
        let found = setting.connections.connect_sky(&setting.world, Place::near(x), (sky, Side::Near), 0);
        for (c, p) in found.iter().zip(connect_sky(&plain, x, sky, 0)) {
            let (c, p) = (c.expect("a ray"), p.unwrap());
            assert!((c.launch - p.launch).length() < 1e-6 && (c.spread / p.spread - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn without_mass_lines_are_straight() {
    for mass in [1e-6, 1e-12] {
        let round = Spherical { center: CENTER, rs: 2.0 * mass, charge_squared: 0.0 };
        let setting = Setting::new(Kerr::new(round, DVec3::Y, 0.9));
        let mut random = Random(3);
        for _ in 0..40 {
            let (x, y) = (place(&mut random), place(&mut random));
            let way = y - x;
            let c = setting.images(x, y)[0].expect("the straight line");
            let within = 1e-8 + 30.0 * mass;
            assert!(
                (c.launch - way.normalize()).length() < within && (c.arrival - c.launch).length() < 1e-6 + within,
                "{mass} {x} {y}: {:e} {:e}",
                (c.launch - way.normalize()).length(),
                (c.arrival - c.launch).length()
            );
            assert!(
                (c.spread / way.length_squared() - 1.0).abs() < 100.0 * within,
                "{mass}: {}",
                c.spread / way.length_squared() - 1.0
            );
        }
    }
}

#[test]
fn nearly_all_rays_are_found() {
    for (spin, direct, round) in [(0.5, 0.998, 0.99), (0.9, 0.998, 0.93), (0.998, 0.998, 0.87)] {
        let setting = Setting::new(hole(spin, 0.0));
        // Near the hole, and as in a room around it.
        for far in [1.0, 3.0] {
            let mut random = Random(11);
            let mut found = [0; 2];
            for _ in 0..2000 {
                let (x, y) = (place(&mut random), place(&mut random));
                let [x, y] = [x, y].map(|x| CENTER + (x - CENTER) * far);
                for (found, c) in found.iter_mut().zip(setting.images(x, y)) {
                    *found += u32::from(c.is_some());
                }
            }
            let shares = found.map(|found| f64::from(found) / 2000.0);
            eprintln!("{spin}, {far}: found {shares:.4?}");
            assert!(shares[0] > direct && shares[1] > round, "{spin}: {shares:?}");
        }
    }
}

/// Behind the hole, where both rays to the sky leave next to its Einstein ring, which is displaced.
#[test]
fn the_sky_behind_the_hole_is_found() {
    for spin in [0.5, 0.9, -0.9, 0.998] {
        let setting = Setting::new(hole(spin, 0.0));
        let mut random = Random(17);
        let (mut found, few) = ([0; 2], count(400));
        for _ in 0..few {
            let x = place(&mut random);
            let behind = (CENTER - x).normalize();
            let sky = (behind + random.vector().normalize() * (0.1 * random.number().abs())).normalize();
            let images = setting.connections.connect_sky(&setting.world, Place::near(x), (sky, Side::Near), 0);
            for (found, c) in found.iter_mut().zip(&images) {
                *found += u32::from(c.is_some());
            }
            if let [Some(direct), Some(round)] = images {
                assert!(direct.launch.distance(round.launch) > 0.05, "{spin}: {x} {sky}: {direct:?} {round:?}");
            }
        }
        let shares = found.map(|found| f64::from(found) / f64::from(few));
        eprintln!("{spin}: behind the hole {shares:.4?}");
        assert!(shares[0] > 0.94 && shares[1] > 0.96, "{spin}: {shares:?}");
    }
}

#[test]
fn nothing_is_joined_with_itself_or_with_what_cannot_be() {
    let setting = Setting::new(hole(0.9, 0.0));
    let x = CENTER + DVec3::new(6.0, 1.0, -2.0);
    for (a, b) in [(x, x), (x, CENTER), (CENTER + DVec3::new(0.0, 0.1, 0.0), x), (x, CENTER + DVec3::new(0.7, -1.2, 1.0))] {
        let found = setting.images(a, b);
        assert!(found.iter().flatten().all(|c| c.launch.is_finite() && c.spread.is_finite()), "{found:?}");
    }
    assert_eq!(setting.images(x, x), [None; 2]);
    let far = Place { x: x + DVec3::X, side: Side::Far };
    assert_eq!(setting.connections.connect(&setting.world, Place::near(x), far, 0), [None; 2]);
}
