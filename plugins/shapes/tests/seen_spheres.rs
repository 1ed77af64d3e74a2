//! Points of spheres drawn for those who see them: even in the cone of directions that a sphere fills, on the side that is seen, with the stated density;
//! against closed forms and quadrature.

mod common;

use bhs_core::geometry::{Analytic, Segment};
use bhs_core::value::{Param, ParamType};
use common::{Place, near, numbers};
use glam::{DAffine3, DMat3, DVec3, Vec2};
use std::f64::consts::{PI, TAU};

const CENTER: DVec3 = DVec3::new(0.3, -0.2, 1.0);

fn float(name: &str, value: f64) -> Param {
    numbers(ParamType::Float, name, &[value])
}

fn sphere(t: DAffine3, radius: f64) -> Box<dyn Analytic> {
    Place::at(t).analytic("sphere", &[float("radius", radius)])
}

fn round(radius: f64) -> Box<dyn Analytic> {
    sphere(DAffine3::from_translation(CENTER), radius)
}

/// A direction that is parallel to no axis.
fn aside() -> DVec3 {
    DVec3::new(0.48, -0.6, 0.64)
}

/// The numbers of an even grid, `n` by `n`.
fn grid(n: u32) -> impl Iterator<Item = Vec2> {
    (0..n * n).map(move |i| (Vec2::new((i / n) as f32, (i % n) as f32) + 0.5) / n as f32)
}

#[test]
fn directions_fill_the_cone_evenly() {
    let n = 64;
    for (radius, distance) in [(1.0, 1.001), (1.0, 1.5), (0.5, 3.0), (1e-3, 20.0)] {
        let s = round(radius);
        let eye = CENTER + aside() * distance;
        let cos_max = (1.0 - (radius / distance) * (radius / distance)).sqrt();
        let solid_angle = TAU * (1.0 - cos_max);
        let (s_axis, t_axis) = aside().any_orthonormal_pair();
        // Rings of equal solid angle, and sectors.
        let mut counts = [[0u32; 8]; 8];
        for u in grid(n) {
            let sample = s.sample_from(eye, u);
            let way = sample.point - eye;
            let direction = way.normalize();
            let cos = -direction.dot(sample.normal);
            let expected = cos / way.length_squared() / solid_angle;
            assert!((sample.pdf / expected - 1.0).abs() < 1e-5, "{radius} {distance} {u}: {} {expected}", sample.pdf);
            let at_middle = -direction.dot(aside());
            let ring = (1.0 - at_middle) / (1.0 - cos_max) * 8.0;
            let sector = (direction.dot(t_axis).atan2(direction.dot(s_axis)) / TAU).rem_euclid(1.0) * 8.0;
            counts[(ring as usize).min(7)][(sector as usize).min(7)] += 1;
        }
        assert!(counts.iter().flatten().all(|c| *c == n * n / 64), "{radius} {distance}: {counts:?}");
    }
}

#[test]
fn what_is_drawn_is_what_a_ray_meets_first() {
    let slanted = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
    for (matrix, distance) in [
        (DMat3::IDENTITY, 1.0 + 1e-6),
        (DMat3::IDENTITY, 1.0001),
        (DMat3::IDENTITY, 1.2),
        (DMat3::IDENTITY, 40.0),
        (-DMat3::IDENTITY * 3.0, 5.0),
        (slanted, 2.5),
        (slanted, 30.0),
        (DMat3::from_diagonal(DVec3::new(1.0, 0.05, 4.0)), 6.0),
    ] {
        let s = sphere(DAffine3 { matrix3: matrix, translation: CENTER }, 1.0);
        let eye = CENTER + aside() * distance;
        for u in grid(32) {
            let sample = s.sample_from(eye, u);
            // On the surface to rounding.
            let own = matrix.inverse() * (sample.point - CENTER);
            assert!((own.length() - 1.0).abs() < 1e-12, "{matrix} {distance}: {own}");
            // As any other sample, and with the density that is told of its point.
            let surface = s.surface(sample.point);
            assert!(near(surface.normal, sample.normal, 1e-9) && (surface.uv - sample.uv).abs().max_element() < 1e-5);
            assert!((s.pdf_from(eye, sample.point) / sample.pdf - 1.0).abs() < 1e-7, "{matrix} {distance} {u}");
            // The first point along the way, and not a point behind.
            let segment = Segment { origin: eye, direction: sample.point - eye, t_min: 0.0, t_max: f64::INFINITY };
            let t = s.intersect(&segment).expect("it is there");
            assert!((t - 1.0).abs() < 1e-6, "{matrix} {distance} {u}: {t}");
            let behind = Segment { t_min: 1.0 + 1e-5, ..segment };
            if let Some(t) = s.intersect(&behind).filter(|t| t - 1.0 > 1e-3) {
                assert_eq!(s.pdf_from(eye, segment.at(t)), 0.0, "{matrix} {distance} {u}");
            }
        }
    }
}

