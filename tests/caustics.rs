//! Light that comes over mirrors and through glass, and is looked for from the lights: against closed forms, and against pictures that find it by
//! chance.
//!
//! `BHS_CAUSTICS=64 cargo test --release --test all caustics:: -- --nocapture --test-threads 1` multiplies the samples, and says what the
//! differences are.

use crate::common;
use crate::common::lights::luminance;
use crate::common::program::Folder;
use bhs::image::Picture;
use bhs::lang::Overrides;
use std::f64::consts::PI;

/// Mean luminance of a picture of the scene, and its standard error over seeds.
fn mean(text: &str, samples: u32) -> (f64, f64) {
    const SEEDS: u64 = 8;
    let means: Vec<f64> = (0..SEEDS)
        .map(|seed| {
            let built = common::build_with(text, &Overrides { spp: Some(samples), seed: Some(seed), ..Default::default() });
            let picture = common::render(&built).frame.picture();
            let pixels = picture.data.chunks_exact(picture.channels.len());
            pixels.map(luminance).sum::<f64>() / (picture.size[0] * picture.size[1]) as f64
        })
        .collect();
    let n = SEEDS as f64;
    let mean = means.iter().sum::<f64>() / n;
    (mean, (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt())
}

/// That the mean of a picture of the scene is what is expected, to 1 % and chance, which is small.
fn shows(text: &str, samples_at_least: u32, expected: f64) {
    let (seen, error) = mean(text, samples(samples_at_least));
    eprintln!("{seen} +- {error}, {expected}");
    assert!(error < 0.03 * expected, "{seen} +- {error}, {expected}");
    assert!((seen - expected).abs() < 0.01 * expected + 4.0 * error, "{seen} +- {error}, {expected}");
}

fn samples(least: u32) -> u32 {
    least * std::env::var("BHS_CAUSTICS").map_or(1, |n| n.parse::<u32>().expect("BHS_CAUSTICS is a number"))
}

/// A camera that looks down on a small part of a grey floor at the origin, along -y from the height of 3; what `world` adds is not in its way.
fn floor(options: &str, world: &str) -> String {
    format!(
        r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16
           {options}
           LookAt 0 3 0  0 0 0  0 0 1
           Camera "perspective" "float fov" 2
           WorldBegin
           Material "diffuse" "spectrum reflectance" 0.5
           Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-8 0 -8  8 0 -8  8 0 8  -8 0 8]
           {world}"#
    )
}

/// A mirror that stands at x = -1, as wide as it is high, and the wall that keeps the light at (1, 1, 0) from shining on the floor's middle itself.
const MIRROR: &str = r#"
    AttributeBegin
        Material "conductor" "spectrum eta" 0.2 "spectrum k" 3
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 -1 -3  -1 -1 3  -1 4 3  -1 4 -3]
    AttributeEnd
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0.5 0.2 -0.4  0.5 0.2 0.4  0.5 0.8 0.4  0.5 0.8 -0.4]"#;

/// Fresnel's reflectance of a metal at the cosine `cos` (Born and Wolf 1999, section 14.2).
fn metal(cos: f64, eta: f64, k: f64) -> f64 {
    let (c2, s2) = (cos * cos, 1.0 - cos * cos);
    let t0 = eta * eta - k * k - s2;
    let a2b2 = (t0 * t0 + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (a2b2 + t0)).max(0.0).sqrt();
    let rs = (a2b2 + c2 - 2.0 * cos * a) / (a2b2 + c2 + 2.0 * cos * a);
    let rp = rs * (c2 * a2b2 + s2 * s2 - 2.0 * cos * a * s2) / (c2 * a2b2 + s2 * s2 + 2.0 * cos * a * s2);
    0.5 * (rs + rp)
}

