//! Spheres and ellipsoids: intersections against another formula, samples against their density, and pbrt's conventions.

mod common;

use bhs_core::geometry::{Analytic, Segment};
use bhs_core::value::{Param, ParamType};
use common::{Place, near, numbers};
use glam::{DAffine3, DMat3, DVec3, Vec2};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn float(name: &str, value: f64) -> Param {
    numbers(ParamType::Float, name, &[value])
}

fn slanted() -> DAffine3 {
    let m = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
    DAffine3 { matrix3: m, translation: DVec3::new(-1.0, 2.0, 0.5) }
}

fn mirrored() -> DAffine3 {
    DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * slanted()
}

/// A whole sphere of this radius.
fn sphere(t: DAffine3, radius: f64) -> Box<dyn Analytic> {
    Place::at(t).analytic("sphere", &[float("radius", radius)])
}

fn segment(origin: DVec3, direction: DVec3) -> Segment {
    Segment { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
}

/// Both places where a line meets the unit sphere's image, without any quadratic formula: the least distance from the center
/// by ternary search, the crossings on both sides by bisection.
fn by_bisection(t: DAffine3, radius: f64, s: &Segment) -> Option<[f64; 2]> {
    let inverse = t.inverse();
    let distance = |x: f64| inverse.transform_point3(s.at(x)).length() / radius;
    let (mut lo, mut hi) = (-1e3, 1e3);
    for _ in 0..300 {
        let (a, b) = (lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0);
        if distance(a) < distance(b) { hi = b } else { lo = a }
    }
    let middle = 0.5 * (lo + hi);
    if distance(middle) >= 1.0 {
        return None;
    }
    Some([-1e3, 1e3].map(|mut outside| {
        let mut inside = middle;
        for _ in 0..200 {
            let x = 0.5 * (inside + outside);
            if distance(x) < 1.0 { inside = x } else { outside = x }
        }
        0.5 * (inside + outside)
    }))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn hits_are_where_bisection_finds_them(
        o in prop::array::uniform3(-4.0..4.0f64),
        d in prop::array::uniform3(-1.0..1.0f64),
        which in 0usize..3,
        radius in 0.2..2.0f64,
    ) {
        let t = [DAffine3::from_translation(DVec3::new(0.3, -0.2, 1.0)), slanted(), mirrored()][which];
        let s = segment(o.into(), d.into());
        prop_assume!(s.direction.length() > 0.1);
        let found = sphere(t, radius).intersect(&s);
        match by_bisection(t, radius, &s) {
            // Grazing lines may be told either way.
            Some([a, b]) if b - a > 1e-4 => {
                let expected = [a, b].into_iter().find(|x| *x > 0.0);
                prop_assert_eq!(found.is_some(), expected.is_some());
                if let (Some(found), Some(expected)) = (found, expected) {
                    prop_assert!((found - expected).abs() < 1e-9, "{} {}", found, expected);
                }
            }
            Some(_) => {}
            None => prop_assert!(found.is_none_or(|f| t.inverse().transform_point3(s.at(f)).length() > radius * (1.0 - 1e-7))),
        }
    }

    #[test]
    fn hits_lie_in_the_bounds_and_on_the_surface(
        o in prop::array::uniform3(-4.0..4.0f64),
        d in prop::array::uniform3(-1.0..1.0f64),
        z in prop::array::uniform2(-1.2..1.2f64),
        phi in 10.0..400.0f64,
        which in 0usize..3,
    ) {
        prop_assume!(z[0] + 0.1 < z[1] && z[0] < 0.9 && z[1] > -0.9);
        let t = [DAffine3::IDENTITY, slanted(), mirrored()][which];
        let part = Place::at(t).analytic("sphere", &[float("zmin", z[0]), float("zmax", z[1]), float("phimax", phi.min(360.0))]);
        let s = segment(o.into(), d.into());
        let Some(hit) = part.intersect(&s) else { return Ok(()) };
        let own = t.inverse().transform_point3(s.at(hit));
        prop_assert!((own.length() - 1.0).abs() < 1e-9);
        prop_assert!(own.z > z[0] - 1e-9 && own.z < z[1] + 1e-9);
        let azimuth = own.y.atan2(own.x).to_degrees().rem_euclid(360.0);
        prop_assert!(azimuth <= phi + 1e-6);
        let b = part.bounds().grown(1e-9);
        prop_assert!(s.at(hit).cmpge(b.min).all() && s.at(hit).cmple(b.max).all());
    }
}

#[test]
fn tiny_spheres_far_away_are_hit_exactly() {
    // The textbook discriminant b^2 - 4 a c would be 1e12 less 1e12, wrong by a hundred radii.
    let (far, r) = (1e6, 1e-3);
    let s = sphere(DAffine3::from_translation(DVec3::new(0.0, 0.0, far)), r);
    for x in [0.0, 0.5e-3, 0.9e-3, 0.999e-3] {
        let hit = s.intersect(&segment(DVec3::new(x, 0.0, 0.0), DVec3::Z)).expect("a hit");
        let expected = far - (r * r - x * x).sqrt();
        assert!((hit - expected).abs() < 1e-9, "{x}: off by {:e}", hit - expected);
    }
    assert_eq!(s.intersect(&segment(DVec3::new(1.001e-3, 0.0, 0.0), DVec3::Z)), None);
}

#[test]
fn huge_spheres_nearby_are_hit_exactly() {
    let r = 1e7;
    let s = sphere(DAffine3::from_translation(DVec3::new(0.0, -r, 0.0)), r);
    let hit = s.intersect(&segment(DVec3::new(0.0, 1.0, 0.0), DVec3::NEG_Y)).expect("a hit");
    assert!((hit - 1.0).abs() < 1e-8);
}

#[test]
fn a_start_on_the_surface_finds_the_other_side_only() {
    let s = sphere(slanted(), 0.7);
    for i in 0..64 {
        let sample = s.sample(Vec2::new((i as f32 + 0.5) / 64.0, (i as f32 * 0.618).fract()));
        let clear = |direction| Segment { t_min: 1e-9, ..segment(sample.point, direction) };
        assert_eq!(s.intersect(&clear(sample.normal)), None);
        let through = s.intersect(&clear(-sample.normal)).expect("the far side");
        assert!(through > 0.01, "{through}");
    }
}

#[test]
fn the_open_range_of_the_segment_counts() {
    let s = sphere(DAffine3::IDENTITY, 1.0);
    let along = |t_min, t_max| s.intersect(&Segment { t_min, t_max, ..segment(DVec3::new(0.0, 0.0, -3.0), 2.0 * DVec3::Z) });
    assert_eq!(along(0.0, 10.0), Some(1.0));
    assert_eq!(along(1.0, 10.0), Some(2.0));
    assert_eq!(along(0.0, 1.0), None);
    assert_eq!(along(1.0, 2.0), None);
    assert_eq!(along(-10.0, 0.0), None);
    assert_eq!(s.intersect(&segment(DVec3::ZERO, DVec3::ZERO)), None);
    assert_eq!(s.intersect(&segment(DVec3::NAN, DVec3::X)), None);
}

#[test]
fn outside_is_out_unless_reversed() {
    for t in [DAffine3::IDENTITY, slanted(), mirrored(), DAffine3::from_scale(DVec3::splat(-2.0))] {
        for (place, sign) in [(Place::at(t), 1.0), (Place::at(t).reversed(), -1.0)] {
            let s = place.analytic("sphere", &[float("radius", 0.8)]);
            for i in 0..32 {
                let sample = s.sample(Vec2::new((i as f32 + 0.5) / 32.0, (i as f32 * 0.618).fract()));
                let own = t.inverse().transform_point3(sample.point);
                let expected = (t.matrix3.inverse().transpose() * own).normalize() * sign;
                assert!(near(sample.normal, expected, 1e-12));
                let surface = s.surface(sample.point);
                assert!(near(surface.normal, expected, 1e-12) && near(surface.shading_normal, expected, 1e-12));
                assert!((surface.uv - sample.uv).abs().max_element() < 1e-6);
            }
        }
    }
}

#[test]
fn texture_coordinates_are_those_of_pbrt() {
    let s = sphere(DAffine3::IDENTITY, 2.0);
    let uv = |p: [f64; 3]| s.surface(2.0 * DVec3::from_array(p)).uv;
    assert_eq!(uv([1.0, 0.0, 0.0]), Vec2::new(0.0, 0.5));
    assert_eq!(uv([0.0, 1.0, 0.0]), Vec2::new(0.25, 0.5));
    assert_eq!(uv([-1.0, 0.0, 0.0]), Vec2::new(0.5, 0.5));
    assert_eq!(uv([0.0, -1.0, 0.0]), Vec2::new(0.75, 0.5));
    assert_eq!(uv([0.0, 0.0, -1.0]).y, 0.0);
    assert_eq!(uv([0.0, 0.0, 1.0]).y, 1.0);
    let part = Place::default().analytic("sphere", &[float("zmin", 0.0), float("phimax", 180.0)]);
    assert_eq!(part.surface(DVec3::Y).uv, Vec2::new(0.5, 0.0));
}

/// The area of every cell of a grid over (a part of) the sphere's image, as half the cross product of the diagonals, with the
/// cell's middle.
fn cells(t: DAffine3, radius: f64, z: [f64; 2], phi_max: f64) -> Vec<(DVec3, f64)> {
    let (n, m) = (400, 400);
    let theta = z.map(|z| (z / radius).clamp(-1.0, 1.0).acos());
    let point = |i: f64, j: f64| {
        let (st, ct) = (theta[0] + (theta[1] - theta[0]) * i / f64::from(n)).sin_cos();
        let (sp, cp) = (phi_max * j / f64::from(m)).sin_cos();
        t.transform_point3(radius * DVec3::new(st * cp, st * sp, ct))
    };
    let mut out = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (x, y) = (f64::from(i), f64::from(j));
            let diagonals = (point(x + 1.0, y + 1.0) - point(x, y), point(x + 1.0, y) - point(x, y + 1.0));
            out.push((point(x + 0.5, y + 0.5), 0.5 * diagonals.0.cross(diagonals.1).length()));
        }
    }
    out
}

