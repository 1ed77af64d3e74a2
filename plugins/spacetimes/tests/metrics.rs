//! What every spacetime says of itself agrees: observers, metric, index, eight points at a time, other coordinates.

mod common;

use bhs_core::dual::Dual;
use bhs_core::lanes::LANES;
use bhs_core::real::Vectors;
use bhs_core::spacetime::{Class, Fields, Place, Side, stationary};
use common::{Random, index_of, one_of_each, points};
use glam::{DMat3, DVec3};

const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

#[test]
fn observers_have_the_metric_that_hamiltons_equations_use() {
    for (name, spacetime) in one_of_each() {
        let mut stood = 0;
        for x in points() {
            let Some(here) = spacetime.at(Place::near(x)) else { continue };
            stood += 1;
            let other = stationary(spacetime.metric(), x).unwrap();
            assert!((here.lapse / other.lapse - 1.0).abs() < 1e-12, "{name} {x}");
            assert!((here.beta - other.beta).length() <= 1e-12 * here.beta.length(), "{name} {x}");
            for v in AXES {
                let size = here.root.apply(v).length();
                assert!((here.root.apply(v) - other.root.apply(v)).length() < 1e-11 * size, "{name} {x}");
            }
            // Light of energy 1 has no length, and moves as d / (N |d|_g).
            let inverse = spacetime.metric().inverse(Dual::variables(x));
            for d in [DVec3::new(0.6, 0.0, -0.8), DVec3::new(-0.48, 0.6, 0.64)] {
                let p = here.momentum(d);
                let scale = 1.0 / (here.lapse * here.lapse);
                assert!(inverse.norm(p).value.abs() < 1e-11 * scale, "{name} {x}");
                let v = d / (here.lapse * here.root.apply(d).length());
                assert!((inverse.velocity(p) - v).length() < 1e-11 * v.length(), "{name} {x}");
                assert!((p.dot(d) - here.travel_time(d)).abs() < 1e-11 * here.travel_time(d).abs(), "{name} {x}");
            }
        }
        assert!(stood > 80, "{name}: {stood}");
    }
}

#[test]
fn the_inverse_metric_is_the_inverse_of_the_metric() {
    for (name, spacetime) in one_of_each() {
        for x in points().filter(|x| spacetime.at(Place::near(*x)).is_some()) {
            let Fields { lapse_squared, gamma, beta } = spacetime.metric().fields(Dual::variables(x));
            let inverse = spacetime.metric().inverse(Dual::variables(x));
            let matrix = |[xx, yy, zz, yz, xz, xy]: [Dual; 6]| {
                DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz].map(|g| g.value))
            };
            let (n2, beta) = (lapse_squared.value, DVec3::from_array(beta.map(|b| b.value)));
            let outer = DMat3::from_cols(beta * beta.x, beta * beta.y, beta * beta.z);
            let space = matrix(gamma) - outer * n2;
            let (up, up_t, up_tt) = (matrix(inverse.space), DVec3::from_array(inverse.t.map(|t| t.value)), inverse.tt.value);
            // g^ta g_ta, g^ta g_aj, g^ia g_at, g^ia g_aj
            let size = up_tt.abs().max(1.0) * n2.max(1.0) * gamma.map(|g| g.value.abs()).into_iter().fold(1.0, f64::max);
            assert!((-n2 * up_tt - n2 * up_t.dot(beta) - 1.0).abs() < 1e-12 * size, "{name} {x}");
            assert!((space * up_t - n2 * up_tt * beta).length() < 1e-12 * size, "{name} {x}");
            let unit = up * space - DMat3::from_cols(up_t * beta.x, up_t * beta.y, up_t * beta.z) * n2;
            assert!(AXES.into_iter().all(|v| (unit * v - v).length() < 1e-12 * size), "{name} {x}: {unit}");
        }
    }
}

#[test]
fn indices_are_those_of_the_metric_with_their_derivatives() {
    for (name, spacetime) in one_of_each() {
        let Some(index) = index_of(spacetime.as_ref()) else { continue };
        for x in points() {
            let (square, gradient) = index.index(x);
            // n^2 = gamma / N^2, and its gradient by dual numbers.
            let fields = spacetime.metric().fields(Dual::variables(x));
            let n2 = fields.gamma[0] / fields.lapse_squared;
            assert!((n2.value / square - 1.0).abs() < 1e-13, "{name} {x}");
            assert!((0.5 * n2.gradient - gradient).length() < 1e-12 * gradient.length().max(1e-3), "{name} {x}");
            // Second derivatives by finite differences of the first, with Richardson's extrapolation.
            let hessian = index.hessian(x);
            let scale = (0..3).map(|i| hessian.col(i).length()).fold(0.0, f64::max);
            for (i, unit) in AXES.into_iter().enumerate() {
                let slope = |h: f64| (index.index(x + unit * h).1 - index.index(x - unit * h).1) / (2.0 * h);
                let h = 1e-3 * nearest_singularity(name, x);
                let slope = (4.0 * slope(0.5 * h) - slope(h)) / 3.0;
                assert!((hessian.col(i) - slope).length() < 1e-8 * scale, "{name} {x}: {} {slope}", hessian.col(i));
            }
            assert!((hessian - hessian.transpose()).to_cols_array().iter().all(|d| d.abs() < 1e-12 * scale), "{name} {x}");
        }
    }
}

