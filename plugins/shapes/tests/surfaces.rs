//! Disks, cylinders and bilinear patches: intersections and areas against dense nets of triangles, samples against their density, and
//! pbrt's conventions.

mod common;

use bhs_core::geometry::{Analytic, Segment};
use bhs_core::value::{Param, ParamType};
use common::{Place, near, numbers};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2};
use std::f64::consts::{PI, TAU};

fn float(name: &str, value: f64) -> Param {
    numbers(ParamType::Float, name, &[value])
}

fn points(name: &str, points: &[DVec3]) -> Param {
    let values: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
    numbers(if name == "N" { ParamType::Normal } else { ParamType::Point3 }, name, &values)
}

fn slanted() -> DAffine3 {
    let m = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
    DAffine3 { matrix3: m, translation: DVec3::new(-1.0, 2.0, 0.5) }
}

fn mirrored() -> DAffine3 {
    DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * slanted()
}

fn segment(origin: DVec3, direction: DVec3) -> Segment {
    Segment { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
}

/// Numbers in 0..1 that fill squares evenly.
fn spread(i: usize) -> [f64; 4] {
    [0.618_033_988_7, 0.754_877_666_2, 0.569_840_290_9, 0.819_172_513_4].map(|a| (0.3 + a * (i + 1) as f64).fract())
}

/// A surface with a formula of its own: the image of the unit square.
struct Case {
    name: &'static str,
    surface: Box<dyn Analytic>,
    point: Box<dyn Fn(f64, f64) -> DVec3>,
    /// Texture coordinates at a place of the square.
    uv: fn(f64, f64) -> DVec2,
    /// Of `dp/du x dp/dv`, the side that is out.
    sign: f64,
}

fn disk(t: DAffine3, inner: f64, phi: f64, reverse: bool) -> Case {
    let place = if reverse { Place::at(t).reversed() } else { Place::at(t) };
    let params = [float("height", 0.4), float("radius", 0.8), float("innerradius", inner), float("phimax", phi)];
    let point = move |u: f64, v: f64| {
        let (r, phi) = (0.8 + (inner - 0.8) * v, phi.to_radians() * u);
        t.transform_point3(DVec3::new(r * phi.cos(), r * phi.sin(), 0.4))
    };
    let sign = if (t.matrix3.determinant() < 0.0) != reverse { -1.0 } else { 1.0 };
    Case { name: "disk", surface: place.analytic("disk", &params), point: Box::new(point), uv: DVec2::new, sign }
}

fn cylinder(t: DAffine3, phi: f64, reverse: bool) -> Case {
    let place = if reverse { Place::at(t).reversed() } else { Place::at(t) };
    // The ends in the wrong order, as pbrt allows.
    let params = [float("radius", 0.7), float("zmin", 0.9), float("zmax", -0.5), float("phimax", phi)];
    let point = move |u: f64, v: f64| {
        let phi = phi.to_radians() * u;
        t.transform_point3(DVec3::new(0.7 * phi.cos(), 0.7 * phi.sin(), -0.5 + 1.4 * v))
    };
    let sign = if (t.matrix3.determinant() < 0.0) != reverse { -1.0 } else { 1.0 };
    Case { name: "cylinder", surface: place.analytic("cylinder", &params), point: Box::new(point), uv: DVec2::new, sign }
}

/// Saddle, folded, trapezoid, and one with two corners at the same place.
const PATCHES: [[[f64; 3]; 4]; 4] = [
    [[-1.0, -1.0, 0.5], [1.0, -1.0, -0.5], [-1.0, 1.0, -0.5], [1.0, 1.0, 0.5]],
    [[-1.0, 0.0, -1.0], [1.0, 0.2, -0.7], [-0.8, 1.3, 1.0], [1.0, -0.4, 1.1]],
    [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-0.3, 1.0, 0.0], [0.4, 1.0, 0.0]],
    [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.3], [0.1, 1.0, 0.0], [0.1, 1.0, 0.0]],
];