#[test]
fn areas_and_densities_are_right() {
    let parts = [([-0.6, 0.6], 360.0), ([-0.2, 0.6], 360.0), ([-0.6, 0.3], 100.0)];
    for t in [DAffine3::from_scale(DVec3::splat(1.5)), slanted(), mirrored(), DAffine3::from_scale(DVec3::new(1.0, 0.1, 3.0))] {
        for (z, phi) in parts {
            let params = [float("radius", 0.6), float("zmin", z[0]), float("zmax", z[1]), float("phimax", phi)];
            let s = Place::at(t).analytic("sphere", &params);
            let cells = cells(t, 0.6, z, f64::to_radians(phi));
            let area: f64 = cells.iter().map(|c| c.1).sum();
            assert!((s.area() / area - 1.0).abs() < 1e-4, "{} instead of {area}", s.area());
            let total: f64 = cells.iter().map(|c| s.pdf(c.0) * c.1).sum();
            assert!((total - 1.0).abs() < 1e-4, "{total}");
        }
    }
    let r = 0.3;
    assert!((sphere(DAffine3::IDENTITY, r).area() / (4.0 * PI * r * r) - 1.0).abs() < 1e-14);
}

#[test]
fn samples_follow_their_density() {
    for t in [DAffine3::from_translation(DVec3::X), slanted(), mirrored()] {
        for (z, phi) in [([-1.0, 1.0], 360.0), ([-0.5, 0.8], 250.0)] {
            let params = [float("zmin", z[0]), float("zmax", z[1]), float("phimax", phi)];
            let s = Place::at(t).analytic("sphere", &params);
            // By the points' own coordinates: 8 x 8 cells of equal area on the unit sphere, equally often hit.
            let n = 64;
            let mut counts = [0.0f64; 64];
            let mut inverse = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i / n) as f32 + 0.5, (i % n) as f32 + 0.5) / n as f32;
                let sample = s.sample(u);
                assert!((s.pdf(sample.point) / sample.pdf - 1.0).abs() < 1e-9);
                inverse += 1.0 / sample.pdf / f64::from(n * n);
                let own = t.inverse().transform_point3(sample.point);
                assert!((own.length() - 1.0).abs() < 1e-12);
                let a = (own.z - z[0]) / (z[1] - z[0]);
                let b = own.y.atan2(own.x).rem_euclid(TAU) / f64::to_radians(phi);
                counts[((a * 8.0) as usize).min(7) * 8 + ((b * 8.0) as usize).min(7)] += 1.0;
            }
            // A grid of samples hits every cell exactly alike; the mean of 1/pdf is the area.
            assert!(counts.iter().all(|c| *c == f64::from(n * n) / 64.0), "{counts:?}");
            assert!((inverse / s.area() - 1.0).abs() < 1e-3, "{inverse} {}", s.area());
        }
    }
}