/// The integral of the density from `eye` over the image of the unit sphere under `t`: midpoint rule in the angle from the eye, as the map takes it
/// to the unit sphere, denser near to 0, and around that; areas from derivatives of the point.
fn total(s: &dyn Analytic, t: DAffine3, eye: DVec3) -> f64 {
    let (n, m) = (3000, 24);
    let pole = t.inverse().transform_point3(eye).normalize();
    let (a, b) = pole.any_orthonormal_pair();
    let mut sum = 0.0;
    for i in 0..n {
        let x = (f64::from(i) + 0.5) / f64::from(n);
        // alpha = pi x^6
        let (alpha, step) = (PI * x.powi(6), 6.0 * PI * x.powi(5) / f64::from(n));
        for k in 0..m {
            let phi = TAU * (f64::from(k) + 0.5) / f64::from(m);
            let around = a * phi.cos() + b * phi.sin();
            let across = b * phi.cos() - a * phi.sin();
            let p = pole * alpha.cos() + around * alpha.sin();
            let by_alpha = t.matrix3 * (around * alpha.cos() - pole * alpha.sin());
            let by_phi = t.matrix3 * (across * alpha.sin());
            let area = by_alpha.cross(by_phi).length() * step * TAU / f64::from(m);
            sum += s.pdf_from(eye, t.transform_point3(p)) * area;
        }
    }
    sum
}

#[test]
fn densities_integrate_to_one() {
    let slanted = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
    for matrix in [DMat3::IDENTITY, DMat3::IDENTITY * 0.01, slanted] {
        let t = DAffine3 { matrix3: matrix, translation: CENTER };
        let s = sphere(t, 1.0);
        // In units of the radius where there is one; inside, nearly touching it, and far away.
        for distance in [0.0, 0.5, 1.0 + 1e-4, 1.01, 1.5, 5.0, 1e3, 1e6] {
            let eye = t.transform_point3(aside() * distance + DVec3::Z * 1e-9);
            let total = total(&*s, t, eye);
            assert!((total - 1.0).abs() < 2e-4, "{matrix} {distance}: {total}");
        }
    }
}

#[test]
fn far_away_it_is_a_disk() {
    // The points of a disk are alike from far away: so the density by area of the sphere is the cosine over the disk's area.
    for (radius, distance) in [(1.0, 1e4), (1e-3, 1e3), (1e-3, 1e6), (1.0, 1e12), (1e-6, 1e9)] {
        let s = round(radius);
        let eye = CENTER + aside() * distance;
        for u in grid(16) {
            let sample = s.sample_from(eye, u);
            let cos = sample.normal.dot(aside());
            assert!((sample.pdf * PI * radius * radius / cos - 1.0).abs() < 1e-3, "{radius} {distance} {u}: {}", sample.pdf);
            assert!((sample.point - CENTER).dot(aside()) > 0.0);
        }
    }
}

#[test]
fn who_sees_all_of_it_gets_all_of_it() {
    let s = round(0.8);
    for eye in [CENTER, CENTER + aside() * 0.5, CENTER + aside() * 0.8, CENTER + aside() * 0.8 * (1.0 + 1e-10)] {
        for u in grid(8) {
            assert_eq!(s.sample_from(eye, u), s.sample(u));
            let point = s.sample(u).point;
            assert_eq!(s.pdf_from(eye, point), s.pdf(point));
        }
    }
    // Of a part much may be out of sight: it is drawn as before.
    let part = Place::at(DAffine3::from_translation(CENTER)).analytic("sphere", &[float("zmin", 0.2)]);
    let eye = CENTER + aside() * 5.0;
    for u in grid(8) {
        assert_eq!(part.sample_from(eye, u), part.sample(u));
        assert_eq!(part.pdf_from(eye, part.sample(u).point), part.pdf(part.sample(u).point));
    }
}

#[test]
fn nothing_is_without_a_number() {
    let corners = [0.0, 0.5, 1.0 - 1.0 / 16_777_216.0].map(|x| x as f32);
    for radius in [1e-30, 1e-6, 1.0, 1e6, 1e30] {
        let s = round(radius);
        for gap in [-1.0, -1e-9, 0.0, 1e-15, 0.9e-9, 1.1e-9, 1e-6, 1e-4, 1.0, 1e8, 1e20, 1e140] {
            let eye = CENTER + aside() * (radius * (1.0 + gap));
            for u in corners.into_iter().flat_map(|x| corners.map(|y| Vec2::new(x, y))) {
                let sample = s.sample_from(eye, u);
                let told = s.pdf_from(eye, sample.point);
                assert!(sample.point.is_finite() && sample.normal.is_finite(), "{radius} {gap} {u}");
                assert!(sample.pdf >= 0.0 && told >= 0.0, "{radius} {gap} {u}: {} {told}", sample.pdf);
            }
        }
    }
    for eye in [DVec3::NAN, DVec3::INFINITY, DVec3::splat(f64::MAX)] {
        let s = round(1.0);
        let sample = s.sample_from(eye, Vec2::splat(0.3));
        assert_eq!(sample, s.sample(Vec2::splat(0.3)));
        assert_eq!(s.pdf_from(eye, sample.point), s.pdf(sample.point));
    }
}