fn patch(t: DAffine3, corners: [[f64; 3]; 4], reverse: bool) -> Case {
    let place = if reverse { Place::at(t).reversed() } else { Place::at(t) };
    let corners = corners.map(DVec3::from);
    let surface = place.analytic("bilinearmesh", &[points("P", &corners)]);
    let [a, b, c, d] = corners.map(|p| t.transform_point3(p));
    let point = move |u: f64, v: f64| a.lerp(b, u).lerp(c.lerp(d, u), v);
    // As pbrt: along dp/du x dp/dv of the transformed patch, turned round where the transform mirrors.
    let sign = if (t.matrix3.determinant() < 0.0) != reverse { -1.0 } else { 1.0 };
    Case { name: "bilinearmesh", surface, point: Box::new(point), uv: DVec2::new, sign }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (t, reverse) in [(DAffine3::IDENTITY, false), (slanted(), false), (mirrored(), false), (slanted(), true)] {
        cases.extend([disk(t, 0.0, 360.0, reverse), disk(t, 0.3, 250.0, reverse)]);
        cases.extend([cylinder(t, 360.0, reverse), cylinder(t, 100.0, reverse)]);
        cases.extend(PATCHES.map(|p| patch(t, p, reverse)));
    }
    cases
}

impl Case {
    /// Unit normal on the outer side and area per area of the square, by differences.
    fn normal(&self, u: f64, v: f64) -> (DVec3, f64) {
        let h = 1e-6;
        let du = ((self.point)(u + h, v) - (self.point)(u - h, v)) / (2.0 * h);
        let dv = ((self.point)(u, v + h) - (self.point)(u, v - h)) / (2.0 * h);
        let n = du.cross(dv);
        (n.normalize() * self.sign, n.length())
    }

    /// The least parameter at which the segment meets a net of the surface's points, by triangles.
    fn by_net(&self, s: &Segment, n: usize) -> Option<f64> {
        let at = |i: usize, j: usize| (self.point)(i as f64 / n as f64, j as f64 / n as f64);
        let grid: Vec<DVec3> = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
        let mut least = f64::INFINITY;
        for k in 0..n * n {
            let i = k / n * (n + 1) + k % n;
            let [a, b, c, d] = [grid[i], grid[i + 1], grid[i + n + 1], grid[i + n + 2]];
            for [a, b, c] in [[a, b, d], [a, d, c]] {
                let normal = (b - a).cross(c - a);
                let t = normal.dot(a - s.origin) / normal.dot(s.direction);
                let p = s.at(t);
                let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(x, y)| (y - x).cross(p - x).dot(normal) >= 0.0);
                if inside && s.t_min < t && t < s.t_max {
                    least = least.min(t);
                }
            }
        }
        (least < f64::INFINITY).then_some(least)
    }
}

#[test]
fn hits_are_where_a_net_of_triangles_is_hit() {
    for case in cases() {
        let (mut hits, mut differ) = (0, 0);
        for i in 0..60 {
            let [a, b, c, d] = spread(i);
            let target = (case.point)(a * 1.1 - 0.05, b * 1.1 - 0.05);
            let origin = target + (DVec3::new(c, d, (a + d).fract()) - 0.5) * 6.0;
            let s = segment(origin, target - origin);
            let (found, net) = (case.surface.intersect(&s), case.by_net(&s, 90));
            match (found, net) {
                (Some(f), Some(n)) if (f - n).abs() < 2e-3 => hits += 1,
                (None, None) => {}
                // Near edges and at grazing incidence the net is another surface.
                _ => differ += 1,
            }
            if let Some(t) = found {
                assert!(
                    case.surface.bounds().grown(1e-9).with_point(s.at(t)) == case.surface.bounds().grown(1e-9),
                    "{}",
                    case.name
                );
                assert!(case.surface.may_pass(s.at(t), DVec3::splat(1e-6)), "{}", case.name);
            }
        }
        assert!(hits > 24 && differ <= 6, "{}: {hits} hits, {differ} differ", case.name);
    }
}

