//! Connections against orbits that are integrated independently of them: a Taylor series of order 30 in the swept angle.
//! `BHS_CONNECTION_PAIRS=1000000` sets the number of random pairs (200,000).

#[path = "connections/cases.rs"]
mod cases;
#[path = "connections/tracing.rs"]
mod tracing;

use bhs_core::observer::Conventions;
use bhs_core::spacetime::Spherical;
use bhs_engine::connections::Connection;
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::orbit::{OrbitPlane, State};
use bhs_integrators::spherical::connect::{MOST_IMAGES, connect, connect_pair, connect_pairs, join, swept_angle};
use glam::DVec3;
use std::f64::consts::PI;
use tracing::{ROUNDING, Random, follow, hole, pair, spread_in_space, trace};

#[test]
fn launch_directions_lead_to_the_other_point() {
    let n = std::env::var("BHS_CONNECTION_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(200_000);
    let mut random = Random(4);
    let (mut worst, mut worst_turn, mut beyond) = ([0.0f64; 2], 0.0f64, 0);
    for _ in 0..n {
        let rs = random.log(1e-3, 1e3);
        let hole = Spherical { center: DVec3::ZERO, ..hole(rs) };
        let (r1, r2, theta) = (rs * random.radius(), rs * random.radius(), random.angle());
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        let both = connect_pair(&hole, x, y, 0);
        for image in 0..2 {
            let Some(c) = both[image as usize] else { panic!("image {image} missing: r1 {r1} r2 {r2} theta {theta} rs {rs}") };
            let off_unit = (c.launch.length() - 1.0).abs().max((c.arrival.length() - 1.0).abs());
            assert!(off_unit < 1e-14, "image {image}: {off_unit:.1e}: r1 {r1} r2 {r2} theta {theta} rs {rs}");
            let f = trace(&hole, x, y, &c, image);
            let scale = r1.max(r2);
            let allowed = 1e-9 * scale + ROUNDING * f.sensitivity;
            assert!(f.miss <= allowed, "image {image}: misses by {:.1e}: r1 {r1} r2 {r2} theta {theta} rs {rs}", f.miss / scale);
            worst[image as usize] = worst[image as usize].max(f.miss / scale);
            beyond += u32::from(f.miss > 1e-9 * scale);
            let turn = f.turn / (1.0 + f.sensitivity / r2);
            assert!(turn < 1e-9, "image {image}: turns by {:.1e}: r1 {r1} r2 {r2} theta {theta} rs {rs}", f.turn);
            worst_turn = worst_turn.max(turn);
        }
    }
    eprintln!(
        "{n} pairs: worst miss {:.1e} (image 0), {:.1e} (image 1) of the larger distance, {beyond} beyond 1e-9; worst turn {worst_turn:.1e}",
        worst[0], worst[1]
    );
}

#[test]
fn several_pairs_have_the_connections_of_each() {
    let hole = hole(0.5);
    let mut random = Random(21);
    for count in 0..40 {
        let mut pairs: Vec<[DVec3; 2]> = (0..count)
            .map(|_| {
                let (r1, r2, theta) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle());
                pair(&mut random, hole.center, r1, r2, theta).into()
            })
            .collect();
        // Among them some that nothing joins, and one along the radius.
        for (i, odd) in pairs.iter_mut().enumerate().skip(count % 7).step_by(5) {
            odd[i % 2] = hole.center + DVec3::X * 0.3;
        }
        if let Some([x, y]) = pairs.last_mut() {
            *y = hole.center + (*x - hole.center) * 2.0;
        }
        let places: Vec<_> = pairs.iter().map(|pair| pair.map(bhs_core::spacetime::Place::near)).collect();
        for turn in 0..2 {
            let mut found = vec![[None; 2]; count];
            connect_pairs(&hole, &places, turn, &mut found);
            for ([x, y], found) in pairs.iter().zip(found) {
                assert_eq!(found, connect_pair(&hole, *x, *y, turn), "{x} {y}");
            }
        }
    }
}

