//! Rays between two points of spacetimes of a refractive index, against Hamilton's equations and among themselves.

#![allow(clippy::print_stderr, reason = "tests say what they measured")]

#[path = "common/empty.rs"]
mod empty;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "every test file is a crate of its own and uses its part")]
mod random;

use bhs_core::geometry::Geometry;
use bhs_core::observer::Conventions;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Class, GradedIndex, Place, Side, Spacetime};
use bhs_engine::connections::{Connection, Connections};
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::arithmetic::root::root;
use bhs_integrators::general::{Fate, Surroundings};
use bhs_integrators::graded_index::connect::GradedConnections;
use bhs_integrators::graded_index::medium::Medium;
use bhs_integrators::graded_index::path::Paths;
use bhs_integrators::tracing::arc::Arc as _;
use bhs_spacetimes::{Dneg, Ellis, Hole, MajumdarPapapetrou};
use empty::Empty;
use glam::DVec3;
use random::Random;
use std::sync::Arc;

const REACH: Ball = Ball { center: DVec3::ZERO, radius: 30.0 };

struct Setting {
    name: &'static str,
    world: World,
    connections: GradedConnections,
    spacetime: Arc<dyn Spacetime>,
}

impl Setting {
    fn new(name: &'static str, spacetime: impl Spacetime + 'static) -> Self {
        let spacetime: Arc<dyn Spacetime> = Arc::new(spacetime);
        let connections = GradedConnections::new(&*spacetime, Tolerance::DEFAULT, 1).unwrap();
        let world = World::new(Vec::<Geometry>::new(), Box::new(Empty), DVec3::ZERO);
        let world = world.in_spacetime(spacetime.clone(), Conventions::NATURE);
        Self { name, world, connections, spacetime }
    }

    fn index(&self) -> &dyn GradedIndex {
        let Class::Index(index) = self.spacetime.class() else { panic!("{}", self.name) };
        index
    }

    fn images(&self, x: Place, y: Place) -> Vec<Option<Connection>> {
        (0..self.connections.turns()).flat_map(|turn| self.connections.connect(&self.world, x, y, turn)).collect()
    }

    /// A place 1 to 8 from the middle, on either side if there are two.
    fn place(&self, random: &mut Random) -> Place {
        loop {
            let x = random.vector() * 8.0;
            let side = if self.spacetime.has_far_side() && random.number() > 0.0 { Side::Far } else { Side::Near };
            let place = Place { x, side };
            let is_far_from_holes = self.spacetime.captures().iter().all(|b| (x - b.center).length() > 1.5 * b.radius);
            if x.length() > 1.0 && is_far_from_holes && self.spacetime.at(place).is_some() {
                return place;
            }
        }
    }

    /// How near the ray from `x` along `d` comes to `y`, by Hamilton's equations.
    fn nearest(&self, x: Place, d: DVec3, y: Place) -> f64 {
        let surroundings = Surroundings::new(&*self.spacetime, self.index().throat(), true, REACH);
        let mut path = surroundings.start(x.x, d, x.side, 1e-12).expect("a place");
        let mut nearest = f64::INFINITY;
        for _ in 0..2000 {
            let side = path.side;
            let advance = path.advance();
            let arc = advance.arc;
            if side == y.side && arc.end() > arc.start() {
                let rising = |s: f64| (DVec3::from(arc.point(s)) - y.x).dot(arc.tangent(s).into());
                let parts = 8;
                let at = |k: i32| arc.start() + (arc.end() - arc.start()) * f64::from(k) / f64::from(parts);
                for k in 0..parts {
                    let (a, b) = (at(k), at(k + 1));
                    if rising(a) <= 0.0 && rising(b) >= 0.0 {
                        let s = root(rising, a, b, true);
                        nearest = nearest.min((DVec3::from(arc.point(s)) - y.x).length());
                    }
                }
            }
            if !matches!(advance.fate, Fate::Underway | Fate::Crossed) {
                break;
            }
        }
        nearest
    }

    /// Where the ray from `x` along `d` is at its parameter `sigma`.
    fn after(&self, x: Place, d: DVec3, sigma: f64) -> Option<Place> {
        let medium = Medium::new(self.index(), self.spacetime.captures());
        let far = u32::from(x.side == Side::Far);
        let mut paths = Paths::<f64>::new(&medium, x.x.into(), d.into(), far, 1e-13, REACH);
        for _ in 0..2000 {
            let side = paths.side(0);
            let advance = paths.advance(true);
            if advance.escaped || advance.lost || advance.captured {
                return None;
            }
            if advance.arc.end() >= sigma {
                let x: Vector<f64> = advance.arc.point(sigma);
                return Some(Place { x: x.into(), side });
            }
        }
        None
    }

