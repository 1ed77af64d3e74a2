//! The colours of few samples: what the choice of wavelengths leaves of noise. docs/performance.md has the table that this prints.

use crate::common;
use bhs::lang::BuiltScene;

/// An empty sky of 64 x 64 pixels.
fn sky(sampler: &str, light: &str, seed: u64) -> BuiltScene {
    common::build(&format!(
        r#"Option "integer seed" {seed}
        Film "rgb" "integer xresolution" 64 "integer yresolution" 64
        Sampler {sampler}
        WorldBegin
        LightSource "infinite" {light}"#
    ))
}

/// Means of red, green and blue, and standard deviations over the pixels over them.
fn noise(built: &BuiltScene) -> [[f64; 2]; 3] {
    let picture = common::render(built).frame.picture();
    let n = (picture.size[0] * picture.size[1]) as f64;
    std::array::from_fn(|c| {
        let values = || picture.data.iter().skip(c).step_by(3).map(|v| f64::from(*v));
        let mean = values().sum::<f64>() / n;
        let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        [mean, variance.sqrt() / mean]
    })
}

#[test]
fn sixteen_samples_of_an_empty_sky_are_white() {
    eprintln!("samples  red %  green %  blue %");
    for (samples, most) in [(1, 0.6), (2, 0.08), (4, 0.01), (8, 0.005), (16, 0.001), (64, 1e-4)] {
        let found = noise(&sky(&format!("\"sobol\" \"integer pixelsamples\" {samples}"), "", 1));
        let [r, g, b] = found.map(|[_, noise]| 100.0 * noise);
        eprintln!("{samples:7} {r:6.3} {g:8.3} {b:7.3}");
        for [mean, noise] in found {
            assert!(noise < most && (mean - 1.0).abs() < 2e-4, "{samples}: {found:?}");
        }
    }
    // Counts that are no powers of two; skies of other colours, with a step in the spectrum at worst.
    for (sampler, light, most) in [
        ("\"stratified\" \"integer pixelsamples\" 15", "", 0.002),
        ("\"sobol\" \"integer pixelsamples\" 24", "", 0.01),
        ("\"sobol\" \"integer pixelsamples\" 16", "\"spectrum L\" 1", 0.001),
        ("\"sobol\" \"integer pixelsamples\" 16", "\"rgb L\" [0.8 0.5 0.2]", 0.002),
        ("\"sobol\" \"integer pixelsamples\" 16", "\"blackbody L\" 3000", 0.005),
    ] {
        let found = noise(&sky(sampler, light, 3));
        assert!(found.iter().all(|[_, noise]| *noise < most), "{sampler} {light}: {found:?}");
    }
}

/// Each pixel is unbiased: over many seeds one sample of one pixel has the mean of all wavelengths. In one picture pixels depend on one another.
#[test]
fn seeds_are_independent() {
    let seeds = 3000;
    let mut mean = [0.0; 3];
    for seed in 0..seeds {
        let built = common::build(&format!(
            r#"Option "integer seed" {seed}
            Film "rgb" "integer xresolution" 1 "integer yresolution" 1
            Sampler "sobol" "integer pixelsamples" 1
            WorldBegin
            LightSource "infinite""#
        ));
        let picture = common::render(&built).frame.picture();
        mean.iter_mut().zip(&picture.data).for_each(|(m, v)| *m += f64::from(*v) / f64::from(seeds));
    }
    // Five standard errors of independent seeds.
    let limits = [0.153, 0.031, 0.583].map(|noise: f64| 5.0 * noise / f64::from(seeds).sqrt());
    assert!(mean.iter().zip(limits).all(|(m, limit)| (m - 1.0).abs() < limit), "{mean:?} {limits:?}");
}

/// Dispersion: the wavelength that goes on is spread too, and no part of the range is left out.
#[test]
fn paths_of_one_wavelength_have_all_of_them() {
    use bhs::job::Job;
    use bhs_core::sampling::SampleStream;
    for sampler in ["\"sobol\" \"integer pixelsamples\" 16", "\"stratified\" \"integer pixelsamples\" 16"] {
        let built = sky(sampler, "", 5);
        let job = Job::of(&built);
        for pixel in [[0, 0], [17, 5], [63, 63]] {
            let mut first: Vec<f32> = (0..16).map(|i| SampleStream::new(job.sampler, pixel, i).wavelengths()).collect();
            first.sort_by(f32::total_cmp);
            let around = first[0] + 1.0;
            first.push(around);
            assert!(first.windows(2).all(|pair| pair[1] - pair[0] < 2.0 / 16.0), "{sampler} {pixel:?}: {first:?}");
        }
    }
}
