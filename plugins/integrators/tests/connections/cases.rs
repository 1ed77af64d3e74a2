//! The cases that lie at the edge: antipodes, radii, neighbours, the photon sphere, flat space, nothing.

use crate::tracing::{CENTER, Random, hole, pair};
use bhs_integrators::spherical::connect::{MOST_IMAGES, connect, connect_pair, image_of, join, spread_of, swept_angle};
use glam::DVec3;

#[test]
fn images_of_traced_rays_are_recognized() {
    let hole = hole(0.5);
    let mut random = Random(10);
    for i in 0..20_000 {
        let (r1, r2, theta) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle());
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        let image = i % MOST_IMAGES;
        let c = connect(&hole, x, y, image).unwrap();
        let phi = swept_angle(theta, image) + 1e-3 * (random.next() - 0.5);
        // Within the tolerance of the angle both sides of an antipode are the same, and so is one point's both sides.
        let on_one_side = (x - hole.center).cross(y - hole.center).length() > 1e-9 * r1 * r2;
        if on_one_side {
            assert_eq!(image_of(&hole, x, c.launch, y, phi), image, "r1 {r1} r2 {r2} theta {theta}");
        }
        let spread = spread_of(&hole, x, c.launch, y, phi, MOST_IMAGES).unwrap();
        assert!(
            !on_one_side || (spread / c.spread - 1.0).abs() < 1e-7,
            "r1 {r1} r2 {r2} theta {theta} image {image}: {spread} {}",
            c.spread
        );
    }
    let (x, y) = (hole.center + DVec3::X, hole.center + DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(spread_of(&hole, x, DVec3::NEG_X, y, 30.0, MOST_IMAGES), None);
}

#[test]
fn one_image_and_the_pair_agree() {
    let hole = hole(0.5);
    let mut random = Random(11);
    for _ in 0..20_000 {
        let (r1, r2, theta) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle());
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        for (image, c) in connect_pair(&hole, x, y, 0).into_iter().enumerate() {
            let (c, one) = (c.unwrap(), connect(&hole, x, y, image as u32).unwrap());
            let off = (c.launch - one.launch).length().max((c.arrival - one.arrival).length());
            assert!(
                off < 1e-11 && (c.spread - one.spread).abs() <= 1e-8 * c.spread,
                "r1 {r1} r2 {r2} theta {theta}: {off:.1e} {} {}",
                c.spread,
                one.spread
            );
        }
    }
}

#[test]
fn far_from_a_small_hole_space_is_flat() {
    let mut random = Random(12);
    for rs in [1e-9, 1e-12, 1e-15, 1e-30, 1e-100, 1e-300] {
        let hole = hole(rs);
        for _ in 0..2000 {
            let (x, y) = (CENTER + random.direction() * random.log(0.5, 5.0), CENTER + random.direction() * random.log(0.5, 5.0));
            let c = connect(&hole, x, y, 0).unwrap();
            let way = y - x;
            let near = (x - CENTER).cross(way).length() / way.length();
            // Deflection 2 rs/b; the change of the spread 4 rs x distance / b^2.
            let bend = 4.0 * rs / near + 1e-14;
            assert!((c.launch - way.normalize()).length() < bend && (c.arrival - way.normalize()).length() < bend);
            assert!((c.spread / way.length_squared() - 1.0).abs() < 100.0 * rs / (near * near) + 1e-12, "{rs} {c:?}");
        }
    }
}

#[test]
fn neighbours_see_each_other_along_a_straight_line() {
    let hole = hole(0.5);
    let mut random = Random(13);
    for distance in [1e-2, 1e-4, 1e-6, 1e-9] {
        for _ in 0..2000 {
            let x = CENTER + random.direction() * random.log(0.51, 50.0);
            let y = x + random.direction() * distance;
            let r = (x - CENTER).length();
            let c = connect(&hole, x, y, 0).unwrap();
            let way = y - x;
            let rounding = 1e-14 + 1e-15 * r / distance;
            assert!((c.launch - way.normalize()).length() < 4.0 * distance / r + rounding, "{r} {distance}");
            assert!((c.spread / way.length_squared() - 1.0).abs() < 8.0 * distance / r + rounding, "{r} {distance}");
        }
    }
}

