//! Bumps in whole scenes: a tilt of the normal is the tilted surface, on every kind of shape, and in the layer of normals.

use crate::common;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::mix64;
use glam::{DQuat, DVec3};
use std::path::Path;

/// A picture of one normal, in its folder.
fn write_map(folder: &Path, n: DVec3) -> String {
    let texel = ((n.normalize() + 1.0) * 0.5).to_array().map(|c| (c as f32).to_le_bytes());
    let path = folder.join("n.pfm");
    std::fs::write(&path, [b"PF\n1 1\n-1\n".as_slice(), &texel.concat()].concat()).expect("writable");
    path.to_str().expect("a path of letters").to_owned()
}

/// The mean of a matt square of reflectance 1 at z = 2 under a sun of irradiance pi that shines along (0, 0.6, 0.8).
fn sunlit(world: &str) -> f64 {
    common::lights::mean(&format!(
        r#"
        Camera "orthographic" "float screenwindow" [-0.1 0.1 -0.1 0.1]
        Film "rgb" "integer xresolution" 4 "integer yresolution" 4
        Sampler "sobol" "integer pixelsamples" 16
        WorldBegin
        LightSource "distant" "rgb L" [3.14159265 3.14159265 3.14159265] "point3 from" [0 0 0] "point3 to" [0 0.6 0.8]
        {world}
        Shape "bilinearmesh" "point3 P" [-1 -1 2  1 -1 2  -1 1 2  1 1 2]
        "#
    ))
}

#[test]
fn a_ramp_is_lit_as_the_plane_that_rises_like_it() {
    // It rises towards the viewer's -z or away from it by `slope` per unit of y; the square is 2 wide.
    for slope in [-0.5, 0.0, 0.3, 0.9f64] {
        let rise = 2.0 * slope;
        // The outer side of the square is +z; the viewer sees the other one. The displaced surface is z = 2 + slope y.
        let found = sunlit(&format!(
            r#"Texture "ramp" "float" "bilerp" "float v00" 0 "float v10" 0 "float v01" {rise} "float v11" {rise}
               Material "diffuse" "float reflectance" 1 "texture displacement" "ramp""#
        ));
        let normal = DVec3::new(0.0, slope, -1.0).normalize();
        let expected = -normal.dot(DVec3::new(0.0, 0.6, 0.8)).min(0.0);
        assert!((found - expected).abs() < 0.01, "{slope}: {found}, not {expected}");
    }
}