#[test]
fn hits_are_exact() {
    for case in cases() {
        for i in 0..200 {
            let [u, v, c, d] = spread(i);
            let target = (case.point)(u, v);
            let origin = target + (DVec3::new(c, d, (u + d).fract()) - 0.5) * 6.0;
            let s = segment(origin, (target - origin) * 0.37);
            let t = case.surface.intersect(&s).unwrap_or_else(|| panic!("{} {i} at {u} {v}: no hit", case.name));
            // Something nearer may be hit; whatever it is lies on the surface.
            let uv = case.surface.surface(s.at(t)).uv.as_dvec2();
            let on = (case.point)(uv.x, uv.y);
            // Texture coordinates are single precision.
            assert!((on - s.at(t)).length() < 2e-6, "{} {i}: {on} {}", case.name, s.at(t));
            if t > (1.0 - 1e-9) / 0.37 {
                assert!((s.at(t) - target).length() < 1e-11, "{} {i}: {:e}", case.name, (s.at(t) - target).length());
            }
        }
    }
}

#[test]
fn normals_and_texture_coordinates_are_those_of_the_formula() {
    for case in cases() {
        for i in 0..100 {
            let [u, v, ..] = spread(i).map(|x| 0.02 + 0.96 * x);
            let s = case.surface.surface((case.point)(u, v));
            let (n, _) = case.normal(u, v);
            assert!(near(s.normal, n, 1e-6) && near(s.shading_normal, n, 1e-6), "{}: {} {n}", case.name, s.normal);
            assert!((s.uv.as_dvec2() - (case.uv)(u, v)).abs().max_element() < 1e-6, "{}: {} {u} {v}", case.name, s.uv);
        }
    }
}

#[test]
fn areas_and_densities_are_right() {
    for case in cases() {
        let n = 150;
        let (mut area, mut total) = (0.0, 0.0);
        for k in 0..n * n {
            let (u, v) = ((f64::from(k % n) + 0.5) / f64::from(n), (f64::from(k / n) + 0.5) / f64::from(n));
            let cell = case.normal(u, v).1 / f64::from(n * n);
            area += cell;
            total += cell * case.surface.pdf((case.point)(u, v));
        }
        assert!((case.surface.area() / area - 1.0).abs() < 2e-4, "{}: {} instead of {area}", case.name, case.surface.area());
        assert!((total - 1.0).abs() < 1e-3, "{}: {total}", case.name);
    }
}

#[test]
fn samples_follow_their_density() {
    for case in cases() {
        // The share of the samples in each of 6 x 6 cells against the integral of the density over it.
        let (n, m) = (120, 6);
        let mut counts = vec![0.0; m * m];
        let mut inverse = 0.0;
        for k in 0..n * n {
            let u = Vec2::new((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32;
            let sample = case.surface.sample(u);
            assert!((case.surface.pdf(sample.point) / sample.pdf - 1.0).abs() < 1e-6, "{}", case.name);
            inverse += 1.0 / sample.pdf / (n * n) as f64;
            let uv = sample.uv.as_dvec2();
            assert!(((case.point)(uv.x, uv.y) - sample.point).length() < 2e-6, "{}", case.name);
            counts[(((uv.y * m as f64) as usize).min(m - 1)) * m + ((uv.x * m as f64) as usize).min(m - 1)] += 1.0;
        }
        assert!((inverse / case.surface.area() - 1.0).abs() < 2e-3, "{}: {inverse} {}", case.name, case.surface.area());
        for (cell, count) in counts.iter().enumerate() {
            let fine = 12;
            let expected: f64 = (0..fine * fine)
                .map(|k| {
                    let at = |i: usize, k: usize| (i as f64 + (k as f64 + 0.5) / fine as f64) / m as f64;
                    let (u, v) = (at(cell % m, k % fine), at(cell / m, k / fine));
                    case.normal(u, v).1 * case.surface.pdf((case.point)(u, v)) / (fine * fine * m * m) as f64
                })
                .sum();
            let found = count / (n * n) as f64;
            assert!((found - expected).abs() < 2e-3, "{} cell {cell}: {found} instead of {expected}", case.name);
        }
    }
}

#[test]
fn areas_are_the_closed_forms() {
    let t = DAffine3::from_scale(DVec3::splat(2.0));
    assert!((disk(t, 0.3, 250.0, false).surface.area() / (4.0 * (0.64 - 0.09) * PI * 250.0 / 360.0) - 1.0).abs() < 1e-12);
    assert!((cylinder(t, 100.0, false).surface.area() / (4.0 * 1.4 * 0.7 * TAU * 100.0 / 360.0) - 1.0).abs() < 1e-12);
    // An elliptic cylinder: its circumference after Ramanujan 1914, whose error is 3 (h/4)^5/2^7 or so.
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.6, 1.0));
    let (a, b) = (0.7, 0.42);
    let h = ((a - b) / (a + b)) * ((a - b) / (a + b));
    let around = PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
    assert!((cylinder(flat, 360.0, false).surface.area() / (1.4 * around) - 1.0).abs() < 1e-8);
    let thin = DAffine3::from_scale(DVec3::new(1.0, 1e-3, 1.0));
    // As good as two plates; their edges add 1e-6 ln.
    assert!((cylinder(thin, 360.0, false).surface.area() / (1.4 * 4.0 * 0.7) - 1.0).abs() < 1e-5);
}

