//! Lights that shine from a point: the inverse square law, and near a hole the light that forward tracing finds.

use crate::common;
use crate::common::lights::{floor, random, received};
use bhs::lang::BuiltScene;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::Class;
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::connections::ShadowRay;
use glam::{DVec3, Vec2};
use std::f64::consts::{PI, TAU};

#[test]
fn without_a_hole_the_light_falls_off_with_the_square_of_the_distance() {
    // The light is off to the side.
    let options = r#"LightTransport "path" "integer maxdepth" 1 Sampler "sobol" "integer pixelsamples" 256"#;
    let light = r#"Translate 1 0 0 LightSource "point" "spectrum I" 3 "float scale" 2 "point3 from" [0 1.5 2]"#;
    let seen = floor(options, light);
    // rho/pi I cos/d^2, for an equal-energy spectrum.
    let distance2 = 1.0 + 1.5 * 1.5 + 4.0f64;
    let expected = 0.8 / PI * 6.0 * 1.5 / distance2.sqrt() / distance2;
    assert!((seen / expected - 1.0).abs() < 2e-3, "{seen} {expected}");
}

/// The closed room with a light near a hole, frames static, wavelengths at rest.
fn room() -> BuiltScene {
    let text = r#"
        Integrator "schwarzschild-adaptive" "integer windings" 2
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        Include "scenes/include/camera.bhs"
        WorldBegin
        BlackHole "schwarzschild" "point3 center" [0.1 0.7 0.1] "float rs" 0.2 "bool redshift" false
        LightSource "point" "spectrum I" 1 "point3 from" [-0.2 0.8 0.2]
        Include "scenes/include/room.bhs"
        Shape "trianglemesh" "integer indices" [0 2 1  0 3 2] "point3 P" [-1 0 1   1 0 1   1 1.5 1   -1 1.5 1]
    "#;
    common::build(text)
}

/// Power that arrives on each geometry, per power emitted into all directions: light rays followed from the light.
fn forwards(built: &BuiltScene, rays: u64) -> Vec<f64> {
    let scene = &built.scene;
    let y = scene.light_sampler.lights[0].position().expect("a point light");
    let frame = scene.observer(bhs_core::spacetime::Place::near(y)).expect("outside").frame;
    let mut arrived = vec![0.0; scene.shapes.len()];
    for i in 0..rays {
        // Evenly over the sphere of the observer at the light.
        let z = 2.0 * (i as f64 + 0.5) / rays as f64 - 1.0;
        let (sin, cos) = (TAU * random(i, 1)).sin_cos();
        let local = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
        let ray = Ray::new(y, frame.chart_direction(local));
        if let Arrival::Surface(hit) = scene.integrator.trace(&scene.world, &ray).arrival {
            arrived[hit.geometry as usize] += 4.0 * PI / rays as f64;
        }
    }
    arrived
}

/// The same from light sampling: irradiance over the surfaces, in local measure. Along a bundle dA domega/f is the same at both
/// ends, so that a solid angle at the light is irradiance times area times f(light)/f(surface).
fn backwards(built: &BuiltScene, points: u64) -> Vec<f64> {
    let scene = &built.scene;
    let connections = scene.integrator.connections().expect("the integrator connects");
    let light = (0..).find_map(|i| {
        let sample = scene.sample_light(None, random(i, 0) as f32, Vec2::ZERO)?;
        matches!(sample.source, bhs_engine::light_sampling::LightSource::Point { .. }).then_some(sample)
    });
    let light = light.expect("a point light");
    let lambda = SampledWavelengths::visible(0.5, 360.0, 830.0);
    let Class::Spherical(hole) = scene.world.spacetime().class() else { panic!("a hole") };
    let f = |p: DVec3| 1.0 - hole.rs / (p - hole.center).length();
    received(built, points, |x, normal, observer| {
        let local_normal = observer.frame.local_normal(normal);
        let mut irradiance = 0.0;
        for turn in 0..connections.turns() {
            for c in
                connections.connect(&scene.world, bhs_core::spacetime::Place::near(x), light.place(), turn).into_iter().flatten()
            {
                let cos = observer.frame.local_direction(c.launch).dot(local_normal);
                let start = Ray::new(x + normal * 1e-6 * cos.signum(), c.launch);
                let shadow_ray = ShadowRay { start, from: x, to: light.place(), target: None, connection: c };
                let mut occluded = [false];
                connections.occluded_all(&scene.world, &[shadow_ray], &mut occluded);
                if !occluded[0] {
                    let arriving = scene.light_sampler.arriving(&light, &c, observer, &lambda, &scene.world.conventions);
                    irradiance += f64::from(arriving.emitted[0]) * light.pdf / arriving.density * cos.abs();
                }
            }
        }
        irradiance * f(light.point) / f(x)
    })
}

#[test]
fn near_a_hole_surfaces_receive_what_forward_tracing_brings_them() {
    let built = room();
    let (forwards, backwards) = (forwards(&built, 500_000), backwards(&built, 8_000));
    eprintln!("solid angles, forwards {forwards:.4?}, backwards {backwards:.4?}");
    let total: f64 = forwards.iter().sum();
    assert!(total < 4.0 * PI * 0.98, "some of the light falls into the hole");
    for (a, b) in forwards.iter().zip(&backwards) {
        // Both are good to some 0.5 % (with 2 million rays and 60,000 points they agree to 0.5 %, the noise then).
        assert!((a - b).abs() < 0.02 * a, "{forwards:?} {backwards:?}");
    }
}

#[test]
fn who_cannot_find_it_is_told() {
    let scene = |options: &str, hole: &str| {
        let text = format!("{options}\nWorldBegin\nLightSource \"point\" \"point3 from\" [0 0 3]\n{hole}\nShape \"sphere\"");
        let mut sources = bhs::lang::SourceMap::new();
        let registry = bhs::registry::Registry::builtin();
        bhs::lang::load_text("test.bhs", &text, &registry, &Default::default(), &mut sources)
    };
    let warned = scene("LightTransport \"hemisphere\"\nLookAt 0 0 -5 0 0 0 0 1 0", "").expect("a scene");
    assert!(warned.warnings.iter().any(|d| d.code == "light-not-found"));
    assert!(scene("LookAt 0 0 -5 0 0 0 0 1 0", "").expect("a scene").warnings.is_empty());
    let inside = r#"BlackHole "schwarzschild" "point3 center" [0 0 3.1] "float rs" 0.2"#;
    let Err(found) = scene("LookAt 0 0 -5 0 0 0 0 1 0", inside) else { panic!("a light inside the hole") };
    assert!(found.iter().any(|d| d.code == "inside-horizon"), "{found:?}");
}
