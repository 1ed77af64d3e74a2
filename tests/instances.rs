//! An object that stands in several places looks as copies of it would: with and without a hole, under either intersector.

use crate::common;
use bhs_core::geometry::Geometry;
use bhs_core::ray::{Arrival, Ray};
use glam::{DAffine3, DVec3};
use std::fmt::Write;

/// A bumpy sphere as a mesh with shading normals, and a ball beside it, in their own material.
fn thing() -> String {
    let (n, m) = (24, 12);
    let (mut points, mut normals, mut indices) = (String::new(), String::new(), String::new());
    for i in 0..=m {
        for j in 0..n {
            let (theta, phi) =
                (std::f64::consts::PI * f64::from(i) / f64::from(m), std::f64::consts::TAU * f64::from(j) / f64::from(n));
            let d = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            let p = d * (1.0 + 0.15 * (5.0 * phi).sin() * theta.sin());
            write!(points, "{:?} {:?} {:?} ", p.x, p.y, p.z).unwrap();
            write!(normals, "{:?} {:?} {:?} ", d.x, d.y, d.z).unwrap();
            if i < m {
                let at = |i: i32, j: i32| i * n + j % n;
                write!(
                    indices,
                    "{} {} {} {} {} {} ",
                    at(i, j),
                    at(i + 1, j + 1),
                    at(i + 1, j),
                    at(i, j),
                    at(i, j + 1),
                    at(i + 1, j + 1)
                )
                .unwrap();
            }
        }
    }
    format!(
        r#"Material "diffuse" "rgb reflectance" [0.8 0.5 0.2]
        Shape "trianglemesh" "point3 P" [{points}] "normal N" [{normals}] "integer indices" [{indices}]
        Material "conductor" "float roughness" 0.1
        Translate 1.2 0 0
        Shape "sphere" "float radius" 0.3"#
    )
}

/// Where it stands: turned, mirrored, large, small.
const PLACES: [&str; 4] = [
    "Translate -1.5 0 1  Scale 0.7 0.7 0.7",
    "Translate 1.2 0.2 0.5  Rotate 40 0 1 0  Rotate 30 1 0 0  Scale -0.5 0.5 0.5",
    "Translate 0 -101 0  Scale 100 100 100  Rotate 30 0 1 0",
    "Translate 0 0.6 -0.3  Rotate 70 1 2 3  Scale 0.01 0.01 0.01  Scale 20 20 20",
];

/// The scene with the object's text `body` as instances or as copies, all moved by `shift`.
fn scene(body: &str, instances: bool, options: &str, world: &str, shift: f64) -> String {
    let mut text = format!(
        r#"{options} Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "float lambdamin" 500 "float lambdamax" 600
        Sampler "sobol" "integer pixelsamples" 16  LightTransport "path" "integer maxdepth" 3
        LookAt {shift} 1 -5  {shift} 0.3 0  0 1 0  Camera "perspective" "float fov" 40
        WorldBegin LightSource "infinite" "float L" 1 {world} "#
    );
    // Defined far from where coordinates begin.
    let defined = "Translate 4000 -300 20";
    if instances {
        write!(text, "AttributeBegin {defined} ObjectBegin \"thing\" {body} ObjectEnd AttributeEnd ").unwrap();
    }
    for place in PLACES {
        let place = format!("Translate {shift} 0 0 {place} Translate -4000 300 -20");
        match instances {
            true => write!(text, "AttributeBegin {place} ObjectInstance \"thing\" AttributeEnd ").unwrap(),
            false => write!(text, "AttributeBegin {place} {defined} {body} AttributeEnd ").unwrap(),
        }
    }
    text
}

/// Mean difference of two pictures relative to the first one's mean, and the share of pixels that differ by more than rounding.
fn difference(a: &str, b: &str) -> (f64, f64) {
    let [a, b] = [a, b].map(|text| common::render(&common::build(text)).frame.picture().data);
    let mean = a.iter().map(|x| f64::from(*x)).sum::<f64>();
    let gap = a.iter().zip(&b).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
    let differ = a.iter().zip(&b).filter(|(a, b)| (**a - **b).abs() > 1e-3 * a.abs().max(0.01)).count();
    (gap / mean, differ as f64 / a.len() as f64)
}

