//! Wavelengths of samples follow the light of a scene where that pays, and change no mean.

use crate::common;
use crate::common::lights::luminance;
use bhs::lang::Overrides;
use bhs::parts::Windowed;
use bhs::render::Job;
use bhs::wavelengths::drawn;
use bhs_core::spectrum::VisibleWavelengths;

/// A floor under a lamp of two lines, in a picture of the given size.
fn lines([width, height]: [u32; 2], spp: u32, spectrum: &str) -> String {
    format!(
        r#"
        Film "rgb" "integer xresolution" {width} "integer yresolution" {height}
        Sampler "sobol" "integer pixelsamples" {spp}
        LookAt 0 1 -2  0 0 0  0 1 0
        Camera "perspective" "float fov" 20
        WorldBegin
        AttributeBegin
            AreaLightSource "diffuse" "spectrum L" [{spectrum}]
            Translate 0 4 0
            Shape "sphere" "float radius" 0.2
        AttributeEnd
        Rotate -90 1 0 0
        Shape "disk" "float radius" 20
        "#
    )
}

const LINES: &str = "450 0 451 2000 452 0 588 0 589 5000 590 0";
const WHITE: &str = "360 1 830 1";

/// Mean luminance, and the standard deviation of a pixel over it.
fn mean_and_noise(text: &str) -> (f64, f64) {
    let picture = common::render(&common::build(text)).frame.picture();
    let pixels: Vec<f64> = picture.pixels().map(luminance).collect();
    let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
    let variance = pixels.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / pixels.len() as f64;
    (mean, variance.sqrt() / mean)
}

#[test]
fn lamps_with_lines_make_less_noise_and_the_same_light() {
    // So small a picture has the eye's wavelengths.
    let (mean, _) = mean_and_noise(&lines([16, 12], 1 << 14, LINES));
    let (_, plain) = mean_and_noise(&lines([32, 24], 16, LINES));
    let (own, noise) = mean_and_noise(&lines([96, 72], 16, LINES));
    eprintln!("noise of a pixel {noise:.3}, with the eye's wavelengths {plain:.3}; mean {:.4}", own / mean);
    assert!(noise < 0.2 * plain, "{noise} {plain}");
    // The floor is not alike all over: the picture is noisier than its pixels.
    assert!((own / mean - 1.0).abs() < 0.02, "{own} {mean}");
}

#[test]
fn all_else_has_the_eyes_wavelengths() {
    let of = |text: &str| {
        let built = common::build(text);
        let [lo, hi] = built.film.lambda_range();
        (drawn(&Job::of(&built)), VisibleWavelengths::new(lo, hi))
    };
    let inside = "LookAt 278 273 20  278 273 100  0 1 0\nCamera \"perspective\"\nWorldBegin";
    let cornell_box = format!("{inside}\n{}", common::closed_cornell_box());
    for text in [lines([96, 72], 1, WHITE), lines([16, 12], 1, LINES), cornell_box] {
        let (drawn, plain) = of(&text);
        assert_eq!(drawn, plain);
    }
    let (drawn, plain) = of(&lines([96, 72], 1, LINES));
    assert_ne!(drawn, plain);
}

#[test]
fn parts_and_more_samples_have_the_same() {
    let text = lines([96, 72], 1, LINES);
    let whole = common::build(&text);
    let expected = drawn(&Job::of(&whole));
    let film = Windowed::new(&*whole.film, [8, 40, 16, 30]);
    assert_eq!(drawn(&Job { film: &film, first_sample: 7, ..Job::of(&whole) }), expected);
    let more = common::build_with(&text, &Overrides { spp: Some(64), ..Default::default() });
    assert_eq!(drawn(&Job::of(&more)), expected);
}
