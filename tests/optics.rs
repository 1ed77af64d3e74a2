//! What cameras see, against closed forms: rays, blur out of focus, and clocks that differ across a picture.

use crate::common;
use bhs::lang::BuiltScene;
use bhs_core::camera::CameraRay;
use glam::{DVec2, DVec3, Vec2};
use std::f64::consts::PI;

fn camera(options: &str, width: u32, height: u32) -> BuiltScene {
    common::build(&format!(
        "{options}\nFilm \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height}\nWorldBegin\nLightSource \"infinite\""
    ))
}

fn ray(built: &BuiltScene, x: f64, y: f64) -> CameraRay {
    let ray = built.camera.ray(DVec2::new(x, y), Vec2::splat(0.5));
    // In the world's own space.
    CameraRay { origin: ray.origin + built.scene.world.origin, ..ray }
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}

#[test]
fn orthographic_rays_start_side_by_side() {
    // From (1, 2, -3) along +z: x of the picture is +x, up is +y; twice as wide as high, so from -2 to 2.
    let built = camera("LookAt 1 2 -3  1 2 0  0 1 0\nCamera \"orthographic\"", 40, 20);
    for (at, origin) in
        [((0.0, 0.0), (-1.0, 3.0)), ((40.0, 20.0), (3.0, 1.0)), ((20.0, 10.0), (1.0, 2.0)), ((30.0, 5.0), (2.0, 2.5))]
    {
        let r = ray(&built, at.0, at.1);
        assert!(near(r.origin, DVec3::new(origin.0, origin.1, -3.0)) && near(r.direction, DVec3::Z), "{r:?}");
    }
    assert!((built.camera.pixel_width(100.0) - 0.1).abs() < 1e-12);
    let window = camera("Camera \"orthographic\" \"float screenwindow\" [0 4 0 1]", 40, 20);
    assert!(near(ray(&window, 10.0, 0.0).origin, DVec3::new(1.0, 1.0, 0.0)));
    let world = window.scene.world.origin;
    assert!(near(window.camera.position() + world, DVec3::new(2.0, 0.5, 0.0)));
    // Nearest to a point: straight before it, or on the edge of the window.
    let nearest = |x, y, z| window.camera.nearest_origin(DVec3::new(x, y, z) - world) + world;
    assert!(near(nearest(1.5, 0.5, 7.0), DVec3::new(1.5, 0.5, 0.0)));
    assert!(near(nearest(9.0, -3.0, 7.0), DVec3::new(4.0, 0.0, 0.0)));
}

#[test]
fn spherical_cameras_see_all_around() {
    let built = camera("Camera \"spherical\" \"string mapping\" \"equirectangular\"", 40, 20);
    let (half, third) = (0.5f64.sqrt(), 20.0 / 4.0);
    for (x, y, d) in [
        (0.0, 10.0, DVec3::X),
        (10.0, 10.0, DVec3::Z),
        (20.0, 10.0, -DVec3::X),
        (30.0, 10.0, -DVec3::Z),
        (7.0, 0.0, DVec3::Y),
        (3.0, 20.0, -DVec3::Y),
        (10.0, third, DVec3::new(0.0, half, half)),
    ] {
        assert!(near(ray(&built, x, y).direction, d), "{x} {y}: {:?}", ray(&built, x, y));
    }
    // Equal areas: up is in the middle, down in the corners, the horizon on the diagonals between.
    let built = camera("Camera \"spherical\"", 20, 20);
    for (x, y, d) in [
        (10.0, 10.0, DVec3::Y),
        (0.0, 0.0, -DVec3::Y),
        (20.0, 20.0, -DVec3::Y),
        (20.0, 10.0, DVec3::X),
        (10.0, 20.0, DVec3::Z),
        (0.0, 10.0, -DVec3::X),
    ] {
        assert!(near(ray(&built, x, y).direction, d), "{x} {y}: {:?}", ray(&built, x, y));
    }
    let mean: DVec3 =
        (0..10_000).map(|i| ray(&built, 0.2 * f64::from(i % 100) + 0.1, 0.2 * f64::from(i / 100) + 0.1).direction).sum();
    assert!(mean.length() / 10_000.0 < 1e-3, "{mean}");
    assert_eq!(camera("Camera \"spherical\"", 8, 8).camera.position(), DVec3::ZERO);
}

