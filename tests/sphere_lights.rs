//! Spheres that shine: what they send to a point of a floor, by closed form, and with how much noise light sampling finds it.
//!
//! A sphere of radius R and radiance L, all of it above the horizon, a distance d away in a direction that makes the angle theta with the normal:
//! `E = pi L (R/d)^2 cos(theta)`, and a white matt floor of reflectance rho shines with `rho L (R/d)^2 cos(theta)`.

use crate::common;
use crate::common::lights::luminance;

/// Reflectance of the floor.
const RHO: f64 = 0.8;

/// A floor through 0, seen from the side there, with a light.
fn scene(transport: &str, [resolution, samples]: [u32; 2], light: &str) -> String {
    format!(
        r#"
        LightTransport "path" "integer maxdepth" 1 {transport}
        Sampler "independent" "integer pixelsamples" {samples}
        Film "rgb" "integer xresolution" {resolution} "integer yresolution" {resolution} "float lambdamin" 549 "float lambdamax" 551
        LookAt 5 0.1 0  0 0 0  0 1 0
        Camera "perspective" "float fov" 0.0001
        WorldBegin
        Material "diffuse" "float reflectance" {RHO}
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9]
        Material "diffuse" "float reflectance" 0
        {light}
        "#
    )
}

/// Mean and variance of the pixels, in units of radiance 1.
fn seen(text: &str) -> [f64; 2] {
    let pixels = |text: &str| {
        let picture = common::render(&common::build(text)).frame.picture();
        picture.data.chunks_exact(3).map(luminance).collect::<Vec<_>>()
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let one = mean(&pixels(&scene("", [4, 64], r#"LightSource "infinite" "float L" 1"#))) / RHO;
    let found: Vec<f64> = pixels(text).into_iter().map(|v| v / one).collect();
    let mean_found = mean(&found);
    let squares: Vec<f64> = found.iter().map(|v| (v - mean_found) * (v - mean_found)).collect();
    [mean_found, squares.iter().sum::<f64>() / (found.len() - 1) as f64]
}

/// A sphere light of radiance 1 around `center`.
fn sphere([x, y, z]: [f64; 3], radius: f64, more: &str) -> String {
    format!("Translate {x} {y} {z} AreaLightSource \"diffuse\" \"float L\" 1 {more}\nShape \"sphere\" \"float radius\" {radius}")
}

/// `(R/d)^2 cos(theta)`.
fn form_factor([x, y, z]: [f64; 3], radius: f64) -> f64 {
    let squared = x * x + y * y + z * z;
    radius * radius / squared * y / squared.sqrt()
}

#[test]
fn a_floor_receives_pi_l_times_the_form_factor() {
    for (center, radius) in [
        ([-1.5, 2.0, 0.5], 1.9),
        ([-1.5, 2.0, 0.5], 0.5),
        ([-3.0, 1.0, 2.0], 0.99),
        ([-3.0, 1.0, 2.0], 1e-3),
        ([0.0, 0.501, 0.0], 0.5),
        ([0.0, 0.5005, 0.0], 0.5),
        ([-300.0, 400.0, 0.0], 2.0),
        ([-3e4, 4e4, 0.0], 1e-2),
    ] {
        for emission in ["", "\"bool twosided\" true"] {
            let [found, variance] = seen(&scene("", [16, 64], &sphere(center, radius, emission)));
            let expected = RHO * form_factor(center, radius);
            let error = (variance / 256.0).sqrt();
            eprintln!("{center:?} {radius}: {:.6} of {expected:.4e}, error {:.1e}", found / expected, error / expected);
            assert!((found - expected).abs() < 4.0 * error + 2e-5 * expected, "{center:?} {radius}: {found} {expected}");
            assert!(error < 5e-3 * expected, "{center:?} {radius}: noise {}", error / expected);
        }
        let inwards = format!("ReverseOrientation\n{}", sphere(center, radius, ""));
        assert_eq!(seen(&scene("", [2, 64], &inwards))[0], 0.0, "{center:?}");
    }
}

/// An ellipsoid that is a sphere of radius 1 under a map is seen within the cone in which that sphere is seen from where the map takes the floor's
/// point from: what it sends is compared with what directions find that the material chooses.
#[test]
fn an_ellipsoid_sends_the_same_by_light_sampling_and_without() {
    for shape in [
        "Translate -1.5 2 0.5  Rotate 30 1 0.2 0.5  Scale 1.5 0.2 0.6",
        "Translate 0 0.03 0  Scale 0.3 0.02 0.3",
        "Translate -1 1 0  Rotate 70 0 0 1  Scale 2 0.1 0.1",
        "Translate -1 1 0  Rotate 45 0 0 1  Scale 0.01 1 1",
    ] {
        let light = format!("{shape} AreaLightSource \"diffuse\" \"float L\" 1\nShape \"sphere\"");
        let [with, spread] = seen(&scene("", [16, 256], &light));
        let [without, spread_without] = seen(&scene("\"bool lightsampling\" false", [32, 1024], &light));
        let error = (spread / 256.0 + spread_without / 1024.0).sqrt();
        eprintln!(
            "{shape}: {with:.5} {without:.5}, error {:.1e}, relative variance of a sample {:.3} and {:.3}",
            error / with,
            spread * 256.0 / (with * with),
            spread_without * 1024.0 / (with * with)
        );
        assert!((with - without).abs() < 4.0 * error, "{shape}: {with} {without}");
        assert!(error < 2e-2 * with, "{shape}: {}", error / with);
    }
}

/// Within a sphere that shines inwards a floor sees it in all directions.
#[test]
fn inside_of_a_sphere_all_of_the_floor_is_lit_alike() {
    for light in [
        format!("ReverseOrientation\n{}", sphere([-0.5, 0.3, 0.2], 4.9, "")),
        sphere([-0.5, 0.3, 0.2], 4.9, "\"bool twosided\" true"),
        sphere([0.0, -0.3, 0.0], 4.9, "\"bool twosided\" true"),
    ] {
        // The camera stands within, too.
        let text = scene("", [16, 64], &light).replace("LookAt 5 0.1 0", "LookAt 4 0.08 0");
        let [found, variance] = seen(&text);
        let error = (variance / 256.0).sqrt();
        assert!((found - RHO).abs() < 4.0 * error + 1e-4 && error < 5e-3, "{light}: {found}, error {error}");
    }
}

/// A direction that the material chooses finds the sphere with the probability `p = (R/d)^2 cos(theta)` and then all of its light, so that the
/// variance of a sample over the square of its mean is `1/p - 1`. Points drawn in the cone all bring about as much. Half of those that would be drawn on the
/// whole sphere would bring none: by themselves they would have more than 1.
#[test]
fn light_sampling_leaves_little_noise() {
    for (center, radius, most) in [
        ([-1.5, 2.0, 0.5], 1.9, 0.25),
        ([-1.5, 2.0, 0.5], 1.0, 0.13),
        ([-1.5, 2.0, 0.5], 0.1, 5e-3),
        ([0.0, 2.0, 0.0], 1.0, 0.15),
        ([0.0, 0.55, 0.0], 0.5, 0.07),
        ([-300.0, 400.0, 0.0], 2.0, 1e-5),
    ] {
        let by_chance = 1.0 / form_factor(center, radius) - 1.0;
        let [mean, variance] = seen(&scene("", [64, 1], &sphere(center, radius, "")));
        let found = variance / (mean * mean);
        let [mean, variance] = seen(&scene("\"bool lightsampling\" false", [256, 1], &sphere(center, radius, "")));
        let without = variance / (mean * mean);
        eprintln!("{center:?} {radius}: {found:.2e}, without light sampling {without:.3} (expected {by_chance:.3})");
        assert!(found < most && found < by_chance / 3.0, "{center:?} {radius}: {found}");
        // A sphere that few directions find is found too rarely for its variance to be known.
        let count = 65536.0 * form_factor(center, radius);
        assert!(count < 100.0 || (without / by_chance - 1.0).abs() < 5.0 / count.sqrt(), "{center:?} {radius}: {without}");
    }
}
