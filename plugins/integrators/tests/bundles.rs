//! The spread of bundles of rays of refractive indices.

#[path = "common/random.rs"]
mod random;

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Class, Spacetime};
use bhs_integrators::graded_index::bundle::Bundle;
use bhs_integrators::graded_index::medium::Medium;
use bhs_integrators::graded_index::path::Paths;
use bhs_integrators::tracing::arc::Arc;
use bhs_spacetimes::{Dneg, Ellis, Hole, MajumdarPapapetrou};
use glam::DVec3;
use random::Random;

const REACH: Ball = Ball { center: DVec3::ZERO, radius: 12.0 };

/// The point where the ray from `x` along `d` is after `sigma` of its parameter, its unit tangent there, spread, and side; `None` if it falls in
/// or leaves before.
fn after(medium: &Medium<'_>, x: DVec3, d: DVec3, far: u32, sigma: f64) -> Option<(DVec3, DVec3, f64, u32)> {
    let mut paths = Paths::<f64>::new(medium, x.into(), d.into(), far, 1e-12, REACH);
    let mut bundle = Bundle::new(medium, &paths.state);
    loop {
        let side = paths.far_side;
        let advance = paths.advance(true);
        if advance.escaped || advance.captured || advance.lost {
            return None;
        }
        let arc = advance.arc;
        if arc.end() >= sigma {
            let (point, tangent) = arc.point_and_tangent(sigma);
            let there = bundle.after(medium, sigma - arc.start());
            assert!((DVec3::from(there.points()) - DVec3::from(point)).length() < 1e-10);
            return Some((point.into(), DVec3::from(tangent).normalize(), there.spread(), side));
        }
        bundle = bundle.after(medium, arc.end() - arc.start());
        if advance.crossed {
            bundle = bundle.through(medium, &medium.throat.expect("it was crossed"), true);
        }
    }
}

/// `within`: relative error of a spread.
fn check(name: &str, spacetime: &dyn Spacetime, within: f64) {
    let Class::Index(index) = spacetime.class() else { panic!("{name}") };
    let medium = Medium::new(index, spacetime.captures());
    let mut random = Random(31);
    let (mut compared, mut crossed) = (0, 0);
    while compared < 60 {
        let (x, d) = random.ray(5.0, spacetime);
        let sigma = 4.0 + 3.0 * random.number();
        let Some((y, t, spread, side)) = after(&medium, x, d, 0, sigma) else { continue };
        // Neighbours, on both sides in both directions.
        const ASIDE: f64 = 1e-5;
        let (e, f) = d.any_orthonormal_pair();
        let [a, b] = [e, f].map(|e| {
            let [p, m] = [ASIDE, -ASIDE].map(|h| after(&medium, x, (d + h * e).normalize(), 0, sigma));
            let ((p, .., s), (m, .., r)) = (p?, m?);
            (s == side && r == side).then(|| (p - m) / (2.0 * ASIDE))
        });
        let (Some(a), Some(b)) = (a, b) else { continue };
        // Where neighbours go entirely different ways, differences say little.
        if a.length().max(b.length()) > 30.0 {
            continue;
        }
        let area = a.cross(b).dot(t).abs();
        // Bundles that shrink to nothing are known as well as their size before.
        let scale = spread.max(1e-3 * a.length() * b.length());
        assert!((area - spread).abs() < within * scale, "{name}: {x} {d} {sigma}: {area} {spread}");
        // The way back spreads by the ratio of the indices.
        let (back, _, again, _) = after(&medium, y, -t, side, sigma).expect("the way back");
        assert!((back - x).length() < 1e-7 * (1.0 + a.length() + b.length()), "{name}: {back} {x}");
        let [nx, ny] = [x, y].map(|x| index.index(x).0);
        let growth = 1.0 + a.length() * b.length() / spread;
        assert!(
            (spread * ny / (again * nx) - 1.0).abs() < 1e-2 * within * growth,
            "{name}: {:e}",
            spread * ny / (again * nx) - 1.0
        );
        compared += 1;
        crossed += side;
    }
    assert!(crossed > 0 || medium.throat.is_none(), "{name}: no bundle goes through the throat");
}

#[test]
fn spreads_are_areas_between_neighbours_and_the_same_both_ways() {
    let three = [(0.0, 0.5, 0.2, 0.5), (1.2, -0.3, 0.0, 0.8), (-0.7, 0.1, -1.0, 0.3)];
    check("holes", &MajumdarPapapetrou::new(&three.map(|(x, y, z, mass)| Hole { center: DVec3::new(x, y, z), mass })), 3e-6);
    check("ellis", &Ellis { center: DVec3::X * 0.2, throat: 2.0 }, 3e-6);
    check("dneg", &Dneg::new(DVec3::ZERO, 2.0, 1.0, 0.3).unwrap(), 3e-6);
}

#[test]
fn without_a_hole_to_speak_of_spreads_are_squares_of_distances() {
    let spacetime = MajumdarPapapetrou::new(&[Hole { center: DVec3::X * 2.0, mass: 1e-12 }]);
    let Class::Index(index) = spacetime.class() else { panic!() };
    let medium = Medium::new(index, spacetime.captures());
    let (_, _, spread, _) = after(&medium, DVec3::ZERO, DVec3::Y, 0, 3.0).unwrap();
    assert!((spread - 9.0).abs() < 1e-9, "{spread}");
}

#[test]
fn eight_bundles_are_as_one_to_the_bit() {
    let spacetime = MajumdarPapapetrou::new(&[1.0, -1.0].map(|z| Hole { center: DVec3::Z * z, mass: 0.5 }));
    let Class::Index(index) = spacetime.class() else { panic!() };
    let medium = Medium::new(index, spacetime.captures());
    let mut random = Random(2);
    let rays: [_; LANES] = std::array::from_fn(|_| random.ray(6.0, &spacetime));
    let (x, d) = (Vector::of(rays.map(|r| r.0)), Vector::of(rays.map(|r| r.1)));
    let paths = Paths::<Lanes>::new(&medium, x, d, 0, Lanes::splat(1e-8), REACH);
    let all = Bundle::new(&medium, &paths.state).after(&medium, Lanes::splat(0.2)).spread().to_array();
    for (i, (x, d)) in rays.into_iter().enumerate() {
        let path = Paths::<f64>::new(&medium, x.into(), d.into(), 0, 1e-8, REACH);
        assert_eq!(Bundle::new(&medium, &path.state).after(&medium, 0.2).spread(), all[i]);
    }
}
