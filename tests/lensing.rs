//! What a hole does to the picture of a small lamp behind it, and what is left of things that reach into it.

use crate::common;
use crate::common::physics::{directions, lapse, swept_to_pericentre};
use bhs_core::ray::{Arrival, Ray};
use std::f64::consts::PI;

/// The angle from the hole (rad) at which a static observer at `camera` sees the ring of what lies exactly behind the hole at `lamp`
/// (in rs): of the orbit that sweeps pi in between, by bisection of its pericentre.
fn ring_angle(camera: f64, lamp: f64) -> f64 {
    let (mut lo, mut hi) = (1.0 / camera.min(lamp), 2.0 / 3.0 - 1e-9);
    for _ in 0..100 {
        let um = 0.5 * (lo + hi);
        let swept = swept_to_pericentre(um, 1.0 / camera) + swept_to_pericentre(um, 1.0 / lamp);
        if swept > PI { hi = um } else { lo = um }
    }
    // b = r sin(alpha)/sqrt(f) at the camera, 1/sqrt(um^2 - um^3) at the pericentre.
    (lapse(camera) / (camera * (lo * lo - lo * lo * lo).sqrt())).asin()
}

#[test]
fn a_lamp_exactly_behind_the_hole_is_a_ring() {
    for (camera, lamp) in [(8.0, 6.0), (20.0, 20.0), (4.0, 30.0)] {
        let theta = ring_angle(camera, lamp);
        let (size, fov) = (240.0, 2.6 * theta.to_degrees());
        let radius = 0.01 * lamp;
        let text = format!(
            r#"
            Integrator "schwarzschild-adaptive"
            LightTransport "path" "integer maxdepth" 0
            Sampler "sobol" "integer pixelsamples" 16
            Film "rgb" "integer xresolution" {size} "integer yresolution" {size}
            LookAt 0 0 {camera}  0 0 0  0 1 0
            Camera "perspective" "float fov" {fov}
            WorldBegin
            BlackHole "schwarzschild" "float rs" 1 "bool redshift" false
            AreaLightSource "diffuse" "spectrum L" 1
            Translate 0 0 -{lamp}
            Shape "sphere" "float radius" {radius}
            "#
        );
        let picture = common::render(&common::build(&text)).frame.picture();
        let (mut sum, mut weight) = (0.0, 0.0);
        for (i, p) in picture.data.chunks_exact(3).enumerate() {
            let (x, y) = (i as f64 % size + 0.5 - 0.5 * size, (i as f64 / size).floor() + 0.5 - 0.5 * size);
            // Each place of the ring counts the same, wherever it is on its circle.
            let r = x.hypot(y);
            if r > 0.25 * size {
                sum += f64::from(p[1]);
                weight += f64::from(p[1]) / r;
            }
        }
        let (found, expected) = (sum / weight, 0.5 * size * theta.tan() / (0.5 * fov).to_radians().tan());
        eprintln!("camera {camera} rs, lamp {lamp} rs: ring of {found:.3} pixels, expected {expected:.3}");
        // A tenth of a pixel; the lamp's own size shifts the middle of the ring in second order only.
        assert!((found - expected).abs() < 0.1, "camera {camera}, lamp {lamp}: {found:.3} pixels, expected {expected:.3}");
    }
}

#[test]
fn what_reaches_into_the_hole_is_seen_down_to_the_horizon() {
    // A lit disc of triangles through the middle of the hole, a lamp that reaches in, glass across the horizon, a ball around the middle.
    let world = r#"
        LightSource "infinite" "spectrum L" 1
        BlackHole "schwarzschild" "float rs" 1
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -4  4 0 -4  4 0 4  -4 0 4]
        Shape "sphere" "float radius" 0.5
        AttributeBegin
          AreaLightSource "diffuse" "tolman L" 3000 "float scale" 1e-3 "bool twosided" true
          Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [0.2 0 0  0 3 0.3  0.4 3 -0.3]
          Translate 0.8 -0.6 0
          Shape "sphere" "float radius" 0.4
        AttributeEnd
        AttributeBegin
          Material "dielectric"
          Translate -0.9 0.5 0.3
          Shape "sphere" "float radius" 0.6
        AttributeEnd
    "#;
    for integrator in ["schwarzschild-exact", "schwarzschild-adaptive", "schwarzschild-rk4"] {
        for transport in ["path", "hemisphere"] {
            let built = common::build(&format!(
                r#"
                Integrator "{integrator}"
                LightTransport "{transport}" "integer maxdepth" 4
                Sampler "sobol" "integer pixelsamples" 16
                Film "rgb" "integer xresolution" 40 "integer yresolution" 30
                LookAt 1 1.5 3  0 0 0  0 1 0
                Camera "perspective" "float fov" 60
                WorldBegin
                {world}
                "#
            ));
            let rendered = common::render(&built);
            let picture = rendered.frame.picture();
            assert!(picture.data.iter().all(|v| v.is_finite()) && rendered.counters.not_finite == 0, "{:?}", rendered.counters);
            // Rays end at the horizon before they end on anything within.
            assert_eq!((rendered.counters.no_static_observer, rendered.counters.out_of_steps), (0, 0), "{integrator}");
            assert!(rendered.counters.captured > 100 && rendered.counters.hit > 10_000);

            let mut least = f64::INFINITY;
            for direction in directions(20_000) {
                let ray = Ray::new(built.camera.position(), direction);
                if let Arrival::Surface(hit) = built.scene.integrator.trace(&built.scene.world, &ray).arrival {
                    let r = hit.point.length();
                    assert!(r > 1.0 && hit.direction.is_finite(), "{integrator}: {hit:?}");
                    least = least.min(r);
                }
            }
            assert!(least < 1.05, "{integrator}: the hit closest to the horizon is at {least} rs");
        }
    }
}
