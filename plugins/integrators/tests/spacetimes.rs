//! Rays through worlds in spacetimes other than the plain hole: against `general`, against steps so small that nothing can go wrong, and against
//! quadratures.

#[path = "spacetimes/bounces.rs"]
mod bounces;
#[path = "spacetimes/brute.rs"]
mod brute;
mod common;
#[path = "spacetimes/oracles.rs"]
mod oracles;
#[path = "spacetimes/rooms.rs"]
mod rooms;
#[path = "spacetimes/sights.rs"]
mod sights;
#[path = "spacetimes/thin.rs"]
mod thin;

use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Class, Spacetime, Spherical};
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::{Adaptive, Exact, General, MicroSteps, Rk4, Straight};
use common::{Dice, on_all_processors};
use glam::DVec3;
use rooms::{outcome, ray, spacetimes, trace, world};
use std::ops::AddAssign;
use std::sync::Arc;

const STEPS: u64 = 100_000;

fn adaptive(tolerance: f64, spacetime: &Arc<dyn Spacetime>) -> Box<dyn Integrator> {
    Adaptive::new(Tolerance::Absolute(tolerance), STEPS).build(&**spacetime).expect("it follows all")
}

fn rk4(step: f64, spacetime: &Arc<dyn Spacetime>) -> Box<dyn Integrator> {
    Rk4::new(step, STEPS).build(&**spacetime).expect("it follows these")
}

/// Rays a spacetime; `BHS_GEODESICS` asks for more.
fn count(usual: u64) -> u64 {
    std::env::var("BHS_GEODESICS").ok().and_then(|n| n.parse().ok()).map_or(usual, |n: u64| n.max(usual))
}

#[derive(Clone, Debug, Default)]
struct Tally {
    rays: u64,
    hits: u64,
    far: u64,
    captured: u64,
    lost: u64,
    different: u64,
    off: u64,
    unexplained: u64,
    odd: Vec<String>,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        self.rays += o.rays;
        self.hits += o.hits;
        self.far += o.far;
        self.captured += o.captured;
        self.lost += o.lost;
        self.different += o.different;
        self.unexplained += o.unexplained;
        self.odd.extend(o.odd);
        self.off += o.off;
    }
}

/// Distance that rays are moved aside to see whether they pass an edge (scene units).
const ASIDE: f64 = 2e-5;

/// The ends of some neighbours of `ray` under `integrator`.
fn neighbours(integrator: &dyn Integrator, world: &World, ray: &Ray) -> Vec<Arrival> {
    let mut dice = Dice(7);
    let mut moved = || {
        let direction = (ray.direction + ASIDE * dice.direction()).normalize();
        Ray { origin: ray.origin + ASIDE * dice.direction(), direction, ..*ray }
    };
    (0..24).map(|_| trace(integrator, world, &moved()).0).collect()
}

/// How far the neighbours of `ray`, which ends at `point`, end from there, if they meet the same surface.
fn parting(neighbours: &[Arrival], end: &Arrival, point: DVec3) -> f64 {
    let distance = |arrival: &Arrival| match arrival {
        Arrival::Surface(hit) if outcome(arrival) == outcome(end) => (hit.point - point).length(),
        _ => f64::INFINITY,
    };
    neighbours.iter().map(distance).fold(0.0, f64::max)
}

/// Both ways of following `ray` compared.
fn compare(world: &World, ray: &Ray, tested: &dyn Integrator, oracle: &dyn Integrator, within: f64) -> Tally {
    let (a, b) = (trace(tested, world, ray).0, trace(oracle, world, ray).0);
    let mut tally = Tally { rays: 1, ..Tally::default() };
    match a {
        Arrival::Surface(hit) => {
            assert!(hit.point.is_finite() && (hit.direction.length() - 1.0).abs() < 1e-9, "{hit:?}");
            tally.hits += 1;
            tally.far += u64::from(world.side_of(hit.geometry) != ray.side);
        }
        Arrival::Captured => tally.captured += 1,
        Arrival::OutOfSteps => tally.lost += 1,
        // The rooms are closed.
        Arrival::Sky(..) => panic!("{ray:?} leaks"),
    }
    if outcome(&a) != outcome(&b) {
        tally.different += 1;
        // It passes an edge, or what falls.
        if !neighbours(oracle, world, ray).iter().any(|arrival| outcome(arrival) == outcome(&a)) {
            tally.odd.push(format!("{ray:?}: {a:?}, {b:?}"));
            tally.unexplained += 1;
        }
    } else if let (Arrival::Surface(a_hit), Arrival::Surface(b_hit)) = (&a, &b) {
        let off = (a_hit.point - b_hit.point).length().max((a_hit.direction - b_hit.direction).length());
        if off > within {
            tally.off += 1;
            // Neighbours part where rays wind, and where they graze a surface.
            if off > within + 0.2 * parting(&neighbours(oracle, world, ray), &b, b_hit.point) {
                tally.odd.push(format!("{ray:?}: {a:?}, {b:?}"));
                tally.unexplained += 1;
            }
        }
    }
    tally
}

