//! Special ways to follow rays against the general one, on random rays.

#[path = "common/random.rs"]
mod random;

use bhs_core::spacetime::{Ball, Class, Side, Spacetime};
use bhs_integrators::general::{Fate, Surroundings};
use bhs_integrators::graded_index::medium::Medium;
use bhs_integrators::graded_index::path::Paths;
use bhs_spacetimes::{Dneg, Ellis, Hole, MajumdarPapapetrou};
use glam::DVec3;
use random::Random;

const REACH: Ball = Ball { center: DVec3::ZERO, radius: 10.0 };

/// Where a ray goes: the sky of a side, or a hole.
type End = Option<(DVec3, Side)>;

/// How many rays a spacetime.
fn rays() -> usize {
    std::env::var("BHS_GEODESICS").map_or(2_000, |n| n.parse().expect("BHS_GEODESICS is a number"))
}

fn general(around: &Surroundings<'_>, x: DVec3, d: DVec3, tolerance: f64) -> End {
    let mut path = around.start(x, d, Side::Near, tolerance).expect("a place");
    for _ in 0..20_000 {
        match path.advance().fate {
            Fate::Underway | Fate::Crossed => {}
            Fate::Escaped(direction) => return Some((direction, path.side)),
            Fate::Captured => return None,
            Fate::Lost => break,
        }
    }
    panic!("no end of the ray from {x} along {d}");
}

fn graded(medium: &Medium<'_>, x: DVec3, d: DVec3, tolerance: f64) -> End {
    let mut path = Paths::<f64>::new(medium, x.into(), d.into(), 0, tolerance, REACH);
    for _ in 0..5_000 {
        let advance = path.advance(true);
        if advance.escaped {
            let (direction, right) = path.directions(true);
            assert!(right, "no direction of the ray from {x} along {d}");
            return Some((direction.into(), path.side(0)));
        }
        if advance.captured {
            return None;
        }
        assert!(!advance.lost, "the ray from {x} along {d} is lost");
    }
    panic!("no end of the ray from {x} along {d}");
}

/// Fails unless `special` and `general` agree on random rays, but for those whose end hangs on how they begin.
fn agree(name: &str, spacetime: &dyn Spacetime, general: impl Fn(DVec3, DVec3) -> End, special: impl Fn(DVec3, DVec3) -> End) {
    let mut random = Random(17);
    let (mut unsteady, count) = (0, rays());
    for _ in 0..count {
        let (x, d) = random.ray(6.0, spacetime);
        let (a, b) = (general(x, d), special(x, d));
        // Where rays go that begin a little aside.
        const ASIDE: f64 = 1e-8;
        let (e, f) = d.any_orthonormal_pair();
        let aside = [e, f].map(|e| special(x, (d + ASIDE * e).normalize()));
        match (a, b, aside) {
            (Some((a, from)), Some((b, to)), [Some((c, third)), Some((d, fourth))])
                if [to, third, fourth].iter().all(|side| *side == from) =>
            {
                let growth = 1.0 + ((c - b).length() + (d - b).length()) / ASIDE;
                assert!((a - b).length() < 1e-9 * growth, "{name}: {x} {d}: {:e}, {growth}", (a - b).length());
            }
            (None, None, _) => {}
            _ => unsteady += 1,
        }
    }
    assert!(unsteady <= 1 + count / 1000, "{name}: {unsteady} of {count} rays end elsewhere");
}

#[test]
fn refractive_indices_agree_with_hamiltons_equations() {
    let three = [(0.0, 0.5, 0.2, 0.5), (1.2, -0.3, 0.0, 0.8), (-0.7, 0.1, -1.0, 0.3)];
    let holes = MajumdarPapapetrou::new(&three.map(|(x, y, z, mass)| Hole { center: DVec3::new(x, y, z), mass }));
    let (ellis, dneg) = (Ellis { center: DVec3::X, throat: 1.0 }, Dneg::new(DVec3::ZERO, 1.0, 0.0, 0.3).unwrap());
    for (name, spacetime) in [("holes", &holes as &dyn Spacetime), ("ellis", &ellis), ("dneg", &dneg)] {
        let Class::Index(index) = spacetime.class() else { panic!("{name}") };
        let medium = Medium::new(index, spacetime.captures());
        let around = Surroundings::new(spacetime, index.throat(), false, REACH);
        agree(name, spacetime, |x, d| general(&around, x, d, 1e-11), |x, d| graded(&medium, x, d, 1e-11));
    }
}