#[test]
fn radial_light_spreads_with_the_radius() {
    let hole = hole(0.5);
    let e = DVec3::new(0.48, -0.6, 0.64);
    let at = |r: f64| CENTER + e * r;
    for (r1, r2) in [(1.0, 3.0), (3.0, 1.0), (0.50005, 0.6), (0.6, 0.50005), (1e5, 0.501)] {
        for tilt in [0.0, 1e-14, 1e-12, 1e-9, 1e-7] {
            let y = at(r2) + e.any_orthonormal_vector() * (tilt * r2);
            let c = connect(&hole, at(r1), y, 0).unwrap();
            let way = e * f64::signum(r2 - r1);
            assert!((c.launch - way).length() < 1e-4 && (c.arrival - way).length() < 1e-4, "{r1} {r2} {tilt}");
            assert!((c.spread / (r2 - r1).powi(2) - 1.0).abs() < 1e-9, "{r1} {r2} {tilt}: {}", c.spread);
        }
        // Round the hole and back to the same radius: a whole circle of directions does.
        let c = connect(&hole, at(r1), at(r2), 1).unwrap();
        assert!(c.spread.abs() < 1e-12 * r1 * r1 && c.launch.is_finite(), "{c:?} {r1} {r2}");
    }
}

#[test]
fn antipodes_are_joined_both_ways_round_with_no_spread() {
    let hole = hole(0.5);
    for (r1, r2) in [(1.0, 3.0), (3.0, 3.0), (0.51, 0.52), (1e4, 2.0), (0.75, 0.75)] {
        let (x, y) = (CENTER + DVec3::X * r1, CENTER - DVec3::X * r2);
        let [a, b] = connect_pair(&hole, x, y, 0).map(|c| c.unwrap());
        assert!(
            a.spread < 1e-11 * (r1 + r2) * (r1 + r2) && b.spread < 1e-11 * (r1 + r2) * (r1 + r2),
            "{} {}",
            a.spread,
            b.spread
        );
        let mirrored = a.launch * DVec3::new(1.0, -1.0, -1.0);
        assert!((mirrored - b.launch).length() < 1e-9, "{:?} {:?}", a.launch, b.launch);
        // Near the antipode the spread falls linearly.
        let near = |t: f64| connect(&hole, x, CENTER + DVec3::new(-t.cos(), t.sin(), 0.0) * r2, 0).unwrap().spread;
        assert!((near(1e-6) / near(2e-6) - 0.5).abs() < 1e-3, "{r1} {r2}");
    }
}

#[test]
fn light_on_the_photon_sphere_stays_there() {
    let hole = hole(0.5);
    let mut random = Random(14);
    for _ in 0..200 {
        let theta = 0.01 + 3.1 * random.next();
        let (x, y) = pair(&mut random, hole.center, 0.75, 0.75, theta);
        for image in 0..4 {
            let c = connect(&hole, x, y, image).unwrap();
            assert!(
                c.launch.dot((x - CENTER).normalize()).abs() < 1e-12 && c.arrival.dot((y - CENTER).normalize()).abs() < 1e-12
            );
            // U - 2/3 grows like sinh: s = sinh(Phi).
            let phi = swept_angle(theta, image);
            let expected = 0.75 * 0.75 * phi.sinh() * theta.sin();
            assert!((c.spread / expected - 1.0).abs() < 1e-6, "{theta} {image}: {} {expected}", c.spread);
        }
    }
}

#[test]
fn what_is_not_there_is_none() {
    let hole = hole(0.5);
    let out = CENTER + DVec3::new(2.0, 1.0, 0.0);
    for image in 0..3 {
        for bad in [CENTER, CENTER + DVec3::X * 0.5, CENTER + DVec3::Y * 0.3, DVec3::NAN, DVec3::INFINITY] {
            assert_eq!(connect(&hole, bad, out, image), None);
            assert_eq!(connect(&hole, out, bad, image), None);
        }
    }
    assert_eq!(connect(&hole, out, out, 0), None);
    assert_eq!(connect(&hole, out, out + DVec3::Z, MOST_IMAGES), None);
    assert_eq!(connect_pair(&hole, CENTER, out, 0), [None, None]);
    assert_eq!(join(0.5, 0.5, 1.0, 1.0, 0), None);
    assert_eq!(join(0.5, 1.0, 2.0, f64::NAN, 0), None);
}
