//! What films, samplers and the layers of samples record, against closed forms.

use crate::common;
use crate::common::lights::luminance;

#[test]
fn equal_energy_has_unit_luminance() {
    let text = r#"
        Film "rgb" "integer xresolution" 1 "integer yresolution" 1
        Sampler "sobol" "integer pixelsamples" 4096
        WorldBegin
        LightSource "infinite" "spectrum L" 1
    "#;
    let picture = common::render(&common::build(text)).frame.picture();
    let p = picture.pixel(0, 0);
    assert!((luminance(p) - 1.0).abs() < 1e-3, "{p:?}");
    // Illuminant E is warmer than sRGB's white.
    assert!(p[0] > 1.15 && (p[1] - 0.948).abs() < 0.01 && (p[2] - 0.909).abs() < 0.01, "{p:?}");
}

#[test]
fn buckets_hold_the_mean_radiance_of_their_part_of_the_spectrum() {
    let text = r#"
        Film "spectral" "integer nbuckets" 5 "float lambdamin" 400 "float lambdamax" 700
            "integer xresolution" 1 "integer yresolution" 1
        Sampler "sobol" "integer pixelsamples" 16384
        WorldBegin
        LightSource "infinite" "spectrum L" [400 1  490 1  490.001 3  700 10]
    "#;
    let picture = common::render(&common::build(text)).frame.picture();
    let names = ["R", "G", "B", "S0.430,000nm", "S0.490,000nm", "S0.550,000nm", "S0.610,000nm", "S0.670,000nm"];
    assert_eq!(picture.channels, names);
    // 1 up to 490 nm, from there a ramp of 7 over 210 nm.
    let ramp = |lambda: f64| 3.0 + 7.0 * (lambda - 490.0) / 210.0;
    let expected = [1.0, 0.5 * (1.0 + ramp(505.0)), ramp(550.0), ramp(610.0), ramp(670.0)];
    for (seen, expected) in picture.pixel(0, 0)[3..].iter().zip(expected) {
        assert!((f64::from(*seen) / expected - 1.0).abs() < 1e-2, "{:?} {expected:?}", picture.pixel(0, 0));
    }
    // The colour is that of the film `rgb`.
    let rgb = text.replace("spectral", "rgb").replace("\"integer nbuckets\" 5", "");
    let plain = common::render(&common::build(&rgb)).frame.picture();
    assert_eq!(plain.data, picture.data[..3]);
}

/// A lamp, brightness 4, that covers the left fifth of one pixel, far away.
fn lamp(sampler: &str, layers: &str) -> String {
    format!(
        r#"
        Film "rgb" "integer xresolution" 1 "integer yresolution" 1 {layers} "float lambdamin" 555 "float lambdamax" 555.01
        {sampler}
        Camera "orthographic" "float screenwindow" [0 1 0 1]
        WorldBegin
        Translate 0 0 3
        AreaLightSource "diffuse" "spectrum L" 4 "bool twosided" true
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-1 -1 0  0.2 -1 0  0.2 2 0  -1 2 0]
    "#
    )
}

#[test]
fn the_variance_is_that_of_the_samples() {
    let built =
        common::build(&lamp(r#"Sampler "independent" "integer pixelsamples" 20000"#, r#""string layers" ["variance" "depth"]"#));
    assert_eq!(built.layers.iter().map(|layer| layer.name).collect::<Vec<_>>(), ["variance", "depth"]);
    let frame = common::render(&built).frame;
    let (picture, layers) = (frame.picture(), frame.layers());
    let variance = layers[0].values[0].expect("samples");
    // A sample is bright with the probability of a fifth: mean m = p b, variance p (1 - p) b^2.
    for c in 0..3 {
        let bright = f64::from(picture.pixel(0, 0)[c]) / 0.2;
        assert!((variance[c] / (0.16 * bright * bright) - 1.0).abs() < 0.05, "{variance:?} {:?}", picture.pixel(0, 0));
    }
    assert!((layers[1].values[0].expect("a lamp")[0] - 3.0).abs() < 1e-6);
    // One sample tells no variance.
    let one = common::build(&lamp(r#"Sampler "independent" "integer pixelsamples" 1"#, r#""string layers" "variance""#));
    assert_eq!(common::render(&one).frame.layers()[0].values[0], None);
}

#[test]
fn a_stratified_pixel_is_nearly_exact() {
    // 5 by 5 cells: a fifth is one column of them, and all lie on one side.
    let text = lamp(r#"Sampler "stratified" "integer xsamples" 5 "integer ysamples" 5"#, "");
    let built = common::build(&text);
    assert_eq!(built.sampler.samples_per_pixel(), 25);
    let bright = common::render(&common::build(&text.replace("0.2 -1 0  0.2 2 0", "2 -1 0  2 2 0"))).frame.picture().data[1];
    let fifth = common::render(&built).frame.picture().data[1];
    assert!((fifth / bright - 0.2).abs() < 1e-3, "{fifth} {bright}");
    let overrides = bhs::lang::Overrides { spp: Some(12), ..Default::default() };
    assert_eq!(common::build_with(&text, &overrides).sampler.samples_per_pixel(), 12);
}

#[test]
fn normals_are_shown_as_colours() {
    // A floor seen from above, and a wall seen from the front.
    let scene = |look: &str, p: &str| {
        let text = format!(
            r#"
            LightTransport "normals"
            Film "rgb" "integer xresolution" 1 "integer yresolution" 1
            Sampler "sobol" "integer pixelsamples" 1024
            LookAt {look}
            Camera "perspective" "float fov" 1
            WorldBegin
            Shape "trianglemesh" "integer indices" [0 1 2] "point3 P" [{p}]
        "#
        );
        common::render(&common::build(&text)).frame.picture().data
    };
    let floor = scene("0 5 0  0 0 0  0 0 1", "-9 0 -9  0 0 18  9 0 -9");
    let up = (floor[1] - 1.0).abs() < 0.02;
    assert!((floor[0] - 0.5).abs() < 0.02 && (up || floor[1].abs() < 0.02) && (floor[2] - 0.5).abs() < 0.02, "{floor:?}");
    let turned = scene("0 5 0  0 0 0  0 0 1", "-9 0 -9  9 0 -9  0 0 18");
    assert!((turned[1] + floor[1] - 1.0).abs() < 0.03, "{turned:?} {floor:?}");
    let wall = scene("0 0 -5  0 0 0  0 1 0", "-9 -9 0  0 18 0  9 -9 0");
    assert!((wall[0] - 0.5).abs() < 0.02 && (wall[1] - 0.5).abs() < 0.02 && (wall[2] - 0.5).abs() > 0.48, "{wall:?}");
}