#[test]
fn the_exact_integrator_follows_them_to_the_other_point() {
    let hole = hole(0.5);
    let mut random = Random(15);
    let mut worst = 0.0f64;
    for i in 0..100_000 {
        let (r1, r2, theta, image) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle(), i % 2);
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        let c = connect(&hole, x, y, image).unwrap();
        let (plane, start) = OrbitPlane::of_ray(hole.center, x, c.launch);
        let phi = swept_angle(theta, image);
        let (u, du) = ClosedForm::new(hole.rs, start.u, start.du).at(phi);
        let end = State { phi, u, du };
        let gap = y - plane.point(&end);
        let tangent = plane.direction(&end);
        let miss = (gap - tangent * gap.dot(tangent)).length();
        let f = trace(&hole, x, y, &c, image);
        assert!(miss <= 1e-9 * r1.max(r2) + ROUNDING * f.sensitivity, "r1 {r1} r2 {r2} theta {theta} image {image}: {miss:.1e}");
        worst = worst.max(miss / r1.max(r2));
    }
    eprintln!("worst miss by the exact orbit {worst:.1e} of the larger distance");
}

#[test]
fn more_windings_are_found_too() {
    let hole = hole(0.5);
    let mut random = Random(5);
    let mut worst = [0.0f64; MOST_IMAGES as usize];
    for _ in 0..20_000 {
        let (r1, r2, theta) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle());
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        for image in 0..MOST_IMAGES {
            // Each winding costs almost three digits.
            let tolerance = [1e-9, 1e-9, 1e-9, 1e-7, 1e-7, 1e-5][image as usize];
            let c = connect(&hole, x, y, image).unwrap_or_else(|| panic!("image {image} missing: r1 {r1} r2 {r2} theta {theta}"));
            if image >= 2 {
                let f = trace(&hole, x, y, &c, image);
                let relative = f.miss / (tolerance * r1.max(r2) + 8.0 * ROUNDING * f.sensitivity);
                worst[image as usize] = worst[image as usize].max(relative);
            }
        }
    }
    eprintln!("worst miss, in units of what is allowed: {worst:.2?}");
    assert!(worst.iter().all(|w| *w < 1.0), "{worst:.2?}");
}

#[test]
fn spreads_are_those_of_neighbouring_rays() {
    let mut random = Random(6);
    let (mut worst, mut worst_variational) = (0.0f64, 0.0f64);
    for i in 0..20_000 {
        let (r1, r2, theta, image) = (random.radius(), random.radius(), random.angle(), i % 4);
        let arc = join(1.0, r1, r2, theta, image).unwrap();
        let (u1, swept) = (1.0 / r1, swept_angle(theta, image));
        let v1 = -u1 * arc.launch.x / arc.launch.y;
        let across = (r2 * theta.sin() / arc.launch.y).abs();
        let spread = |ds_dv: f64| r2 * r2 * ds_dv * u1 / (arc.launch.y * arc.launch.y) * arc.arrival.y * across;
        let centre = follow(u1, v1, swept);
        let variational = (arc.spread / spread(centre.s) - 1.0).abs();
        // A step that moves U at the end by some 1e-5 of what it varies over.
        let h = 1e-5 * v1.hypot(u1) / (1.0 + centre.s);
        let difference = (follow(u1, v1 + h, swept).u - follow(u1, v1 - h, swept).u) / (2.0 * h);
        let error = (arc.spread / spread(difference) - 1.0).abs();
        assert!(error < 1e-5, "r1 {r1} r2 {r2} theta {theta} image {image}: {error:.1e}, variational {variational:.1e}");
        worst = worst.max(error);
        worst_variational = worst_variational.max(variational);
    }
    eprintln!("worst spread error {worst:.1e} by differences, {worst_variational:.1e} by the variational orbit");
    assert!(worst_variational < 1e-6);
}

