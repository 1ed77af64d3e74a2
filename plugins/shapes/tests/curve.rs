//! Curves: triangles lie along the spline that the control points are of, as wide as asked for, with their outer side outside.

mod common;

use bhs_core::geometry::WorldMesh;
use bhs_core::value::{Param, ParamType};
use common::{Place, near, numbers, text};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

fn points(name: &str, points: &[[f64; 3]]) -> Param {
    numbers(if name == "N" { ParamType::Normal } else { ParamType::Point3 }, name, points.as_flattened())
}

fn curve(params: &[Param]) -> WorldMesh {
    Place::default().mesh("curve", params)
}

/// Degree elevation and subdivision aside: de Casteljau's point of a Bezier curve of any degree.
fn casteljau(control: &[[f64; 3]], u: f64) -> DVec3 {
    let mut points: Vec<DVec3> = control.iter().copied().map(DVec3::from).collect();
    while points.len() > 1 {
        points = points.windows(2).map(|w| w[0].lerp(w[1], u)).collect();
    }
    points[0]
}

/// A point of a uniform B-spline, by Cox and de Boor's recurrence with knots at the whole numbers.
fn de_boor(control: &[[f64; 3]], degree: usize, x: f64) -> DVec3 {
    let k = (x.floor() as usize).min(control.len() - degree - 1) + degree;
    let x = x + degree as f64;
    let mut d: Vec<DVec3> = (0..=degree).map(|j| DVec3::from(control[j + k - degree])).collect();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let alpha = (x - (j + k - degree) as f64) / (degree - r + 1) as f64;
            d[j] = d[j - 1].lerp(d[j], alpha);
        }
    }
    d[degree]
}

/// The middle of each row of vertices of a tube, with its u.
fn axis(mesh: &WorldMesh) -> Vec<(f64, DVec3)> {
    let rows = mesh.positions.chunks(7).zip(mesh.uvs.chunks(7));
    rows.map(|(p, uv)| (f64::from(uv[0][0]), p[..6].iter().sum::<DVec3>() / 6.0)).collect()
}

const CUBIC: [[f64; 3]; 4] = [[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.5], [1.0, -1.0, 0.2], [1.0, 1.0, 0.0]];
const LONG: [[f64; 3]; 5] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [2.0, 1.0, 0.0], [2.0, 2.0, -1.0], [3.0, 2.0, 0.0]];

#[test]
fn tubes_lie_around_their_splines() {
    let thin = numbers(ParamType::Float, "width", &[0.01]);
    for (u, at) in axis(&curve(&[points("P", &CUBIC), thin.clone()])) {
        assert!(near(at, casteljau(&CUBIC, u), 1e-6), "{u}: {at}");
    }
    let two = numbers(ParamType::Integer, "degree", &[2.0]);
    let rows = axis(&curve(&[points("P", &LONG), thin.clone(), two.clone()]));
    let second = rows.iter().skip(1).position(|(u, _)| *u == 0.0).expect("two curves") + 1;
    for (i, (u, at)) in rows.iter().enumerate() {
        let control = if i < second { &LONG[..3] } else { &LONG[2..] };
        assert!(near(*at, casteljau(control, *u), 1e-6), "{i} {u}: {at}");
    }
    for (degree, given) in [(3, vec![]), (2, vec![two])] {
        let params = [&[points("P", &LONG), thin.clone(), text("basis", "bspline")][..], &given].concat();
        let (mut segment, mut last) = (0.0, -1.0);
        for (u, at) in axis(&curve(&params)) {
            segment += if u < last { 1.0 } else { 0.0 };
            last = u;
            assert!(near(at, de_boor(&LONG, degree, segment + u), 1e-6), "{degree} {segment} {u}: {at}");
        }
        assert_eq!(segment as usize, LONG.len() - degree - 1);
    }
}

