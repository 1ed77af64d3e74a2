//! What limits the light of one sample: exact where it says so, and without effect where it is off.

use crate::common;

/// The pixels of a scene: red, green and blue of each.
fn pixels(text: &str) -> Vec<[f32; 3]> {
    let picture = common::render(&common::build(text)).frame.picture();
    picture.pixels().map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

/// A bright sky, and nothing else.
fn sky(film: &str) -> String {
    format!(
        "Film {film} \"integer xresolution\" 8 \"integer yresolution\" 6 Sampler \"sobol\" \"integer pixelsamples\" 1
         Camera \"perspective\" WorldBegin LightSource \"infinite\" \"float L\" 5"
    )
}

#[test]
fn no_x_y_or_z_of_a_sample_is_more_than_the_film_takes() {
    let plain = pixels(&sky("\"rgb\""));
    assert!(plain.iter().all(|p| p.iter().any(|v| *v > 2.0)));
    for film in ["\"rgb\"", "\"spectral\" \"integer nbuckets\" 4"] {
        for (clamped, plain) in pixels(&sky(&format!("{film} \"float maxcomponentvalue\" 2"))).iter().zip(&plain) {
            // X, Y and Z of linear sRGB (IEC 61966-2-1).
            let rows = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
            let xyz = rows.map(|row: [f32; 3]| (0..3).map(|c| row[c] * clamped[c]).sum::<f32>());
            let largest = xyz.iter().fold(0.0f32, |a, b| a.max(*b));
            assert!((largest - 2.0).abs() < 2e-3, "{clamped:?}");
            // Darker, and of the same colour.
            let ratio = clamped[0] / plain[0];
            assert!((0..3).all(|c| (clamped[c] - ratio * plain[c]).abs() < 1e-4), "{clamped:?} {plain:?}");
        }
        assert_eq!(pixels(&sky(&format!("{film} \"float maxcomponentvalue\" 1e9"))), plain);
    }
}

/// A closed cube whose walls reflect half of the light and emit 1.
fn cube(transport: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 Sampler \"sobol\" \"integer pixelsamples\" 4
         LookAt 0 0 0  0.2 0.3 1  0 1 0 Camera \"perspective\" LightTransport \"path\" \"integer rrdepth\" 100 {transport} WorldBegin
         Material \"diffuse\" \"float reflectance\" 0.5 AreaLightSource \"diffuse\" \"float L\" 1 \"bool twosided\" true
         Shape \"trianglemesh\" \"point3 P\" [-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1]
            \"integer indices\" [0 1 2 0 2 3  4 5 6 4 6 7  0 1 5 0 5 4  3 2 6 3 6 7  0 3 7 0 7 4  1 2 6 1 6 5]"
    )
}

#[test]
fn indirect_light_is_clamped_and_no_other() {
    let cube = |depth: u32, clamp: f64, nee: bool| {
        pixels(&cube(&format!("\"bool lightsampling\" {nee} \"integer maxdepth\" {depth} \"float clampindirect\" {clamp}")))
    };
    // What each bounce brings is 1, 1/2, 1/4, 1/8, 1/16; from the third on it is indirect.
    let (all, clamped) = (cube(4, 0.0, false), cube(4, 0.1, false));
    for (all, clamped) in all.iter().zip(&clamped) {
        let ratio = (1.0 + 0.5 + 0.1 + 0.1 + 0.0625) / (1.0 + 0.5 + 0.25 + 0.125 + 0.0625);
        assert!((0..3).all(|c| (clamped[c] / all[c] - ratio).abs() < 1e-4), "{clamped:?} {all:?}");
    }
    assert_eq!(cube(1, 0.0, false), cube(1, 0.1, false), "without indirect light");
    assert_eq!(cube(4, 0.0, true), cube(4, 1e9, true), "with a clamp that nothing reaches");
    // Light that is sampled: hardly anything is left of the indirect.
    let (direct, clamped) = (cube(1, 0.0, true), cube(4, 1e-6, true));
    for (direct, clamped) in direct.iter().flatten().zip(clamped.iter().flatten()) {
        assert!((clamped / direct - 1.0).abs() < 1e-4, "{clamped} {direct}");
    }
}

#[test]
fn what_a_mirror_shows_is_not_indirect() {
    let scene = |clamp: f64| {
        format!(
            "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 Sampler \"sobol\" \"integer pixelsamples\" 4
             LookAt 0 0 0  0 0 1  0 1 0 Camera \"perspective\" \"float fov\" 10
             LightTransport \"path\" \"integer maxdepth\" 2 \"float clampindirect\" {clamp} WorldBegin
             AttributeBegin Material \"mirror\" Shape \"bilinearmesh\" \"point3 P\" [-5 -5 2  5 -5 2  -5 5 2  5 5 2] AttributeEnd
             AttributeBegin Material \"diffuse\" Shape \"bilinearmesh\" \"point3 P\" [-9 -9 -3  9 -9 -3  -9 9 -3  9 9 -3] AttributeEnd
             AreaLightSource \"diffuse\" \"float L\" 100 \"bool twosided\" true
             Translate 2 0 -1 Shape \"sphere\" \"float radius\" 0.3"
        )
    };
    let (all, clamped) = (pixels(&scene(0.0)), pixels(&scene(1e-3)));
    assert!(all.iter().flatten().any(|v| *v > 0.1));
    assert_eq!(all, clamped);
}