/// Of a point of light in a plane mirror one sees an image as bright as the mirror lets it be, and so does the floor.
#[test]
fn a_mirror_shows_a_point_light_to_the_floor() {
    let options = r#"LightTransport "path" "integer maxdepth" 2"#;
    let world = format!(r#"{MIRROR} LightSource "point" "spectrum I" 1 "point3 from" [1 1 0]"#);
    // The image is at (-3, 1, 0).
    let distance2 = 10.0f64;
    let cos = 1.0 / distance2.sqrt();
    let expected = 0.5 / PI * metal(3.0 / distance2.sqrt(), 0.2, 3.0) * cos / distance2;
    shows(&floor(options, &world), 128, expected);
}

/// Through a pane with parallel faces light is moved aside and loses what both faces reflect; at right angles it is not moved. A sun alone above it
/// is found in no other way.
#[test]
fn a_pane_lets_the_sun_through() {
    // Of light that is reflected within there are no bounces left, nor of what the pane sends back to the floor.
    let options = r#"LightTransport "path" "integer maxdepth" 4"#;
    // Above the camera, which looks through nothing.
    let world = r#"
        AttributeBegin
            Material "dielectric" "float eta" 1.5
            Translate 0 4 0 Scale 0.3 0.05 0.3
            Shape "trianglemesh" "integer indices" [0 1 2 2 3 0  4 6 5 6 4 7  0 4 5 5 1 0  1 5 6 6 2 1  2 6 7 7 3 2  3 7 4 4 0 3]
                "point3 P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1  -1 1 -1  1 1 -1  1 1 1  -1 1 1]
        AttributeEnd
        LightSource "distant" "spectrum L" 2 "point3 from" [0 1 0] "point3 to" [0 0 0]"#;
    let r = (0.5f64 / 2.5).powi(2);
    let expected = 0.5 / PI * 2.0 * (1.0 - r).powi(2);
    shows(&floor(options, world), 16, expected);
}

/// Water over the floor: light does not get more or less by what it is measured in, though radiance does.
#[test]
fn the_sun_shines_on_the_bottom_of_a_pool() {
    let options = r#"LightTransport "path" "integer maxdepth" 2"#;
    // The camera dives. Light that goes on at 32 degrees comes to the middle of the picture from 2.2 to the side.
    let world = r#"
        AttributeBegin
            Material "dielectric" "float eta" 1.33
            Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [1.9 3.5 -0.3  2.5 3.5 -0.3  2.5 3.5 0.3  1.9 3.5 0.3]
        AttributeEnd
        LightSource "distant" "spectrum L" 2 "point3 from" [1 1 0] "point3 to" [0 0 0]"#;
    let (cos, eta) = (0.5f64.sqrt(), 1.33);
    let inner = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    let [s, p] = [(cos - eta * inner) / (cos + eta * inner), (eta * cos - inner) / (eta * cos + inner)];
    // Beside the water the floor is lit as well.
    let expected = 0.5 / PI * 2.0 * cos * (2.0 - 0.5 * (s * s + p * p));
    shows(&floor(options, world), 16, expected);
}

/// A lamp and its light over a curved mirror and through a glass ball, on a wall, with or without something that bends it.
fn room(spacetime: &str) -> String {
    format!(
        r#"Film "rgb" "integer xresolution" 24 "integer yresolution" 24
           LightTransport "path" "integer maxdepth" 5 "integer rrdepth" 5
           LookAt 0 1.2 4  0 0.4 0  0 1 0
           Camera "perspective" "float fov" 40
           WorldBegin
           {spacetime}
           AttributeBegin
               AreaLightSource "diffuse" "spectrum L" 4
               Translate 0.6 2.4 0 Rotate 90 1 0 0
               Shape "disk" "float radius" 0.5
           AttributeEnd
           Material "diffuse" "spectrum reflectance" 0.5
           Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
           Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -1.5  3 0 -1.5  3 3 -1.5  -3 3 -1.5]
           AttributeBegin
               Material "dielectric" "float eta" 1.5
               Translate 0.5 0.6 0.2 Shape "sphere" "float radius" 0.45
           AttributeEnd
           AttributeBegin
               Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
               Translate -0.8 0.5 0 Shape "sphere" "float radius" 0.45
           AttributeEnd"#
    )
}