    /// Where neighbours end, by differences of rays: derivatives by two angles of the launch.
    fn neighbours(&self, x: Place, c: &Connection) -> Option<[DVec3; 2]> {
        const ASIDE: f64 = 1e-5;
        let (e, f) = c.launch.any_orthonormal_pair();
        let [a, b] = [e, f].map(|e| {
            let [p, m] = [ASIDE, -ASIDE].map(|h| self.after(x, (c.launch + h * e).normalize(), c.phi));
            let (p, m) = (p?, m?);
            (p.side == m.side).then(|| (p.x - m.x) / (2.0 * ASIDE))
        });
        Some([a?, b?])
    }

    fn n(&self, x: Place) -> f64 {
        self.index().index(x.x).0.sqrt()
    }

    /// Holds `count` pairs of places to all that is promised; which share of each image is found. `reciprocal`: relative error of spreads of the two ways.
    fn check(&self, count: u32, reciprocal: f64) -> Vec<f64> {
        let name = self.name;
        let mut random = Random(77);
        let mut found = vec![0; 2 * self.connections.turns() as usize];
        let (mut areas, mut both_ways) = (0, 0);
        for _ in 0..count {
            let (x, y) = (self.place(&mut random), self.place(&mut random));
            let images = self.images(x, y);
            let back = self.images(y, x);
            for (image, c) in images.iter().enumerate() {
                let Some(c) = c else { continue };
                found[image] += 1;
                let distance = if x.side == y.side { (y.x - x.x).length() } else { x.x.length() + y.x.length() };
                let off = self.nearest(x, c.launch, y);
                let neighbours = self.neighbours(x, c);
                let stretch = neighbours.map_or(0.0, |[a, b]| a.length().max(b.length()));
                // The rounding of the launch alone moves the ends of some rays further than that.
                let within = 1e-8 * distance + 1e-11 * stretch * (stretch / distance);
                assert!(off < within, "{name} {image}: {x:?} {y:?}: {:e}, {stretch}", off / distance);
                if let Some([a, b]) = neighbours.filter(|_| stretch < 100.0) {
                    let area = a.cross(b).dot(c.arrival).abs();
                    assert!((area / c.spread - 1.0).abs() < 1e-5, "{name} {image}: {x:?} {y:?}: {area} {}", c.spread);
                    areas += 1;
                }
                let same = back.iter().flatten().find(|b| (b.launch + c.arrival).length() < 1e-6);
                if let Some(b) = same {
                    let ratio = c.spread * self.n(y).powi(2) / (b.spread * self.n(x).powi(2));
                    assert!((ratio - 1.0).abs() < reciprocal, "{name} {image}: {x:?} {y:?}: {:e}", ratio - 1.0);
                    both_ways += 1;
                }
                // Rays traced by chance go the same way and end almost there.
                let astray = |v: DVec3, by: f64| v + random_unit(c.spread) * (by * v.length());
                let spread = self.connections.spread(&self.world, x, astray(c.launch, 1e-9).normalize(), y, c.phi * (1.0 + 1e-6));
                assert_eq!(spread, Some(c.spread), "{name} {image}: {x:?} {y:?}");
                // Even where they have strayed further.
                let spread = self.connections.spread(&self.world, x, c.launch, y, c.phi + 0.05 * distance / self.n(y));
                assert_eq!(spread, Some(c.spread), "{name} {image}: {x:?} {y:?}");
                let other = (c.launch + c.launch.any_orthonormal_vector() * 0.4).normalize();
                let none = self.connections.spread(&self.world, x, other, y, c.phi);
                let is_one = images.iter().flatten().any(|c| c.launch.dot(other) > 0.94);
                assert!(is_one || none.is_none(), "{name} {image}: {x:?} {y:?}");
            }
            for (i, a) in images.iter().enumerate() {
                assert!(
                    images[..i].iter().flatten().all(|b| a.is_none_or(|a| (a.launch - b.launch).length() > 1e-4)),
                    "{name}: twice"
                );
            }
        }
        let shares: Vec<f64> = found.iter().map(|found| f64::from(*found) / f64::from(count)).collect();
        eprintln!("{name}: found {shares:.3?}, {areas} areas, {both_ways} both ways, of {count}");
        assert!(areas > count / 2 && both_ways > count / 2, "{name}");
        shares
    }
}

