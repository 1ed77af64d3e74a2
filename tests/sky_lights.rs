//! Lights infinitely far away: closed forms in flat space, and around a hole the light that forward tracing finds.

use crate::common;
use crate::common::lights::{floor, luminance, mean, random, received};
use bhs::image::{Frame, Picture};
use bhs::lang::BuiltScene;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::Class;
use bhs_core::spectrum::SampledWavelengths;
use glam::{DVec3, Vec2};
use std::f64::consts::{PI, TAU};

const SAMPLED: &str = r#"LightTransport "path" "integer maxdepth" 1 Sampler "sobol" "integer pixelsamples" 4096"#;
const BY_CHANCE: &str =
    r#"LightTransport "path" "integer maxdepth" 1 "bool lightsampling" false Sampler "sobol" "integer pixelsamples" 16384"#;

#[test]
fn a_distant_light_lights_by_the_cosine() {
    let quick = r#"LightTransport "path" "integer maxdepth" 1 Sampler "sobol" "integer pixelsamples" 256"#;
    for (y, cos) in [(1.0, 1.0 / 3.0), (4.0, 4.0 / 24f64.sqrt()), (-1.0, 0.0)] {
        let light =
            format!(r#"LightSource "distant" "spectrum L" 3 "float scale" 2 "point3 from" [2 {y} 2] "point3 to" [0 0 0]"#);
        let seen = floor(quick, &light);
        assert!((seen - 0.8 / PI * 6.0 * cos).abs() < 2e-3 * seen + 1e-9, "{y}: {seen}");
    }
    // What stands in its way shadows.
    let blocked = r#"LightSource "distant" "point3 from" [0 1 1] "point3 to" [0 0 0]
        Translate 0 2 2 Shape "sphere" "float radius" 0.5"#;
    assert_eq!(floor(quick, blocked), 0.0);
}

/// A sky of 8 by 4 pixels, most of it dim, one of them a sun; in the folder of the test program's own.
fn sky_file(name: &str, pixel: impl Fn(usize, usize) -> [f32; 3]) -> String {
    let (width, height) = (8, 4);
    let data = (0..width * height).flat_map(|i| pixel(i % width, i / width)).collect();
    let size = [width, height];
    let picture =
        Picture { size, frame: Frame { offset: [0, 0], size }, channels: ["R", "G", "B"].map(str::to_owned).to_vec(), data };
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.exr"));
    picture.write_exr(std::fs::File::create(&path).expect("a file"), &[]).expect("a picture");
    path.to_str().expect("a plain path").to_owned()
}

fn sunny(x: usize, y: usize) -> [f32; 3] {
    if (x, y) == (1, 1) { [200.0, 150.0, 100.0] } else { [0.2 + 0.1 * x as f32, 0.3, 0.1 + 0.1 * y as f32] }
}

/// Irradiance that the pixels above the horizon of the sky bring, as luminance: exact, patch by patch. `up`: which axis of the picture.
fn irradiance(pixel: impl Fn(usize, usize) -> [f32; 3]) -> f64 {
    let mut sum = 0.0;
    for y in 0..2 {
        let [a, b] = [y, y + 1].map(|y| (PI * y as f64 / 4.0).sin().powi(2));
        for x in 0..8 {
            sum += luminance(&pixel(x, y)) * (b - a) / 2.0 * TAU / 8.0;
        }
    }
    sum
}

#[test]
fn a_pictured_sky_lights_by_what_is_in_the_picture() {
    let file = sky_file("sunny", sunny);
    // The picture's z axis points up.
    let light = format!(r#"Rotate -90 1 0 0 LightSource "infinite" "string filename" "{file}" "float scale" 0.5"#);
    let expected = 0.8 / PI * 0.5 * irradiance(sunny);
    let seen = floor(SAMPLED, &light);
    assert!((seen / expected - 1.0).abs() < 5e-3, "{seen} {expected}");
    let by_chance = floor(BY_CHANCE, &light);
    assert!((by_chance / expected - 1.0).abs() < 2e-2, "{by_chance} {expected}");
    let scaled =
        floor(SAMPLED, &format!(r#"Rotate -90 1 0 0 LightSource "infinite" "string filename" "{file}" "float illuminance" 7"#));
    assert!((scaled / (0.8 / PI * 7.0) - 1.0).abs() < 5e-3, "{scaled}");
}

#[test]
fn the_mean_over_all_directions_is_the_pictures() {
    let file = sky_file("mean", sunny);
    let seen = mean(&format!(
        r#"
        Camera "perspective" "float fov" 90
        Film "rgb" "integer xresolution" 64 "integer yresolution" 64
        Sampler "independent" "integer pixelsamples" 200
        WorldBegin
        LightSource "infinite" "string filename" "{file}"
    "#
    ));
    // What a pinhole sees of it by quadrature, with the pixel that a direction falls on looked up here.
    let n = 2048;
    let expected = (0..n * n).map(|k| {
        let (x, y) = ((2 * (k % n) + 1) as f64 / n as f64 - 1.0, 1.0 - (2 * (k / n) + 1) as f64 / n as f64);
        let d = DVec3::new(x, y, 1.0).normalize();
        let (phi, theta) = (d.y.atan2(d.x).rem_euclid(TAU), d.z.acos());
        luminance(&sunny((phi / TAU * 8.0) as usize, (theta / PI * 4.0) as usize)) / (n * n) as f64
    });
    let expected: f64 = expected.sum();
    assert!((seen / expected - 1.0).abs() < 1e-2, "{seen} {expected}");
}

/// A floor and a wall beside a hole; frames static, wavelengths at rest.
fn around_a_hole(light: &str, transport: &str) -> String {
    format!(
        r#"
        Integrator "schwarzschild-adaptive"
        {transport}
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        LookAt 0 1.2 -5  0 0 0  0 1 0
        Camera "perspective" "float fov" 45
        WorldBegin
        BlackHole "schwarzschild" "float rs" 0.3 "bool redshift" false
        {light}
        Material "diffuse" "spectrum reflectance" 0.8
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-2 -1 -1  2 -1 -1  2 -1 3  -2 -1 3]
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-2 -1 3  2 -1 3  2 2 3  -2 2 3]
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-1.2 -1 -1  -1.2 -1 1  -1.2 1 1  -1.2 1 -1]
    "#
    )
}

/// Area across the light, far away, of the rays that arrive on each geometry: parallel rays followed from there.
fn forwards(built: &BuiltScene, direction: DVec3, rays: u64) -> Vec<f64> {
    let scene = &built.scene;
    let (a, b) = direction.any_orthonormal_pair();
    let (half, far) = (6.0, 3000.0);
    let mut arrived = vec![0.0; scene.shapes.len()];
    for i in 0..rays {
        let (s, t) = (half * (2.0 * (i as f64 + 0.5) / rays as f64 - 1.0), half * (2.0 * random(i, 1) - 1.0));
        let ray = Ray::new(direction * far + a * s + b * t, -direction);
        if let Arrival::Surface(hit) = scene.integrator.trace(&scene.world, &ray).arrival {
            arrived[hit.geometry as usize] += 4.0 * half * half / rays as f64;
        }
    }
    arrived
}

/// The same from light sampling: irradiance over the surfaces, in local measure. Along a bundle dA domega/f is the same at both ends,
/// so that an area far away is irradiance times area over f.
fn backwards(built: &BuiltScene, points: u64) -> Vec<f64> {
    let scene = &built.scene;
    let connections = scene.integrator.connections().expect("the integrator connects");
    let light = scene.sample_light(None, 0.5, Vec2::splat(0.5)).expect("a light");
    let lambda = SampledWavelengths::visible(0.5, 360.0, 830.0);
    let Class::Spherical(hole) = scene.world.spacetime().class() else { panic!("a hole") };
    received(built, points, |x, normal, observer| {
        let local_normal = observer.frame.local_normal(normal);
        let mut irradiance = 0.0;
        for c in connections
            .connect_sky(&scene.world, bhs_core::spacetime::Place::near(x), (light.point, light.side), 0)
            .into_iter()
            .flatten()
        {
            let cos = observer.frame.local_direction(c.launch).dot(local_normal);
            let start = Ray::new(x + normal * 1e-6 * cos.signum(), c.launch);
            let mut escaped = [false];
            scene.integrator.escape_all(&scene.world, &[(start, light.side)], &mut escaped);
            if escaped[0] {
                let arriving = scene.light_sampler.arriving(&light, &c, observer, &lambda, &scene.world.conventions);
                irradiance += f64::from(arriving.emitted[0]) * light.pdf / arriving.density * cos.abs();
            }
        }
        irradiance / (1.0 - hole.rs / (x - hole.center).length())
    })
}

#[test]
fn around_a_hole_surfaces_receive_what_forward_tracing_brings_them() {
    // From behind the camera and a little above: some of the light passes the hole on its way to the wall.
    let text = around_a_hole(r#"LightSource "distant" "point3 from" [0.3 0.4 -1] "point3 to" [0 0 0]"#, "");
    let built = common::build(&text);
    let direction = DVec3::new(0.3, 0.4, -1.0).normalize();
    let (forwards, backwards) = (forwards(&built, direction, 600_000), backwards(&built, 20_000));
    eprintln!("areas, forwards {forwards:.4?}, backwards {backwards:.4?}");
    for (a, b) in forwards.iter().zip(&backwards) {
        // One ray stands for this area; what is left of the noise of few rays, and that of the points.
        let noise = (a * 144.0 / 600_000.0f64).sqrt();
        assert!((a - b).abs() < 3.5 * noise + 5e-3 * a, "{forwards:?} {backwards:?}");
    }
}

#[test]
fn around_a_hole_a_pictured_sky_is_as_bright_aimed_at_as_by_chance() {
    let file = sky_file("hole", sunny);
    let light = format!(r#"Rotate 60 0 1 1 LightSource "infinite" "string filename" "{file}""#);
    let of = |aims: bool, samples: u32| {
        let transport = format!(
            r#"LightTransport "path" "integer maxdepth" 3 "bool lightsampling" {aims}
            Sampler "independent" "integer pixelsamples" {samples}"#
        );
        mean(&around_a_hole(&light, &transport))
    };
    let (aimed, by_chance) = (of(true, 1000), of(false, 8000));
    eprintln!("aimed {aimed:.4}, by chance {by_chance:.4}");
    assert!((aimed / by_chance - 1.0).abs() < 0.015, "{aimed} {by_chance}");
}

#[test]
fn who_cannot_find_a_distant_light_is_told() {
    let text = "LightTransport \"hemisphere\"\nWorldBegin\nLightSource \"distant\"\nTranslate 0 0 3\nShape \"sphere\"";
    assert!(common::build(text).warnings.iter().any(|d| d.code == "light-not-found"));
    assert!(common::build(&text.replace("hemisphere", "path")).warnings.is_empty());
}
