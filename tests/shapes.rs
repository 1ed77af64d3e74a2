//! Disks, cylinders and bilinear patches around a hole: seen as dense meshes of triangles are, and lighting as they do.

use crate::common;
use glam::DVec3;
use std::fmt::Write;

/// A shape, and the formula of its points over the unit square.
type Formula = (&'static str, fn(f64, f64) -> DVec3);

fn turned(u: f64, r: f64, z: f64, phi_max: f64) -> DVec3 {
    let (sin, cos) = (phi_max.to_radians() * u).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}

const CORNERS: [DVec3; 4] =
    [DVec3::new(-0.6, -0.5, 0.3), DVec3::new(0.6, -0.5, -0.3), DVec3::new(-0.6, 0.5, -0.3), DVec3::new(0.6, 0.5, 0.3)];

const SHAPES: [Formula; 3] = [
    (r#"Shape "disk" "float radius" 0.7 "float innerradius" 0.2 "float phimax" 300 "float height" 0.1"#, |u, v| {
        turned(u, 0.7 + (0.2 - 0.7) * v, 0.1, 300.0)
    }),
    (r#"Shape "cylinder" "float radius" 0.4 "float zmin" -0.5 "float zmax" 0.5 "float phimax" 270"#, |u, v| {
        turned(u, 0.4, v - 0.5, 270.0)
    }),
    (r#"Shape "bilinearmesh" "point3 P" [-0.6 -0.5 0.3  0.6 -0.5 -0.3  -0.6 0.5 -0.3  0.6 0.5 0.3]"#, |u, v| {
        CORNERS[0].lerp(CORNERS[1], u).lerp(CORNERS[2].lerp(CORNERS[3], u), v)
    }),
];

/// A net of triangles over the points of a formula, with its normals.
fn net(point: fn(f64, f64) -> DVec3) -> String {
    let n = 96;
    let at = |i: i32| f64::from(i) / f64::from(n);
    let (mut points, mut normals, mut indices) = (String::new(), String::new(), String::new());
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let (u, v, h) = (at(i), at(j), 1e-6);
        let p = point(u, v);
        let normal = (point(u + h, v) - point(u - h, v)).cross(point(u, v + h) - point(u, v - h)).normalize();
        write!(points, "{:?} {:?} {:?} ", p.x, p.y, p.z).unwrap();
        write!(normals, "{:?} {:?} {:?} ", normal.x, normal.y, normal.z).unwrap();
        if i < n && j < n {
            let k = i * (n + 1) + j;
            write!(indices, "{k} {} {} {k} {} {} ", k + n + 1, k + n + 2, k + n + 2, k + 1).unwrap();
        }
    }
    format!(r#"Shape "trianglemesh" "point3 P" [{points}] "normal N" [{normals}] "integer indices" [{indices}]"#)
}

/// Where the shape stands: behind the hole, slanted and stretched.
fn scene(transport: &str, samples: u32, material: &str, shape: &str) -> String {
    format!(
        r#"LightTransport "{transport}" "integer maxdepth" 1
        Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "float lambdamin" 500 "float lambdamax" 600
        Sampler "sobol" "integer pixelsamples" {samples}
        LookAt 0 0.6 -4  0 0 0  0 1 0  Camera "perspective" "float fov" 40
        WorldBegin
        BlackHole "schwarzschild" "point3 center" [0.1 0.3 -0.5] "float rs" 0.15
        Material "diffuse" "float reflectance" 0.5
        Shape "trianglemesh" "point3 P" [-3 -0.9 -3  3 -0.9 -3  3 -0.9 3  -3 -0.9 3] "integer indices" [0 2 1 0 3 2]
        {material}
        Translate 0 0.2 0.6  Rotate 50 1 0.2 0  Scale 1 1.3 0.8
        {shape}"#
    )
}

fn picture(text: &str) -> Vec<f64> {
    common::render(&common::build(text)).frame.picture().data.into_iter().map(f64::from).collect()
}

#[test]
fn they_look_like_dense_nets_of_triangles() {
    let sky = r#"LightSource "infinite" "float L" 1 Material "conductor" "float roughness" 0.3"#;
    for (shape, point) in SHAPES {
        let [a, b] = [shape.to_owned(), net(point)].map(|s| picture(&scene("path", 16, sky, &s)));
        let mean = a.iter().sum::<f64>();
        let gap = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>() / mean;
        let bias = (b.iter().sum::<f64>() / mean - 1.0).abs();
        assert!(gap < 4e-3 && bias < 1e-3, "{shape}: {gap:e} {bias:e}");
    }
}

#[test]
fn as_lamps_they_light_as_chance_finds_them() {
    let lamp = r#"AreaLightSource "diffuse" "float L" 1"#;
    for (shape, _) in SHAPES {
        let sides: &[&str] = if shape.contains("cylinder") { &["", "ReverseOrientation"] } else { &[""] };
        for side in sides {
            let [aimed, chance] = [("path", 64), ("hemisphere", 1024)]
                .map(|(transport, samples)| picture(&scene(transport, samples, &format!("{lamp} {side}"), shape)));
            let (a, b) = (aimed.iter().sum::<f64>(), chance.iter().sum::<f64>());
            assert!((a / b - 1.0).abs() < 0.02, "{shape} {side}: {}", a / b);
            // The lower rows show the floor alone.
            let floor = |p: &[f64]| p[p.len() * 2 / 3..].iter().sum::<f64>();
            assert!((floor(&aimed) / floor(&chance) - 1.0).abs() < 0.04, "{shape} {side}: {} {}", floor(&aimed), floor(&chance));
        }
    }
}