#[test]
fn flat_patches_are_triangles_and_curved_ones_share_their_edges() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]].map(DVec3::from);
    let mesh = Place::default().mesh("bilinearmesh", &[points("P", &corners)]);
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.uvs[3]), (4, 2, [1.0, 1.0]));
    let area: DVec3 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            (b - a).cross(c - a) * 0.5
        })
        .sum();
    assert_eq!(area, DVec3::Z);
    // A strip of two patches: no ray through the seam is lost.
    let strip =
        [[0.0, 0.0, 0.3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.4], [2.0, 0.0, 0.5], [2.0, 1.0, -0.3]].map(DVec3::from);
    let indices = numbers(ParamType::Integer, "indices", &[0.0, 1.0, 2.0, 3.0, 1.0, 4.0, 3.0, 5.0]);
    let patches = Place::at(slanted()).analytics("bilinearmesh", &[points("P", &strip), indices]);
    assert_eq!(patches.len(), 2);
    for i in 0..2000 {
        let [u, a, b, c] = spread(i);
        let target = slanted().transform_point3(strip[1].lerp(strip[3], u));
        let origin = target + (DVec3::new(a, b, c) - 0.5) * 8.0;
        let s = segment(origin, target - origin);
        let hit = patches.iter().filter_map(|p| p.intersect(&s)).fold(f64::INFINITY, f64::min);
        assert!(hit < 1.0 + 1e-9, "{i}: {hit}");
    }
}

#[test]
fn vertex_normals_decide_which_side_is_out() {
    let corners = PATCHES[0].map(DVec3::from);
    let normals = [[0.0, 0.3, -1.0], [0.2, 0.0, -1.0], [0.0, 0.0, -2.0], [-0.1, 0.0, -1.0]].map(DVec3::from);
    let uvs = numbers(ParamType::Point2, "uv", &[0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 2.0, 3.0]);
    let params = [points("P", &corners), points("N", &normals), uvs];
    let s = Place::default().analytic("bilinearmesh", &params);
    let t = Place::default().reversed().analytic("bilinearmesh", &params);
    let at = corners[0].lerp(corners[1], 0.25).lerp(corners[2].lerp(corners[3], 0.25), 0.5);
    let (a, b) = (s.surface(at), t.surface(at));
    assert!(a.normal.z < 0.0 && near(a.normal, -b.normal, 1e-12) && near(a.shading_normal, -b.shading_normal, 1e-12));
    let mean = |i: usize, j: usize, f: f64| normals[i].normalize().lerp(normals[j].normalize(), f);
    let expected = mean(0, 1, 0.25).lerp(mean(2, 3, 0.25), 0.5).normalize();
    assert!(near(a.shading_normal, expected, 1e-6));
    assert!((a.uv - Vec2::new(0.5, 1.5)).abs().max_element() < 1e-6);
}