/// Rays that are traced by chance are known exactly if connections offer them.
fn by_chance(setting: &Setting, count: u32) {
    let name = setting.name;
    let mut random = Random(123);
    let (mut offered, mut others) = (0, 0);
    while offered + others < count {
        let (x, d) = (setting.place(&mut random), random.vector().normalize());
        let sigma = 12.0 + 11.0 * random.number();
        let Some(y) = setting.after(x, d, sigma) else { continue };
        // Rays bend where it is not far.
        if y.x.length() > 9.0 {
            continue;
        }
        let images = setting.images(x, y);
        let spread = setting.connections.spread(&setting.world, x, d, y, sigma);
        let image = images.iter().flatten().find(|c| (c.launch - d).length() < 1e-5 && (c.phi / sigma - 1.0).abs() < 1e-5);
        match (image, spread) {
            (Some(c), Some(spread)) => {
                assert!((spread / c.spread - 1.0).abs() < 1e-9, "{name}: {x:?} {d}: {spread} {}", c.spread);
                offered += 1;
            }
            (None, None) => others += 1,
            _ => panic!("{name}: {x:?} {d} {sigma} {y:?}: {image:?} {spread:?} {images:?}"),
        }
    }
    eprintln!("{name}: {offered} of {count} rays that are traced by chance are offered");
    assert!(offered > count / 2, "{name}");
}

impl Setting {
    /// Where the ray from `x` along `d` leaves, by Hamilton's equations.
    fn leaves(&self, x: Place, d: DVec3) -> Option<(DVec3, Side)> {
        let surroundings = Surroundings::new(&*self.spacetime, self.index().throat(), true, REACH);
        let mut path = surroundings.start(x.x, d, x.side, 1e-12)?;
        for _ in 0..2000 {
            match path.advance().fate {
                Fate::Underway | Fate::Crossed => {}
                Fate::Escaped(direction) => return Some((direction, path.side)),
                Fate::Captured | Fate::Lost => return None,
            }
        }
        None
    }
}

fn sky(setting: &Setting, count: u32) -> Vec<f64> {
    let name = setting.name;
    let mut random = Random(9);
    let turns = setting.connections.turns();
    let mut shares = vec![0; 2 * turns as usize];
    let mut offered = 0;
    for _ in 0..count {
        let (x, at) = (setting.place(&mut random), random.vector().normalize());
        let side = setting.place(&mut random).side;
        let find = |sky| (0..turns).flat_map(|turn| setting.connections.connect_sky(&setting.world, x, sky, turn)).collect();
        let images: Vec<Option<Connection>> = find((at, side));
        for (image, c) in images.iter().enumerate() {
            let Some(c) = c else { continue };
            shares[image] += 1;
            let (direction, on) = setting.leaves(x, c.launch).expect("the sky");
            assert!(on == side && (direction - at).length() < 1e-7, "{name} {image}: {x:?} {at} {:e}", (direction - at).length());
            // Solid angle between neighbours.
            let (e, f) = c.launch.any_orthonormal_pair();
            let aside = |e: DVec3| {
                // The directions have errors of 1e-10 where the index has a break.
                let [p, m] = [5e-5, -5e-5].map(|h| setting.leaves(x, (c.launch + h * e).normalize()));
                let ((p, s), (m, r)) = (p?, m?);
                (s == r).then(|| (p - m) / 1e-4)
            };
            if let (Some(a), Some(b)) = (aside(e), aside(f))
                && a.length().max(b.length()) < 30.0
            {
                let area = a.cross(b).dot(at).abs();
                assert!(
                    (area - c.spread).abs() < 1e-5 * c.spread.max(1e-2 * a.length() * b.length()),
                    "{name}: {area} {}",
                    c.spread
                );
            }
            let spread = setting.connections.spread_sky(&setting.world, x, c.launch, (at, side), c.phi);
            assert_eq!(spread, Some(c.spread), "{name} {image}");
        }
        // A ray that leaves by chance.
        let d = random.vector().normalize();
        let Some(out) = setting.leaves(x, d) else { continue };
        let images: Vec<Option<Connection>> = find(out);
        let image = images.iter().flatten().find(|c| (c.launch - d).length() < 1e-5);
        let spread = setting.connections.spread_sky(&setting.world, x, d, out, 1.0);
        assert_eq!(image.is_some(), spread.is_some(), "{name}: {x:?} {d} {out:?} {images:?}");
        offered += u32::from(spread.is_some());
    }
    let shares: Vec<f64> = shares.iter().map(|found| f64::from(*found) / f64::from(count)).collect();
    eprintln!("{name}: of the sky {shares:.3?}, {offered} rays that leave by chance are offered, of {count}");
    shares
}

