//! Curved truth: the flat limit, the shadow of a hole, and rooms that light cannot leave.

use crate::common;
use bhs::lang::Overrides;
use bhs_core::geometry::Geometry;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::mix64;
use bhs_engine::stats::Counters;
use glam::DVec3;

/// A small scene with everything that reacts to light: glass, a mirror, gold, diffuse walls, a lamp.
fn room(options: &str, hole: &str) -> String {
    format!(
        r#"
        {options}
        Sampler "sobol" "integer pixelsamples" 8
        Film "rgb" "integer xresolution" 48 "integer yresolution" 36
        Include "scenes/include/camera.bhs"
        WorldBegin
        {hole}
        Include "scenes/include/room.bhs"
        Include "scenes/include/spheres.bhs"
        "#
    )
}

fn bits(text: &str) -> Vec<u32> {
    common::render(&common::build(text)).frame.picture().data.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn no_hole_and_a_hole_of_no_size_give_the_straight_picture_bit_for_bit() {
    let nothing = r#"BlackHole "schwarzschild" "point3 center" [0 0.8 0] "float rs" 0"#;
    let straight = bits(&room(r#"Integrator "straight""#, ""));
    assert!(straight.iter().any(|b| *b != 0));
    assert!(straight == bits(&room("", "")), "no hole, default integrator");
    assert!(straight == bits(&room(r#"Integrator "schwarzschild-rk4""#, "")), "no hole, curved integrator");
    assert!(straight == bits(&room(r#"Integrator "schwarzschild-rk4""#, nothing)), "rs 0, curved integrator");
    assert!(straight == bits(&room("", nothing)), "rs 0, default integrator");
}

#[test]
fn a_small_hole_changes_little_and_a_large_one_much() {
    let hole = |rs: f64| format!(r#"BlackHole "schwarzschild" "point3 center" [0 0.8 0] "float rs" {rs} "bool redshift" false"#);
    let picture = |hole: &str| {
        let text = room(r#"LightTransport "hemisphere""#, hole).replace("pixelsamples\" 8", "pixelsamples\" 2");
        common::render(&common::build(&text)).frame.picture()
    };
    let flat = picture("");
    let distance = |rs: f64| {
        let c = bhs::compare::compare(&picture(&hole(rs)), &flat).expect("same size");
        c.mse
    };
    let (small, large) = (distance(1e-9), distance(0.2));
    assert!(small < 0.2 * large, "{small} {large}");
}

/// Radius [pixels] of the disc that a hole's shadow (seen from `r` rs, looking at it) or the sky (looking away, for r < 1.5 rs)
/// makes in a square picture, and what it should be.
fn shadow(r: f64) -> (f64, f64) {
    let size = 200.0;
    let away = r < 1.5;
    // The shadow's edge: sin(theta) = b_crit sqrt(f)/r from the hole; beyond 90 degrees for r < 1.5 rs.
    let sin = 1.5 * 3f64.sqrt() * (1.0 - 1.0 / r).sqrt() / r;
    let theta = sin.asin();
    let fov = (2.6 * theta.to_degrees()).min(150.0);
    let text = format!(
        r#"
        LightTransport "path" "integer maxdepth" 1
        Sampler "sobol" "integer pixelsamples" 16
        Film "rgb" "integer xresolution" {size} "integer yresolution" {size}
        LookAt 0 0 {r}  0 0 {target}  0 1 0
        Camera "perspective" "float fov" {fov}
        WorldBegin
        BlackHole "schwarzschild" "float rs" 1 "bool redshift" false
        LightSource "infinite" "float L" 1
        "#,
        target = if away { 2.0 * r } else { 0.0 },
    );
    let picture = common::render(&common::build(&text)).frame.picture();
    // Green of an unshifted equal-energy sky is the same in every lit sample up to spectral noise: count by the brightest.
    let lit: f64 = picture.data.chunks_exact(3).map(|p| f64::from(p[0] + p[1] + p[2])).sum();
    let full: f64 = {
        let open = text.replace("\"float rs\" 1 ", "\"float rs\" 0 ");
        let picture = common::render(&common::build(&open)).frame.picture();
        picture.data.chunks_exact(3).map(|p| f64::from(p[0] + p[1] + p[2])).sum()
    };
    let lit_pixels = size * size * lit / full;
    let area = if away { lit_pixels } else { size * size - lit_pixels };
    let expected = 0.5 * size * theta.tan() / (0.5 * fov).to_radians().tan();
    ((area / std::f64::consts::PI).sqrt(), expected)
}

#[test]
fn the_shadow_has_the_radius_that_a_static_observer_sees() {
    for r in [1.2, 2.0, 5.0, 20.0, 100.0] {
        let (found, expected) = shadow(r);
        assert!((found - expected).abs() < 0.1, "r = {r} rs: {found:.3} pixels, expected {expected:.3}");
    }
}

#[test]
fn a_million_rays_do_not_leave_the_closed_cornell_box() {
    // More of them by `BHS_RAYS=10000000 cargo test --release --test all curved::a_million`.
    let wanted = std::env::var("BHS_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(1_000_000);
    let hole = |rs: f64| format!("BlackHole \"schwarzschild\" \"point3 center\" [278 274.4 279.6] \"float rs\" {rs}");
    for (name, hole) in [("flat", String::new()), ("small hole", hole(20.0)), ("large hole", hole(120.0))] {
        let options = "LookAt 278 273 20  278 273 100  0 1 0\nCamera \"perspective\"\nWorldBegin";
        let built = common::build(&format!("{options}\n{hole}\n{}", common::closed_cornell_box()));
        let scene = &built.scene;
        let mut counters = Counters::default();
        let mut follow = |ray: &Ray| {
            let end = scene.integrator.trace(&scene.world, ray);
            counters.add_ray(&end);
            end.arrival
        };
        let random = |i: u64, k: u64| (mix64(mix64(i) ^ k) >> 11) as f64 / (1u64 << 53) as f64;
        let mut rays = 0;
        let mut i = 0;
        while rays < wanted {
            i += 1;
            // Starts half in the room, half on its surfaces, as paths start; directions uniform.
            let origin = DVec3::new(random(i, 0) * 548.0 + 0.5, random(i, 1) * 547.0 + 0.5, random(i, 2) * 558.0 + 0.5);
            let z = 2.0 * random(i, 3) - 1.0;
            let (sin, cos) = (std::f64::consts::TAU * random(i, 4)).sin_cos();
            let direction = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let mut ray = Ray::new(origin - scene.world.origin, direction);
            rays += 1;
            let mut arrival = follow(&ray);
            if let Arrival::Surface(hit) = arrival {
                let surface = scene.world.surface(&hit);
                // Back into the side that it came from.
                let wi =
                    if direction.dot(surface.normal) * hit.direction.dot(surface.normal) > 0.0 { -direction } else { direction };
                ray = scene.world.spawn(&hit, surface.normal, wi);
                rays += 1;
                arrival = follow(&ray);
            }
            assert!(
                matches!(arrival, Arrival::Surface(_) | Arrival::Captured),
                "{name}: ray {i} from {} along {} ends as {arrival:?}",
                ray.origin,
                ray.direction
            );
        }
        assert!(counters.hit > 0 && (name == "flat") == (counters.captured == 0), "{name}: {:?}", counters);
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    // Guided, so that what is learned is the same too.
    let guided = r#"LightTransport "path" "bool guiding" true"#;
    let text = room(guided, r#"BlackHole "schwarzschild" "point3 center" [0 0.8 0] "float rs" 0.1"#);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let built = common::build(&text);
        let picture = pool.install(|| common::render(&built)).frame.picture();
        let mut png = Vec::new();
        bhs::develop::write_png(&mut png, &picture, &built.look, &bhs::develop::Texts::default()).expect("in memory");
        let mut exr = std::io::Cursor::new(Vec::new());
        picture.write_exr(&mut exr, &[]).expect("in memory");
        (png, exr.into_inner())
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert!(with(threads) == one, "{threads} threads");
    }
    // A render leaves nothing behind in the scene.
    let built = common::build(&text);
    let [first, second] = [(), ()].map(|()| common::render(&built).frame.picture().data);
    assert!(first == second);
}

#[test]
fn a_scene_far_from_the_origin_is_the_same_scene() {
    let at = |x: f64| {
        let text = format!(
            r#"
            Sampler "sobol" "integer pixelsamples" 4
            Film "rgb" "integer xresolution" 32 "integer yresolution" 24
            LookAt {x} 0.75 3.18  {x} 0.75 0  0 1 0
            Camera "perspective" "float fov" 40
            WorldBegin
            Translate {x} 0 0
            BlackHole "schwarzschild" "point3 center" [0 0.8 0] "float rs" 0.1
            Include "scenes/include/room.bhs"
            "#
        );
        let built = common::build(&text);
        (common::render(&built).frame.picture(), built)
    };
    let (near, _) = at(0.0);
    let (far, built) = at(65536.0);
    assert!(built.scene.world.origin.length() > 1e4);
    let first = &built.scene.world.geometries[0];
    assert!(matches!(first, Geometry::Mesh(m) if m.positions[0][0].abs() < 10.0));
    let c = bhs::compare::compare(&far, &near).expect("same size");
    assert!(c.mean_ratio.iter().all(|r| (r - 1.0).abs() < 0.02), "{c}");
}

#[test]
fn overrides_reach_the_scene() {
    let text = room("", r#"BlackHole "schwarzschild" "point3 center" [0 0.8 0] "float rs" 0.1"#);
    let o = Overrides { integrator: Some("straight".into()), spp: Some(3), resolution: Some([8, 6]), ..Default::default() };
    let built = common::build_with(&text, &o);
    assert_eq!(built.film.resolution(), [8, 6]);
    assert_eq!(built.sampler.samples_per_pixel(), 3);
    assert!(!built.scene.world.bends());
}