#[test]
fn a_normal_map_is_lit_as_the_plane_with_that_normal() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for n in [DVec3::Z, DVec3::new(0.0, 0.5, 1.0), DVec3::new(0.4, -0.3, 1.0)] {
        let path = write_map(folder.path(), n);
        let found = sunlit(&format!(r#"Material "diffuse" "float reflectance" 1 "string normalmap" "{path}""#));
        // The viewer sees the inner side, along whose normal the light comes; dp/du is x, and the frame is right-handed about z.
        let expected = n.normalize().dot(DVec3::new(0.0, 0.6, 0.8)).max(0.0);
        assert!((found - expected).abs() < 0.01, "{n}: {found}, not {expected}");
    }
}

/// Two numbers from -1 to 1.
fn random(i: u64) -> [f64; 2] {
    [2 * i, 2 * i + 1].map(|k| (mix64(k) >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
}

#[test]
fn every_kind_of_shape_tilts_its_normal_in_the_frame_of_its_texture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let n = DVec3::new(0.25, -0.15, 1.0).normalize();
    let path = write_map(folder.path(), n);
    let map = format!(r#"Material "diffuse" "string normalmap" "{path}""#);
    let placed = "Translate 0 0 5 Rotate 20 1 2 3";
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 20f64.to_radians());
    let in_own = |p: DVec3| turn.inverse() * (p - DVec3::new(0.0, 0.0, 5.0));
    // dp/du and the outer normal at a point, in the shape's own coordinates.
    type Frame = fn(DVec3) -> [DVec3; 2];
    let around: Frame = |p| [DVec3::new(-p.y, p.x, 0.0), p];
    let tube: Frame = |p| [DVec3::new(-p.y, p.x, 0.0), DVec3::new(p.x, p.y, 0.0)];
    let flat: Frame = |p| [DVec3::new(-p.y, p.x, 0.0), DVec3::Z];
    let plane: Frame = |_| [DVec3::X, DVec3::Z];
    let square = r#"Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "point2 uv" [0 0  1 0  1 1  0 1] "integer indices" [0 1 2  0 2 3]"#;
    let cases: [(String, Frame); 5] = [
        (format!("{placed}\n{map}\nShape \"sphere\""), around),
        (format!("{placed}\n{map}\nShape \"cylinder\""), tube),
        (format!("{placed}\n{map}\nShape \"disk\""), flat),
        (format!("{placed}\n{map}\n{square}"), plane),
        (format!("{map}\nObjectBegin \"o\"\n{square}\nObjectEnd\n{placed}\nScale 2 2 2\nObjectInstance \"o\""), plane),
    ];
    for (text, frame) in cases {
        let built = common::build(&format!("WorldBegin\nLightSource \"infinite\"\n{text}"));
        let (scene, mut met) = (&built.scene, 0);
        for i in 0..200 {
            let [x, y] = random(i);
            let along = DVec3::new(0.2 * x, 0.2 * y, 1.0).normalize();
            let ray = Ray::new(-scene.world.origin, along);
            let Arrival::Surface(hit) = scene.integrator.trace(&scene.world, &ray).arrival else { continue };
            let [u, out] = frame(in_own(hit.point + scene.world.origin)).map(DVec3::normalize);
            let expected = turn * (u * n.x + out.cross(u) * n.y + out * n.z);
            let found = scene.shading_normal(&hit);
            // Where the view is flat, the normal is turned towards the viewer.
            let side = -(turn * out).dot(along).signum();
            if -expected.dot(along) * side > 0.02 {
                assert!((found - expected).length() < 1e-3, "{text}: {found} {expected}");
                met += 1;
            }
            assert!(found.dot(along) * side < 0.0, "{text}: a normal looks away");
        }
        assert!(met > 20, "{text}: {met}");
    }
}

#[test]
fn grooves_of_metal_reflect_across_themselves() {
    // A brushed disk under a small lamp: rough along u, which runs around, its facets lean along u.
    let built = common::build(
        r#"WorldBegin
        LightSource "infinite"
        Material "conductor" "float uroughness" 0.3 "float vroughness" 0.001
        Translate 0 0 4
        Shape "disk""#,
    );
    let scene = &built.scene;
    let lambda = bhs_core::spectrum::SampledWavelengths::visible(0.5, 360.0, 830.0);
    for i in 0..50 {
        let [x, y] = random(i).map(|v| 0.15 * v);
        let ray = Ray::new(-scene.world.origin, DVec3::new(x, y, 1.0).normalize());
        let Arrival::Surface(hit) = scene.integrator.trace(&scene.world, &ray).arrival else { continue };
        let vertex = scene.vertex(hit, &lambda).expect("flat space");
        let around = DVec3::new(-y, x, 0.0).normalize();
        let [along, _, _] = vertex.axes();
        assert!((along.dot(around).abs() - 1.0).abs() < 1e-6, "{along} {around}");
        let wo = vertex.chart_direction(vertex.wo);
        let off = |axis: DVec3| {
            let facet = (-DVec3::Z + axis * 0.3).normalize();
            let wi = facet * (2.0 * facet.dot(wo)) - wo;
            vertex.material.pdf(&vertex.shading, vertex.wo, vertex.shading_direction(wi))
        };
        let outwards = DVec3::new(x, y, 0.0).normalize();
        assert!(off(around) > 100.0 * off(outwards), "{} {}", off(around), off(outwards));
    }
}