#[test]
fn tangents_are_the_derivatives_of_the_point_by_texture_coordinates() {
    for case in cases() {
        for i in 0..40 {
            let [s, t, ..] = spread(i).map(|x| 0.05 + 0.9 * x);
            let [du, dv] = case.surface.tangents((case.point)(s, t)).expect("they are known");
            // By the place on the square, through the texture coordinates: the chain rule.
            let h = 1e-6;
            for (step, along) in [(DVec2::X * h, DVec2::X), (DVec2::Y * h, DVec2::Y)] {
                let moved = ((case.point)(s + step.x, t + step.y) - (case.point)(s - step.x, t - step.y)) / (2.0 * h);
                let uv = (case.uv)(s + along.x * h, t + along.y * h) - (case.uv)(s - along.x * h, t - along.y * h);
                let by_uv = du * (uv.x / (2.0 * h)) + dv * (uv.y / (2.0 * h));
                assert!(near(moved, by_uv, 1e-6), "{} {i}: {moved} {by_uv}", case.name);
            }
        }
    }
}

#[test]
fn moving_to_render_space_moves_everything() {
    let origin = DVec3::new(100.0, -3.0, 7.0);
    for mut case in cases() {
        let before = case.surface.bounds();
        case.surface.rebase(origin);
        let after = case.surface.bounds();
        assert!(near(after.min, before.min - origin, 1e-12) && near(after.max, before.max - origin, 1e-12));
        let sample = case.surface.sample(Vec2::new(0.2, 0.7));
        let uv = sample.uv.as_dvec2();
        assert!(near(sample.point + origin, (case.point)(uv.x, uv.y), 2e-6), "{}", case.name);
    }
}

#[test]
fn segments_that_are_none_hit_nothing() {
    for case in cases() {
        for (o, d) in [(DVec3::ZERO, DVec3::ZERO), (DVec3::NAN, DVec3::X), (DVec3::ZERO, DVec3::splat(f64::INFINITY))] {
            assert_eq!(case.surface.intersect(&segment(o, d)), None, "{}", case.name);
        }
    }
    // In the plane of a disk, along the axis of a cylinder.
    assert_eq!(
        disk(DAffine3::IDENTITY, 0.0, 360.0, false).surface.intersect(&segment(DVec3::new(-3.0, 0.0, 0.4), DVec3::X)),
        None
    );
    assert_eq!(
        cylinder(DAffine3::IDENTITY, 360.0, false).surface.intersect(&segment(DVec3::new(0.7, 0.0, -3.0), DVec3::Z)),
        None
    );
}

#[test]
fn faults_are_told() {
    let check = |shape: &str, params: &[Param], expected: &str| {
        assert_eq!(Place::default().faults(shape, params), [expected], "{shape}");
    };
    check("disk", &[float("radius", 0.0)], "`radius` must be above 0");
    check("disk", &[float("innerradius", 1.0)], "`innerradius` must be at least 0 and less than `radius`: the radius is 1");
    check("disk", &[float("phimax", 361.0)], "`phimax` must be above 0 and at most 360");
    check("cylinder", &[float("radius", -1.0)], "`radius` must be above 0");
    check("cylinder", &[float("zmin", 1.0)], "`zmin` and `zmax` are the same: nothing is left of the cylinder");
    check("cylinder", &[float("phimax", 0.0)], "`phimax` must be above 0 and at most 360");
    let three = points("P", &[DVec3::ZERO, DVec3::X, DVec3::Y]);
    check(
        "bilinearmesh",
        std::slice::from_ref(&three),
        "`indices` can be left out with exactly 4 vertices only, not with 3: which of these make a patch?",
    );
    let indices = |values: &[f64]| numbers(ParamType::Integer, "indices", values);
    check(
        "bilinearmesh",
        &[three.clone(), indices(&[0.0, 1.0, 2.0, 3.0])],
        "vertex index 3 of patch 0 is out of range: there are 3 vertices, counted from 0",
    );
    check(
        "bilinearmesh",
        &[three, indices(&[0.0, 1.0, 2.0])],
        "the number of `indices` is not a multiple of 4: found 3: each patch takes 4",
    );
    let flat = Place::at(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
    for shape in ["disk", "cylinder"] {
        assert_eq!(flat.faults(shape, &[]), [format!("the current transform flattens the {shape}, or is out of range")]);
    }
}