#[test]
fn widths_are_those_asked_for() {
    let widths = [("width0", 0.4), ("width1", 0.1)].map(|(name, w)| numbers(ParamType::Float, name, &[w]));
    let straight = points("P", &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    let [from, to] = widths;
    let mesh = curve(&[straight.clone(), from.clone(), to.clone(), text("type", "cylinder")]);
    // The mean width of the outline at one end, over the directions from which it is seen.
    for (row, width) in [(&mesh.positions[..6], 0.4), (&mesh.positions[mesh.positions.len() - 7..][..6], 0.1)] {
        let seen = |angle: f64| {
            let across = row.iter().map(|p| p.y * angle.cos() + p.z * angle.sin());
            across.clone().fold(f64::MIN, f64::max) - across.fold(f64::MAX, f64::min)
        };
        let mean = (0..600).map(|i| seen(PI * (f64::from(i) + 0.5) / 600.0)).sum::<f64>() / 600.0;
        assert!((mean / width - 1.0).abs() < 1e-4, "{mean} {width}");
    }
    // Outside is outside, and normals point there.
    let middle = DVec3::new(1.5, 0.0, 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let out = (a - middle) * DVec3::new(0.0, 1.0, 1.0);
        assert!((b - a).cross(c - a).dot(out) > 0.0);
        for v in t {
            let n = DVec3::from_array(mesh.normals[*v as usize].map(f64::from));
            assert!(n.dot((mesh.positions[*v as usize] - middle) * DVec3::new(0.0, 1.0, 1.0)) > 0.0);
        }
    }
    // A ribbon lies across its normals, which turn by a quarter.
    let normals = points("N", &[[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
    let ribbon = curve(&[straight, from, to, normals, text("type", "ribbon")]);
    for (i, pair) in ribbon.positions.chunks(2).enumerate() {
        let u = f64::from(ribbon.uvs[2 * i][0]);
        let (sin, cos) = (0.5 * PI * u).sin_cos();
        let expected = DVec3::new(0.0, cos, sin) * (0.4 - 0.3 * u);
        assert!(near(pair[1] - pair[0], expected, 1e-6), "{u}: {}", pair[1] - pair[0]);
        let n = DVec3::from_array(ribbon.normals[2 * i].map(f64::from));
        assert!(near(n, DVec3::new(0.0, -sin, cos), 1e-6));
    }
    assert!(ribbon.positions.len() / 2 >= 8);
}

#[test]
fn neighbours_share_the_places_of_their_ends_and_transforms_count() {
    let place = Place::at(DAffine3::from_scale(DVec3::new(2.0, -1.0, 1.0)));
    let mesh = place.mesh("curve", &[points("P", &LONG), numbers(ParamType::Integer, "degree", &[2.0])]);
    assert!(mesh.flipped);
    let ends: Vec<DVec3> = axis(&mesh).into_iter().filter(|(u, _)| *u == 0.0 || *u == 1.0).map(|(_, p)| p).collect();
    assert!(ends.len() == 4 && near(ends[1], ends[2], 1e-9) && near(ends[1], DVec3::new(4.0, -1.0, 0.0), 1e-9), "{ends:?}");
    // A thread that is a point has no surface.
    assert!(curve(&[points("P", &[[1.0, 1.0, 1.0]; 4])]).triangles.is_empty());
}

#[test]
fn faults_are_told() {
    let said = |params: &[Param]| {
        let (made, said) = Place::default().build("curve", params);
        assert!(made.is_none() || said.iter().any(|s| s.contains("means something")), "{said:?}");
        said.join("\n")
    };
    assert!(said(&[points("P", &LONG)]).contains("5 points make no curves"));
    assert!(said(&[points("P", &CUBIC[..3]), text("basis", "bspline")]).contains("at least 4"));
    assert!(said(&[points("P", &CUBIC), text("type", "ribbon")]).contains("needs 2 normals"));
    assert!(said(&[points("P", &CUBIC), points("N", &[[0.0, 0.0, 1.0]])]).contains("means something for a ribbon alone"));
}
