//! Flat truth: closed rooms whose radiance is known, for every light transport and sampler.

use crate::common;

/// A closed cube whose walls reflect `albedo` and emit 1, seen from an inner point.
fn furnace(albedo: f64, transport: &str, sampler: &str, samples: u32) -> String {
    // Long enough for what is left out to be below 3e-5.
    let depth = (f64::ln(1e-5) / albedo.ln()).ceil();
    format!(
        r#"
        LightTransport "{transport}" "integer maxdepth" {depth}
        Sampler "{sampler}" "integer pixelsamples" {samples}
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16 "float lambdamin" 500 "float lambdamax" 600
        LookAt 0.2 0.1 -0.3  0 0 1  0 1 0
        Camera "perspective" "float fov" 90
        WorldBegin
        Material "diffuse" "float reflectance" {albedo}
        AreaLightSource "diffuse" "float L" 1
        # Normals point inwards.
        ReverseOrientation
        Shape "trianglemesh"
            "point3 P" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1]
            "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  2 3 7 2 7 6  0 4 7 0 7 3  1 2 6 1 6 5]
        "#
    )
}

/// The same scene with another `maxdepth`.
fn with_depth(text: &str, depth: u32) -> String {
    let (before, after) = text.split_once("\"integer maxdepth\" ").expect("it has one");
    let rest = after.trim_start_matches(|c: char| c.is_ascii_digit());
    format!("{before}\"integer maxdepth\" {depth}{rest}")
}

/// Mean luminance of a picture, in units of that of radiance 1 over the film's range.
fn mean(text: &str) -> f64 {
    let luminance = |text: &str| {
        let picture = common::render(&common::build(text)).frame.picture();
        let n = picture.data.len() as f64 / 3.0;
        picture
            .data
            .chunks_exact(3)
            .map(|p| 0.212671 * f64::from(p[0]) + 0.715160 * f64::from(p[1]) + 0.072169 * f64::from(p[2]))
            .sum::<f64>()
            / n
    };
    // The same film and sampler before nothing but walls that emit 1: the spectral sampling cancels.
    luminance(text) / luminance(&with_depth(text, 0))
}

#[test]
fn a_furnace_has_the_radiance_of_the_geometric_series() {
    for (transport, samples) in [("path", 2048), ("hemisphere", 4096)] {
        for sampler in ["independent", "sobol"] {
            let found = mean(&furnace(0.5, transport, sampler, samples));
            assert!((found / 2.0 - 1.0).abs() < 1e-3, "{transport}, {sampler}: {found}");
        }
    }
}

#[test]
fn a_bright_furnace_too() {
    let found = mean(&furnace(0.8, "path", "sobol", 4096));
    assert!((found / 5.0 - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn one_bounce_gives_one_more_term() {
    let text = furnace(0.5, "path", "sobol", 512);
    let ratio = mean(&with_depth(&text, 1));
    assert!((ratio - 1.5).abs() < 1e-3, "{ratio}");
}