#[test]
fn rays_to_the_sky_are_found() {
    let ellis = Setting::new("ellis", Ellis { center: DVec3::X * 0.2, throat: 1.0 });
    let dneg = Setting::new("dneg", Dneg::new(DVec3::Y * 0.1, 1.0, 1.0, 0.3).unwrap());
    let one = Setting::new("one hole", holes(&[(0.1, 0.2, -0.1, 0.7)]));
    let two = Setting::new("two holes", holes(&[(0.0, 0.0, 1.0, 0.5), (0.0, 0.0, -1.0, 0.5)]));
    for setting in [ellis, dneg, one] {
        let shares = sky(&setting, count());
        assert!(shares.iter().all(|share| *share >= 0.99), "{shares:?}");
    }
    assert!(sky(&two, count())[0] > 0.9);
}

#[test]
fn rays_that_are_traced_by_chance_are_known_exactly_if_they_are_offered() {
    let ellis = Setting::new("ellis", Ellis { center: DVec3::X * 0.2, throat: 1.0 });
    let dneg = Setting::new("dneg", Dneg::new(DVec3::Y * 0.1, 1.0, 1.0, 0.3).unwrap());
    let one = Setting::new("one hole", holes(&[(0.1, 0.2, -0.1, 0.7)]));
    let two = Setting::new("two holes", holes(&[(0.0, 0.0, 1.0, 0.5), (0.0, 0.0, -1.0, 0.5)]));
    let wide = Setting::new("two holes far apart", holes(&[(0.0, 0.0, 3.0, 0.5), (0.0, 0.0, -3.0, 0.5)]));
    for setting in [ellis, dneg, one, two, wide] {
        by_chance(&setting, 4 * count());
    }
}

/// A unit vector that depends on `seed` alone.
fn random_unit(seed: f64) -> DVec3 {
    Random(seed.to_bits()).vector().normalize()
}

fn holes(of: &[(f64, f64, f64, f64)]) -> MajumdarPapapetrou {
    let of: Vec<_> = of.iter().map(|&(x, y, z, mass)| Hole { center: DVec3::new(x, y, z), mass }).collect();
    MajumdarPapapetrou::new(&of)
}

fn count() -> u32 {
    std::env::var("BHS_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(60)
}

#[test]
fn rays_around_wormholes_are_found() {
    for (setting, reciprocal) in [
        (Setting::new("ellis", Ellis { center: DVec3::X * 0.2, throat: 1.0 }), 1e-8),
        (Setting::new("dneg", Dneg::new(DVec3::Y * 0.1, 1.0, 1.0, 0.3).unwrap()), 1e-8),
        // Its rays spread by far the most.
        (Setting::new("dneg, long and sharp", Dneg::new(DVec3::ZERO, 0.8, 3.0, 0.05).unwrap()), 1e-6),
    ] {
        let shares = setting.check(count(), reciprocal);
        assert!(shares.iter().all(|share| *share >= 0.99), "{}: {shares:?}", setting.name);
    }
}

#[test]
fn rays_around_one_hole_are_found() {
    let setting = Setting::new("one hole", holes(&[(0.1, 0.2, -0.1, 0.7)]));
    let shares = setting.check(count(), 1e-8);
    assert!(shares.iter().all(|share| *share >= 0.99), "{shares:?}");
}

#[test]
fn rays_among_holes_are_found() {
    let two = Setting::new("two holes", holes(&[(0.0, 0.0, 1.0, 0.5), (0.0, 0.0, -1.0, 0.5)]));
    let shares = two.check(count(), 1e-7);
    assert!(shares[0] > 0.9, "{shares:?}");
    let three = Setting::new("three holes", holes(&[(0.0, 0.5, 0.2, 0.5), (1.2, -0.3, 0.0, 0.8), (-0.7, 0.1, -1.0, 0.3)]));
    let shares = three.check(count(), 1e-7);
    assert!(shares[0] > 0.9, "{shares:?}");
}

#[test]
fn without_holes_to_speak_of_lines_are_straight() {
    let mut random = Random(3);
    for of in [vec![(0.3, 0.0, 0.0, 1e-13)], vec![(0.3, 0.0, 0.0, 1e-13), (-0.3, 0.2, 0.0, 1e-13)]] {
        let setting = Setting::new("no mass", holes(&of));
        for _ in 0..40 {
            let (x, y) = (setting.place(&mut random), setting.place(&mut random));
            let way = y.x - x.x;
            let c = setting.images(x, y)[0].expect("the straight line");
            assert!((c.launch - way.normalize()).length() < 1e-10 && (c.arrival - c.launch).length() < 1e-10);
            assert!((c.spread / way.length_squared() - 1.0).abs() < 1e-9 && (c.phi / way.length() - 1.0).abs() < 1e-9);
        }
    }
}