#[test]
fn spreads_are_areas_between_rays_in_space() {
    let hole = hole(0.5);
    let mut random = Random(7);
    let mut worst = 0.0f64;
    for i in 0..4000 {
        let mut radius = || hole.rs * random.log(1.05, 50.0);
        let (r1, r2) = (radius(), radius());
        let theta = 0.05 + (PI - 0.1) * random.next();
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        let image = i % 2;
        let c = connect(&hole, x, y, image).unwrap();
        let error = (spread_in_space(&hole, x, y, &c, image, 2e-7) / c.spread - 1.0).abs();
        assert!(error < 1e-5, "r1 {r1} r2 {r2} theta {theta} image {image}: {error:.1e}");
        worst = worst.max(error);
    }
    eprintln!("worst spread error in space {worst:.1e}");
}

#[test]
fn etendue_is_the_same_at_both_ends() {
    let hole = hole(0.5);
    let mut random = Random(8);
    let mut worst = 0.0f64;
    // Local area across the bundle at y per local solid angle at x, times f(x).
    let etendue = |x: DVec3, y: DVec3, c: &Connection| {
        let observer = |x| Conventions::NATURE.observer(&hole.at(x).expect("outside"));
        let (at_x, at_y) = (observer(x), observer(y).frame);
        let cos = at_y.local_normal(c.arrival).dot(at_y.local_direction(c.arrival));
        let area = c.spread * at_y.area_factor(c.arrival) * cos;
        area / at_x.solid_angle_factor(c.launch) * at_x.clock_rate() * at_x.clock_rate()
    };
    for i in 0..100_000 {
        let (r1, r2, theta) = (hole.rs * random.radius(), hole.rs * random.radius(), random.angle());
        let (x, y) = pair(&mut random, hole.center, r1, r2, theta);
        let image = i % 4;
        let (there, back) = (connect(&hole, x, y, image).unwrap(), connect(&hole, y, x, image).unwrap());
        let ratio = etendue(x, y, &there) / etendue(y, x, &back);
        // One rounding of r moves f by that much near the horizon, and of a point moves sin(theta).
        let rounding = 1e-15 * (1.0 / (1.0 - hole.rs / r1.min(r2)) + 1.0 / theta.sin());
        assert!((ratio - 1.0).abs() < 1e-9 + rounding, "r1 {r1} r2 {r2} theta {theta} image {image}: {:.1e}", ratio - 1.0);
        worst = worst.max((ratio - 1.0).abs() - rounding);
        // The way back is the way there, backwards.
        let turned = (there.launch + back.arrival).length().max((there.arrival + back.launch).length());
        assert!(turned < 1e-10 + rounding, "r1 {r1} r2 {r2} theta {theta} image {image}: {turned:.1e}");
    }
    eprintln!("worst etendue error {worst:.1e}");
}

#[test]
fn every_image_is_the_only_one() {
    // Every launch angle is tried: the rays fall short (escape, or pass further out) up to one angle and too far from there on.
    let mut random = Random(9);
    for _ in 0..400 {
        let (r1, r2, theta) = (random.radius(), random.radius(), random.angle());
        for image in 0..3 {
            let arc = join(1.0, r1, r2, theta, image).unwrap();
            let alpha = arc.launch.y.atan2(arc.launch.x);
            let swept = swept_angle(theta, image);
            let mut angles: Vec<f64> = (1..600).map(|i| PI * f64::from(i) / 600.0).collect();
            // Close to the answer and to the ends, in ever smaller distances.
            for i in 1..60 {
                let near = 0.7f64.powi(i);
                angles.extend([alpha - near * alpha, alpha + near * (PI - alpha), near, PI - near]);
            }
            angles.retain(|a| *a > 0.0 && *a < PI && (a - alpha).abs() > 1e-7 * alpha.min(PI - alpha));
            angles.sort_by(f64::total_cmp);
            for a in angles {
                let reached = follow(1.0 / r1, -1.0 / (r1 * a.tan()), swept).u;
                let beyond = reached > 1.0 / r2;
                assert_eq!(
                    beyond,
                    a > alpha,
                    "r1 {r1} r2 {r2} theta {theta} image {image}: angle {a}, answer {alpha}, {reached}"
                );
            }
        }
    }
}