#[test]
fn all_rays_through_a_lens_meet_where_it_is_sharp() {
    for name in ["perspective", "orthographic"] {
        let options = format!("LookAt 1 1 1  2 3 4  0 1 0\nCamera \"{name}\" \"float lensradius\" 0.3 \"float focaldistance\" 4");
        let built = camera(&options, 30, 20);
        let pinhole = camera(&format!("LookAt 1 1 1  2 3 4  0 1 0\nCamera \"{name}\""), 30, 20);
        let forward = DVec3::new(1.0, 2.0, 3.0).normalize();
        let (mut farthest, mut mean) = (0.0f64, DVec3::ZERO);
        for (x, y) in [(3.0, 4.0), (15.0, 10.0), (29.0, 1.0)] {
            let sharp = ray(&pinhole, x, y);
            let focus = sharp.origin + sharp.direction * (4.0 / sharp.direction.dot(forward));
            for i in 0..400 {
                let u = Vec2::new((i % 20) as f32 + 0.5, (i / 20) as f32 + 0.5) / 20.0;
                let r = built.camera.ray(DVec2::new(x, y), u);
                let r = CameraRay { origin: r.origin + built.scene.world.origin, ..r };
                assert!((focus - r.origin).cross(r.direction).length() < 1e-9, "{name} {r:?}");
                let off = r.origin - sharp.origin;
                assert!(off.dot(forward).abs() < 1e-12 && (r.direction.length() - 1.0).abs() < 1e-12);
                farthest = farthest.max(off.length());
                mean += off / 1200.0;
            }
        }
        assert!(farthest > 0.28 && farthest <= 0.3 + 1e-9 && mean.length() < 1e-2, "{name}: {farthest} {mean}");
    }
}

#[test]
fn what_is_out_of_focus_is_blurred_over_the_circle_of_confusion() {
    // An orthographic row of pixels across the edge of a lamp that fills the half x > 0, 3 behind the sharp plane.
    let text = r#"
        Camera "orthographic" "float lensradius" 0.2 "float focaldistance" 1.5 "float screenwindow" [-1 1 -0.05 0.05]
        Film "rgb" "integer xresolution" 20 "integer yresolution" 1
        Sampler "sobol" "integer pixelsamples" 4096
        WorldBegin
        Translate 0 0 4.5
        ReverseOrientation
        AreaLightSource "diffuse" "spectrum L" 1 "bool twosided" true
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [0 -9 0  9 -9 0  9 9 0  0 9 0]
    "#;
    let picture = common::render(&common::build(text)).frame.picture();
    // Radius of the circle: 0.2 (4.5 - 1.5)/1.5. The share of a disk at the signed distance d from its chord, in radii.
    let share = |d: f64| {
        if d <= -1.0 {
            0.0
        } else if d >= 1.0 {
            1.0
        } else {
            0.5 + (d * (1.0 - d * d).sqrt() + d.asin()) / PI
        }
    };
    for x in 0..20 {
        // Mean over the pixel.
        let expected =
            (0..100).map(|i| share((-1.0 + (f64::from(x) + (f64::from(i) + 0.5) / 100.0) * 0.1) / 0.4)).sum::<f64>() / 100.0;
        let p = picture.pixel(x as usize, 0);
        let seen = f64::from(0.212_671 * p[0] + 0.715_160 * p[1] + 0.072_169 * p[2]);
        assert!((seen - expected).abs() < 6e-3, "{x}: {seen} {expected}");
    }
}