#[test]
fn moving_to_render_space_moves_everything() {
    let mut s = sphere(slanted(), 0.7);
    let before = s.bounds();
    let origin = DVec3::new(100.0, -3.0, 7.0);
    s.rebase(origin);
    assert!(near(s.bounds().min, before.min - origin, 1e-12) && near(s.bounds().max, before.max - origin, 1e-12));
    let sample = s.sample(Vec2::new(0.2, 0.7));
    let own = slanted().inverse().transform_point3(sample.point + origin);
    assert!((own.length() - 0.7).abs() < 1e-12);
}

#[test]
fn faults_are_told() {
    let check = |params: &[Param], expected: &str| assert_eq!(Place::default().faults("sphere", params), [expected]);
    check(&[float("radius", 0.0)], "`radius` must be above 0");
    check(&[float("radius", -2.0)], "`radius` must be above 0");
    check(&[float("phimax", 361.0)], "`phimax` must be above 0 and at most 360");
    check(&[float("phimax", 0.0)], "`phimax` must be above 0 and at most 360");
    check(
        &[float("zmin", 0.5), float("zmax", 0.25)],
        "nothing is left of the sphere between `zmin` and `zmax`: z runs from 0.5 to 0.25, on the sphere from -1 to 1",
    );
    let flat = Place::at(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
    assert_eq!(flat.faults("sphere", &[]), ["the current transform flattens the sphere, or is out of range"]);
    assert_eq!(
        flat.faults("sphere", &[float("radius", 1e-320)]),
        ["the current transform flattens the sphere, or is out of range"]
    );
    let huge = Place::at(DAffine3::from_scale(DVec3::splat(1e200)));
    assert_eq!(huge.faults("sphere", &[]), ["the current transform flattens the sphere, or is out of range"]);
}