/// Mean of the picture's quarters with photons and without, block by block.
fn agrees(name: &str, text: &str) {
    let picture = |caustics: bool, spp: u32, seed: u64| {
        let text = text.replace("\"integer rrdepth\" 5", &format!("\"integer rrdepth\" 5 \"bool caustics\" {caustics}"));
        let built = common::build_with(&text, &Overrides { spp: Some(spp), seed: Some(seed), ..Default::default() });
        common::render(&built).frame.picture()
    };
    const BLOCKS: usize = 3;
    let blocks = |caustics: bool, spp: u32| {
        const SEEDS: u64 = 12;
        let all: Vec<Vec<f64>> = (0..SEEDS)
            .map(|seed| {
                let picture = picture(caustics, spp, seed + if caustics { 0 } else { 100 });
                let side = picture.size[0] / BLOCKS;
                let mut sums = vec![0.0; 3 * BLOCKS * BLOCKS];
                for y in 0..picture.size[1] {
                    for x in 0..picture.size[0] {
                        for c in 0..3 {
                            sums[3 * (y / side * BLOCKS + x / side) + c] +=
                                f64::from(picture.pixel(x, y)[c]) / (side * side) as f64;
                        }
                    }
                }
                sums
            })
            .collect();
        let n = SEEDS as f64;
        let mean: Vec<f64> = (0..all[0].len()).map(|i| all.iter().map(|b| b[i]).sum::<f64>() / n).collect();
        let error = |i: usize| (all.iter().map(|b| (b[i] - mean[i]).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        let error: Vec<f64> = (0..mean.len()).map(error).collect();
        (mean, error)
    };
    let ((a, ea), (b, eb)) = (blocks(true, samples(32)), blocks(false, samples(256)));
    let whole = |v: &[f64]| v.iter().sum::<f64>();
    let noise = |e: &[f64]| e.iter().map(|e| e * e).sum::<f64>().sqrt();
    let (ratio, error) = (whole(&a) / whole(&b), (noise(&ea).hypot(noise(&eb))) / whole(&b));
    let z: Vec<f64> = (0..a.len()).map(|i| (a[i] - b[i]) / (ea[i].hypot(eb[i]) + 1e-9)).collect();
    let worst = (0..a.len()).map(|i| (a[i] / b[i] - 1.0).abs()).fold(0.0, f64::max);
    eprintln!(
        "{name}: {ratio:.5} +- {error:.5}; worst block {:.2} %; z {z:.1?}; errors {:.4} and {:.4}",
        100.0 * worst,
        noise(&ea),
        noise(&eb)
    );
    assert!((ratio - 1.0).abs() < 0.005 + 4.0 * error, "{name}: {ratio} +- {error}");
    for i in 0..a.len() {
        assert!((a[i] - b[i]).abs() < 0.02 * b[i] + 5.0 * ea[i].hypot(eb[i]), "{name}: {i}: {a:?} {b:?} {z:?}");
    }
}

#[test]
fn they_are_what_chance_finds_in_flat_space() {
    agrees("flat", &room(""));
}

#[test]
fn and_around_a_hole() {
    let hole = r#"BlackHole "schwarzschild" "point3 center" [0 1.3 0.2] "float rs" 0.25"#;
    agrees("hole", &room(hole));
    agrees("chart", &room(&format!("{hole} \"bool redshift\" false \"string frame\" \"chart\"")));
}

#[test]
fn and_around_one_that_spins() {
    agrees("kerr", &room(r#"BlackHole "kerr" "point3 center" [0 1.3 0.2] "float rs" 0.25 "float spin" 0.95"#));
}

#[test]
fn and_with_a_mirror_that_moves() {
    let text = room("").replace(
        "Translate -0.8 0.5 0 Shape \"sphere\" \"float radius\" 0.45",
        "Translate -0.8 0.5 0 Rotate -120 1 0 0 Shape \"disk\" \"float radius\" 0.5
         \"string motion\" \"rotating\" \"float omega\" 0.9 \"vector3 axis\" [0 0 1] \"point3 center\" [0 0 0]",
    );
    agrees("moving", &text);
}

/// Skies and colours that part.
#[test]
fn and_of_the_sky_and_through_a_prism() {
    let sky = r#"LightSource "infinite" "rgb L" [0.2 0.2 0.2]"#;
    agrees("sky", &room(sky));
    let prism = room("").replace("\"float eta\" 1.5", "\"spectrum eta\" \"glass-SF11\"");
    agrees("prism", &prism);
}

/// However far the ground reaches, the sun comes to it through a small ball of glass as it does to a small ground.
#[test]
fn a_far_horizon_moves_no_light() {
    let picture = |reach: f64| {
        let ball = r#"AttributeBegin Material "dielectric" Translate 0 0.7 0 Shape "sphere" "float radius" 0.3 AttributeEnd"#;
        let sun = r#"LightSource "distant" "spectrum L" 2 "point3 from" [0 1 0] "point3 to" [0 0 0]"#;
        let text = floor(r#"LightTransport "path" "integer maxdepth" 4"#, &format!("{ball} {sun}"));
        mean(&text.replace("fov\" 2", "fov\" 12").replace('8', &reach.to_string()).replace("LookAt 0 3 0", "LookAt 1 3 0"), 32)
    };
    let ((near, error), (far, of_far)) = (picture(8.0), picture(1e7));
    assert!(near > 0.02, "light is there: {near}");
    assert!((far / near - 1.0).abs() < 0.02 + 4.0 * error.hypot(of_far) / near, "{near} +- {error}, {far} +- {of_far}");
}

/// Photons are those of the wave, whoever follows them and whatever part of the samples is rendered.
#[test]
fn threads_and_parts_change_no_byte() {
    let folder = Folder::new(&room(""));
    let done = |args: &[&str]| {
        let outcome = folder.run(args);
        assert_eq!(outcome.code, 0, "{args:?}: {}", outcome.err);
    };
    done(&["render", "scene.bhs", "--spp", "7", "--threads", "1", "-o", "one.exr"]);
    done(&["render", "scene.bhs", "--spp", "7", "--threads", "3", "-o", "three.exr"]);
    done(&["render", "scene.bhs", "--spp", "7", "--samples", "0..3", "-o", "a.bhspart"]);
    done(&["render", "scene.bhs", "--spp", "7", "--samples", "3..7", "-o", "b.bhspart"]);
    done(&["merge", "-o", "merged.exr", "a.bhspart", "b.bhspart"]);
    let picture = |name: &str| Picture::read_exr(&folder.at(name)).expect("it is there");
    let one = picture("one.exr");
    assert!(one.data.iter().any(|v| *v > 0.0));
    assert!(one == picture("three.exr") && one == picture("merged.exr"));
}