/// All that `tested` and `oracle` say of random rays in random rooms of each spacetime.
fn compared(
    rays: u64,
    tested: impl Fn(&Arc<dyn Spacetime>) -> Box<dyn Integrator> + Sync,
    oracle: impl Fn(&Arc<dyn Spacetime>) -> Box<dyn Integrator> + Sync,
    within: f64,
) -> Vec<(&'static str, Tally)> {
    const RAYS_A_WORLD: u64 = 25;
    spacetimes()
        .into_iter()
        .map(|(name, spacetime)| {
            let tally = on_all_processors(rays.div_ceil(RAYS_A_WORLD), |number| {
                let mut dice = Dice(1000 + number);
                let world = world(&mut dice, &spacetime);
                let (tested, oracle) = (tested(&spacetime), oracle(&spacetime));
                let mut sum = Tally::default();
                for _ in 0..RAYS_A_WORLD {
                    let ray = ray(&mut dice, &world);
                    sum += compare(&world, &ray, &*tested, &*oracle, within);
                }
                sum
            });
            (name, tally)
        })
        .collect()
}

fn general(tolerance: f64) -> impl Fn(&Arc<dyn Spacetime>) -> Box<dyn Integrator> + Sync {
    move |_| Box::new(General::new(Tolerance::Absolute(tolerance), STEPS))
}

#[test]
fn adaptive_and_general_see_the_same() {
    for (name, tally) in compared(count(300), |s| adaptive(1e-7, s), general(1e-7), 1e-6) {
        assert!(tally.unexplained == 0 && tally.lost == 0, "{name}: {tally:?}");
        assert!((tally.different + tally.off) * 50 <= tally.rays, "{name}: {tally:?}");
        assert!(tally.hits > tally.rays / 2, "{name}: {tally:?}");
        let has_throat = name == "Ellis" || name == "DNEG";
        assert!(
            (tally.far > tally.rays / 50) == has_throat && (tally.captured > tally.rays / 50) != has_throat,
            "{name}: {tally:?}"
        );
    }
}

#[test]
fn fixed_steps_and_general_see_nearly_the_same() {
    for (name, tally) in compared(count(300), |s| rk4(0.01, s), general(1e-6), 1e-4) {
        assert!(tally.lost == 0 && tally.different * 50 <= tally.rays, "{name}: {tally:?}");
        assert!(tally.unexplained * 100 <= tally.rays, "{name}: {tally:?}");
    }
}

#[test]
fn coarse_chords_leak_nowhere() {
    for (name, tally) in compared(count(400), |s| adaptive(3e-2, s), |s| adaptive(1e-4, s), 1e-1) {
        assert!(tally.lost == 0 && tally.different * 5 <= tally.rays, "{name}: {tally:?}");
    }
}

#[test]
fn many_rays_are_as_each_of_them() {
    for (name, spacetime) in spacetimes() {
        let mut dice = Dice(3);
        let world = world(&mut dice, &spacetime);
        let rays: Vec<Ray> = (0..20).map(|_| ray(&mut dice, &world)).collect();
        let integrator = adaptive(1e-4, &spacetime);
        let mut ends = vec![bhs_core::ray::RayEnd::NONE; rays.len()];
        integrator.trace_all(&world, &rays, &mut ends);
        let mut counters = bhs_engine::stats::Counters::default();
        for (ray, end) in rays.iter().zip(&ends) {
            assert_eq!((end.arrival, end.swept), trace(&*integrator, &world, ray), "{name}");
            counters.add_ray(end);
        }
        assert_eq!(counters.geodesics, 20);
        assert!(counters.queries > 0 && counters.steps > 20, "{name}: {:?}", counters);
        assert!(world.clearance.is_none() || counters.leaps > 0, "{name}: {:?}", counters);
    }
}

#[test]
fn polylines_follow_the_ray_to_its_end() {
    for (name, spacetime) in spacetimes() {
        let mut dice = Dice(11);
        let world = world(&mut dice, &spacetime);
        for _ in 0..10 {
            let ray = ray(&mut dice, &world);
            let (end, points) = adaptive(1e-3, &spacetime).polyline(&world, &ray);
            let arrival = end.arrival;
            assert_eq!(points[0], ray.origin);
            assert!(points.iter().all(|p| p.is_finite()));
            if let Arrival::Surface(hit) = arrival {
                assert_eq!(*points.last().expect("there are some"), hit.point, "{name}");
            }
            assert_eq!(arrival, trace(&*adaptive(1e-3, &spacetime), &world, &ray).0, "watching changes nothing");
        }
    }
}