/// Distance from the nearest hole or centre of the spacetimes of `one_of_each`.
fn nearest_singularity(name: &str, x: DVec3) -> f64 {
    let centers: &[DVec3] = match name {
        "majumdar-papapetrou" => &[DVec3::new(0.0, 0.1, 0.4), DVec3::new(0.2, 0.0, -0.5), DVec3::new(-0.9, 0.0, 0.0)],
        _ => &[DVec3::new(0.3, -0.2, 0.1)],
    };
    centers.iter().map(|c| (x - *c).length()).fold(f64::INFINITY, f64::min)
}

#[test]
fn eight_points_are_as_one_to_the_bit() {
    for (name, spacetime) in one_of_each() {
        let Some(index) = index_of(spacetime.as_ref()) else { continue };
        let points: Vec<DVec3> = points().collect();
        for eight in points.chunks_exact(LANES) {
            let (squares, gradients) = index.index_each(Vectors::of(eight.try_into().unwrap()));
            for (i, x) in eight.iter().enumerate() {
                let (square, gradient) = index.index(*x);
                assert_eq!((squares.to_array()[i], gradients.lane(i)), (square, gradient), "{name} {x}");
            }
        }
    }
}

#[test]
fn other_coordinates_are_the_same_spacetime() {
    let origin = DVec3::new(1.25, -0.5, 3.0);
    for (name, spacetime) in one_of_each() {
        let moved = spacetime.moved(origin);
        assert_eq!(moved.has_far_side(), spacetime.has_far_side());
        for x in points() {
            for side in [Side::Near, Side::Far] {
                let (a, b) = (spacetime.at(Place { x, side }), moved.at(Place { x: x - origin, side }));
                assert_eq!(a.is_some(), b.is_some(), "{name} {x}");
                let (Some(a), Some(b)) = (a, b) else { continue };
                assert!((a.lapse - b.lapse).abs() < 1e-12 && (a.beta - b.beta).length() < 1e-12, "{name} {x}");
                assert!((a.root.apply(DVec3::X) - b.root.apply(DVec3::X)).length() < 1e-9, "{name} {x}");
            }
        }
        for (a, b) in spacetime.captures().iter().zip(moved.captures()) {
            assert!((a.center - b.center - origin).length() < 1e-15 && a.radius == b.radius, "{name}");
        }
        match (spacetime.class(), moved.class()) {
            (Class::Flat, Class::Flat) => (),
            (Class::Spherical(a), Class::Spherical(b)) => {
                assert!((a.center - b.center - origin).length() < 1e-15 && a.rs == b.rs)
            }
            (Class::Index(a), Class::Index(b)) => {
                let x = DVec3::new(2.0, 1.0, 0.5);
                assert!((a.index(x).0 - b.index(x - origin).0).abs() < 1e-13, "{name}");
                assert_eq!(a.breaks(), b.breaks());
                assert_eq!(a.throat().map(|t| (t.center - origin, t.radius)), b.throat().map(|t| (t.center, t.radius)));
            }
            (Class::Kerr(_), Class::Kerr(_)) | (Class::General(_), Class::General(_)) => (),
            (a, b) => panic!("{name}: {a:?} {b:?}"),
        }
    }
}

#[test]
fn sides_and_throats() {
    for (name, spacetime) in one_of_each() {
        let mut random = Random(3);
        let throat = index_of(spacetime.as_ref()).and_then(|index| index.throat());
        assert_eq!(throat.is_some(), spacetime.has_far_side(), "{name}");
        for _ in 0..100 {
            let x = DVec3::new(0.3, -0.2, 0.1) + random.direction() * (2.0 * random.next());
            let here = [Side::Near, Side::Far].map(|side| spacetime.at(Place { x, side }));
            match throat {
                None => assert!(here[1].is_none(), "{name}"),
                Some(throat) => {
                    let outside = (x - throat.center).length() >= throat.radius;
                    assert_eq!(here.map(|h| h.is_some()), [outside; 2], "{name}");
                    // The index is that of the same point in the other chart: n dx is the same length.
                    let index = index_of(spacetime.as_ref()).unwrap();
                    let there = throat.through(x);
                    let scale = throat.radius.powi(2) / (x - throat.center).length_squared();
                    let (a, b) = (index.index(x).0, index.index(there).0 * scale * scale);
                    assert!((a / b - 1.0).abs() < 1e-12, "{name} {x}: {a} {b}");
                }
            }
        }
    }
}
