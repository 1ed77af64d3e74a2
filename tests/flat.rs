//! Flat truth: closed rooms whose radiance is known, for every light transport and sampler.

mod common;

/// A closed cube whose walls reflect `albedo` and emit 1, seen from an inner point.
fn furnace(albedo: f64, transport: &str, sampler: &str, samples: u32) -> String {
    format!(
        r#"
        LightTransport "{transport}" "integer maxdepth" 60
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

/// Mean luminance of a picture, in units of that of radiance 1 over the film's range.
fn mean(text: &str) -> f64 {
    let luminance = |text: &str| {
        let picture = common::render(&common::build(text)).frame.picture();
        let n = picture.data.len() as f64 / 3.0;
        picture.data.chunks_exact(3).map(|p| 0.212671 * f64::from(p[0]) + 0.715160 * f64::from(p[1]) + 0.072169 * f64::from(p[2])).sum::<f64>() / n
    };
    // The same film and sampler before nothing but walls that emit 1: the spectral sampling cancels.
    let reference = text.replace("\"integer maxdepth\" 60", "\"integer maxdepth\" 0");
    luminance(text) / luminance(&reference)
}

#[test]
fn a_furnace_has_the_radiance_of_the_geometric_series() {
    for (transport, samples) in [("path", 1024), ("hemisphere", 4096)] {
        for sampler in ["independent", "sobol"] {
            let found = mean(&furnace(0.5, transport, sampler, samples));
            assert!((found / 2.0 - 1.0).abs() < 1e-3, "{transport}, {sampler}: {found}");
        }
    }
}

#[test]
fn a_bright_furnace_too() {
    let found = mean(&furnace(0.8, "path", "sobol", 1024));
    assert!((found / 5.0 - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn one_bounce_gives_one_more_term() {
    let text = furnace(0.5, "path", "sobol", 512).replace("\"integer maxdepth\" 60", "\"integer maxdepth\" 1");
    let picture = |t: &str| common::render(&common::build(t)).frame.picture().data.iter().map(|v| f64::from(*v)).sum::<f64>();
    let ratio = picture(&text) / picture(&text.replace("\"integer maxdepth\" 1", "\"integer maxdepth\" 0"));
    assert!((ratio - 1.5).abs() < 1e-3, "{ratio}");
}