#[test]
fn nothing_that_bends_is_straight() {
    // Without mass to the bit; with next to none, to rounding.
    let none: Arc<dyn Spacetime> =
        Arc::new(bhs_spacetimes::MajumdarPapapetrou::new(&[bhs_spacetimes::Hole { center: rooms::CENTER, mass: 0.0 }]));
    assert!(matches!(none.class(), Class::Flat));
    let tiny: [Arc<dyn Spacetime>; 3] = [
        Arc::new(bhs_spacetimes::MajumdarPapapetrou::new(&[bhs_spacetimes::Hole { center: rooms::CENTER, mass: 1e-14 }])),
        Arc::new(bhs_spacetimes::Ellis { center: rooms::CENTER, throat: 1e-9 }),
        Arc::new(bhs_core::spacetime::Spherical { center: rooms::CENTER, rs: 1e-14, charge_squared: 1e-29 }),
    ];
    let mut dice = Dice(5);
    for _ in 0..8 {
        let world = world(&mut dice, &none);
        for _ in 0..20 {
            let ray = ray(&mut dice, &world);
            let (right, _) = trace(&Straight, &world, &ray);
            let methods: [Box<dyn Integrator>; 4] = [
                adaptive(1e-3, &none),
                rk4(0.1, &none),
                general(1e-3)(&none),
                Exact::new(Tolerance::DEFAULT, STEPS).build(&*none).expect("flat space is no trouble"),
            ];
            for method in methods {
                assert_eq!(trace(&*method, &world, &ray).0, right);
            }
        }
    }
    for spacetime in tiny {
        let world = world(&mut dice, &spacetime);
        for _ in 0..40 {
            let ray = Ray { side: Default::default(), ..ray(&mut dice, &world) };
            let (right, _) = trace(&Straight, &world, &ray);
            for method in [adaptive(1e-3, &spacetime), general(1e-3)(&spacetime)] {
                let (found, _) = trace(&*method, &world, &ray);
                let (Arrival::Surface(a), Arrival::Surface(b)) = (found, right) else {
                    panic!("{spacetime:?}: {found:?} {right:?}")
                };
                assert!((a.point - b.point).length() < 1e-9, "{spacetime:?}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn plain_holes_are_metrics_too() {
    let mut dice = Dice(17);
    let (exact, general) = (Exact::new(Tolerance::Absolute(1e-7), STEPS), General::new(Tolerance::Absolute(1e-7), STEPS));
    let mut sum = Tally::default();
    for _ in 0..4 {
        let hole = Spherical { center: rooms::CENTER, rs: 0.2, charge_squared: 0.0 };
        let world = world(&mut dice, &spacetimes()[3].1).in_spacetime(Arc::new(hole), Conventions::NATURE);
        for _ in 0..20 {
            let ray = ray_around(&mut dice);
            sum += compare(&world, &ray, &general, &exact, 2e-6);
        }
    }
    assert!(sum.unexplained == 0 && sum.different < 3 && sum.hits > 30 && sum.captured > 4, "{sum:?}");
}

/// A ray in the rooms, aimed at what is in their middle.
fn ray_around(dice: &mut Dice) -> Ray {
    let x = rooms::CENTER + dice.direction() * dice.within(0.3, 1.2);
    Ray::new(x, (rooms::CENTER - x + 0.7 * dice.point(1.0)).normalize())
}

#[test]
fn who_cannot_follow_says_what_is_needed() {
    for (name, spacetime) in spacetimes() {
        for method in [&Exact::new(Tolerance::DEFAULT, STEPS) as &dyn IntegratorBuilder, &MicroSteps::new(0.1, STEPS)] {
            let said = method.build(&*spacetime).err().expect(name);
            assert!(said.contains("needs a spherical spacetime without charge"), "{said}");
        }
    }
    let kerr: Arc<dyn Spacetime> = Arc::new(common_kerr::Kerr(0.9));
    let said = Rk4::new(0.1, STEPS).build(&*kerr).err().expect("it has no way");
    assert!(said.contains("refractive index"), "{said}");
    assert!(Adaptive::new(Tolerance::DEFAULT, STEPS).build(&*kerr).is_ok());
}

#[path = "common/kerr.rs"]
#[allow(dead_code, reason = "its formulas are for other tests")]
mod common_kerr;