#[test]
fn near_a_hole_every_ray_of_an_orthographic_picture_has_an_observer_of_its_own() {
    // Looking away from the hole at a sky of radiance 1: at r, light from far away is brighter by lapse^-5.
    let text = r#"
        LookAt 0 0 0.6  0 0 9  0 1 0
        Camera "orthographic" "float screenwindow" [-3 3 -1 1]
        Film "rgb" "integer xresolution" 12 "integer yresolution" 4 "string layers" ["redshift"]
        Sampler "sobol" "integer pixelsamples" 64
        WorldBegin
        BlackHole "schwarzschild" "float rs" 0.5
        LightSource "infinite" "spectrum L" 1
    "#;
    let built = common::build(text);
    let rendered = common::render(&built);
    let picture = rendered.frame.picture();
    let redshift = &rendered.frame.layers()[0];
    for y in 0..4 {
        for x in 0..12 {
            let mean = |of: &dyn Fn(f64) -> f64| {
                let n = 16;
                let at = |i: u32| {
                    let (dx, dy) = (f64::from(i % n) + 0.5, f64::from(i / n) + 0.5);
                    let o = DVec3::new(-3.0 + 0.5 * (x as f64 + dx / 16.0), 1.0 - 0.5 * (y as f64 + dy / 16.0), 0.6);
                    of((1.0 - 0.5 / o.length()).sqrt())
                };
                (0..n * n).map(at).sum::<f64>() / f64::from(n * n)
            };
            let p = picture.pixel(x, y);
            let seen = f64::from(0.212_671 * p[0] + 0.715_160 * p[1] + 0.072_169 * p[2]);
            let expected = mean(&|lapse| lapse.powi(-5));
            assert!((seen / expected - 1.0).abs() < 0.02, "{x} {y}: {seen} {expected}");
            // Light of the sky is blueshifted: g = 1/lapse.
            let g = redshift.values[y * 12 + x].expect("the sky")[0];
            let expected = mean(&|lapse| 1.0 / lapse);
            assert!((g / expected - 1.0).abs() < 2e-3, "{x} {y}: {g} {expected}");
        }
    }
}

#[test]
fn a_lens_or_a_window_that_reaches_into_the_hole_is_an_error() {
    let errors = |camera: &str| {
        let text = format!(
            "LookAt 0 0 -1 0 0 0 0 1 0\n{camera}\nWorldBegin\nBlackHole \"schwarzschild\" \"point3 center\" [0.8 0 -1] \"float rs\" 0.5\nLightSource \"infinite\""
        );
        let mut sources = bhs::lang::SourceMap::new();
        match bhs::lang::load_text("t", &text, &bhs::registry::Registry::builtin(), &Default::default(), &mut sources) {
            Ok(_) => Vec::new(),
            Err(found) => found.into_iter().map(|d| d.code).collect(),
        }
    };
    assert!(errors("Camera \"perspective\"").is_empty());
    assert!(errors("Camera \"perspective\" \"float lensradius\" 0.2").is_empty());
    assert_eq!(errors("Camera \"perspective\" \"float lensradius\" 0.4"), ["inside-horizon"]);
    assert!(errors("Camera \"orthographic\" \"float screenwindow\" [-0.2 0.2 -0.2 0.2]").is_empty());
    assert_eq!(errors("Camera \"orthographic\""), ["inside-horizon"]);
}

#[test]
fn a_picture_of_one_colour_stays_so_under_every_filter() {
    for filter in ["box", "gaussian", "mitchell", "sinc", "triangle"] {
        let text = format!(
            r#"
            PixelFilter "{filter}"
            Film "rgb" "integer xresolution" 5 "integer yresolution" 5 "float lambdamin" 555 "float lambdamax" 555.001
            WorldBegin
            LightSource "infinite" "spectrum L" 2
        "#
        );
        let picture = common::render(&common::build(&text)).frame.picture();
        let first = picture.pixel(0, 0).to_vec();
        for p in picture.data.chunks_exact(3) {
            assert!(p.iter().zip(&first).all(|(a, b)| (a / b - 1.0).abs() < 1e-3), "{filter}: {p:?} {first:?}");
        }
    }
}