#[test]
fn instances_look_as_copies() {
    let body = thing();
    let hole = r#"BlackHole "schwarzschild" "point3 center" [0.2 1.4 1.2] "float rs" 0.15"#;
    let far = r#"BlackHole "schwarzschild" "point3 center" [100000.2 1.4 1.2] "float rs" 0.15"#;
    for (options, world, shift) in
        [("", "", 0.0), ("", hole, 0.0), ("", far, 1e5), ("Option \"string intersector\" \"reference\"", hole, 0.0)]
    {
        let (gap, share) = difference(&scene(&body, true, options, world, shift), &scene(&body, false, options, world, shift));
        eprintln!("{options} {world} {shift}: {gap:e}, {share:.4} of the pixels differ");
        assert!(gap < 2e-3 && share < 0.03, "{options} {world} {shift}: {gap:e}, {share}");
    }
}

#[test]
fn hits_on_instances_are_exact() {
    let world = r#"BlackHole "schwarzschild" "point3 center" [0.2 1.4 1.2] "float rs" 0.15"#;
    let body = thing();
    let [instances, copies] = [true, false].map(|i| common::build(&scene(&body, i, "", world, 0.0)).scene);
    let is_mesh = |g: &Geometry| matches!(g, Geometry::Instance(_));
    assert_eq!(instances.world.geometries.iter().filter(|g| is_mesh(g)).count(), 4);
    let (mut hits, mut worst, mut differ) = (0, 0.0f64, 0);
    for i in 0..4000 {
        let at = DVec3::new(f64::from(i % 80) / 20.0 - 2.0, f64::from(i / 80) / 25.0 - 0.9, 0.5);
        let ray = Ray::new(DVec3::new(0.0, 1.0, -5.0), (at - DVec3::new(0.0, 1.0, -5.0)).normalize());
        let fates = [&instances, &copies].map(|s| match s.integrator.trace(&s.world, &ray).arrival {
            Arrival::Surface(hit) if s.world.geometries[hit.geometry as usize].triangle_count() > 0 => {
                Some((s.world.surface(&hit), hit))
            }
            _ => None,
        });
        let [Some((s, a)), Some((t, b))] = fates else {
            differ += usize::from(fates[0].is_some() != fates[1].is_some());
            continue;
        };
        // The numbers of the shapes of the copies are those of the four places.
        if a.primitive != b.primitive {
            differ += 1;
            continue;
        }
        hits += 1;
        let corners = instances.world.geometries[a.geometry as usize].corners(a.primitive).unwrap();
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        assert!((a.point - corners[0]).dot(n).abs() < 1e-12, "off its triangle");
        assert!(s.normal.dot(t.normal) > 1.0 - 1e-5 && s.shading_normal.dot(t.shading_normal) > 1.0 - 1e-5);
        // The copies' corners are rounded to single precision, those of the largest near 100.
        worst = worst.max((a.point - b.point).length());
    }
    assert!(hits > 1500 && differ < 20 && worst < 2e-3, "{hits} hits, {differ} differ, {worst:e}");
}

#[test]
fn transforms_nest_as_in_pbrt() {
    // The transform at the definition is a part of the object: an instance multiplies it from the left.
    let scene = common::build(
        r#"WorldBegin LightSource "infinite"
        Translate 1 0 0
        ObjectBegin "a"
          Scale 2 2 2
          AttributeBegin Rotate 90 0 0 1  Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0] AttributeEnd
        ObjectEnd
        # The end restores the state of the beginning.
        Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0]
        Identity
        ObjectInstance "a"
        Scale 1 3 1
        ObjectInstance "a"
        ObjectInstance "b"
        ObjectBegin "b" Shape "sphere" ObjectEnd"#,
    );
    let world = &scene.scene.world;
    let corner = |g: usize, i: usize| world.geometries[g].corners(0).unwrap()[i] + world.origin;
    assert_eq!(world.geometries.len(), 4);
    assert!((corner(0, 1) - DVec3::new(2.0, 0.0, 0.0)).length() < 1e-6);
    let instances = [2, 3].map(|g| [0, 1, 2].map(|i| corner(g, i)));
    let own = DAffine3::from_translation(DVec3::X) * DAffine3::from_scale(DVec3::splat(2.0));
    for (found, stretch) in instances.into_iter().zip([1.0, 3.0]) {
        for (found, p) in found.into_iter().zip([DVec3::ZERO, DVec3::Y, DVec3::NEG_X]) {
            let expected = DVec3::new(1.0, stretch, 1.0) * own.transform_point3(p);
            assert!((found - expected).length() < 1e-6, "{found} {expected}");
        }
    }
    // Shapes keep the numbers of their directives: the ball of `b` is the third one.
    assert_eq!(scene.scene.shapes.iter().map(|s| s.index).collect::<Vec<_>>(), [1, 2, 0, 0]);
    assert_eq!((scene.load.shapes, scene.load.instances, scene.load.triangles), (3, 3, 2));
}
