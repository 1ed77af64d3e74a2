//! Adaptive sampling: pixels get samples until their noise is as low as is asked for, and no mean changes.

use crate::common;
use crate::common::lights::luminance;
use crate::common::process::Folder;
use bhs::image::Picture;
use bhs::lang::Overrides;
use bhs::render::Rendered;

/// A wall that a small lamp lights, with a glossy ball, the sky beside it and shadows: noise differs from place to place.
fn scene(sampler: &str) -> String {
    format!(
        r#"
        Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "string layers" "samples"
        Sampler {sampler}
        LookAt 0 1 -4  0 0.7 0  0 1 0
        Camera "perspective" "float fov" 60
        LightTransport "path" "integer maxdepth" 4
        WorldBegin
        LightSource "infinite" "float scale" 0.2
        AttributeBegin
            AreaLightSource "diffuse" "float L" 20
            Translate 1.5 2.5 0
            # All but a cap too small to be seen: of a part points are drawn by area, which leaves the noise that these tests are about.
            Shape "sphere" "float radius" 0.3 "float zmin" -0.29999
        AttributeEnd
        AttributeBegin
            Material "conductor" "float roughness" 0.15
            Translate 0 0.5 0
            Shape "sphere" "float radius" 0.5
        AttributeEnd
        Rotate -90 1 0 0
        Shape "disk" "float radius" 3
        "#
    )
}

fn picture(rendered: &Rendered) -> Picture {
    rendered.frame.picture().with_layers(&rendered.frame.layers())
}

/// Renders the scene with a sampler and a seed.
fn rendered(sampler: &str, seed: u64) -> Rendered {
    common::render(&common::build_with(&scene(sampler), &Overrides { seed: Some(seed), ..Default::default() }))
}

/// Luminance and number of samples of each pixel.
fn pixels(rendered: &Rendered) -> Vec<[f64; 2]> {
    let picture = picture(rendered);
    let at = picture.channels.iter().position(|name| name == "samples").expect("the layer is there");
    picture.pixels().map(|p| [luminance(p), f64::from(p[at])]).collect()
}

#[test]
fn the_true_error_is_as_low_as_is_asked_for() {
    let reference = pixels(&rendered(r#""sobol" "integer pixelsamples" 16384"#, 1));
    let mean = reference.iter().map(|[l, _]| l).sum::<f64>() / reference.len() as f64;
    for (noise, sampler) in [(0.02, "sobol"), (0.05, "sobol"), (0.05, "independent")] {
        let rendered = rendered(&format!("\"{sampler}\" \"float noise\" {noise}"), 2);
        let own = pixels(&rendered);
        let error = |(a, r): (&[f64; 2], &[f64; 2])| ((a[0] - r[0]) / r[0].max(0.02 * mean)).powi(2);
        let rms = (own.iter().zip(&reference).map(error).sum::<f64>() / own.len() as f64).sqrt();
        let [least, most] = [f64::min, f64::max].map(|f| own.iter().map(|p| p[1]).reduce(f).unwrap_or(0.0));
        let samples: f64 = own.iter().map(|p| p[1]).sum();
        eprintln!(
            "{sampler} {noise}: true error {rms:.4}, {least} to {most} samples, {:.1} on average",
            samples / own.len() as f64
        );
        assert!((0.5 * noise..1.5 * noise).contains(&rms), "{sampler} {noise}: {rms}");
        assert!(least == 16.0 && most > 4.0 * least, "{least} to {most}");
        assert_eq!(samples as u64, rendered.frame.samples());
        assert_eq!((f64::from(rendered.samples), f64::from(rendered.most_samples)), (least, most));
        let found = rendered.noise.expect("it was asked for");
        assert!(found.above == 0 && (0.4..1.3).contains(&(rms / found.rms)), "{rms} {found:?}");
    }
}

#[test]
fn of_the_picture_as_a_whole_it_takes_fewer_samples() {
    let reference = pixels(&rendered(r#""sobol" "integer pixelsamples" 16384"#, 1));
    let mean = reference.iter().map(|[l, _]| l).sum::<f64>() / reference.len() as f64;
    // True mean square error, and samples of all pixels.
    let measured = |sampler: &str, seed: u64| {
        let rendered = rendered(sampler, seed);
        let own = pixels(&rendered);
        let error = |(a, r): (&[f64; 2], &[f64; 2])| ((a[0] - r[0]) / r[0].max(0.02 * mean)).powi(2);
        let square = own.iter().zip(&reference).map(error).sum::<f64>() / own.len() as f64;
        (square, rendered.frame.samples() as f64, rendered)
    };
    for (noise, sampler) in [(0.03, "sobol"), (0.06, "independent")] {
        let over = |what: &str| format!("\"{sampler}\" \"float noise\" {noise} \"string noiseover\" \"{what}\"");
        let (square, samples, rendered) = measured(&over("picture"), 2);
        let rms = square.sqrt();
        assert!((0.5 * noise..1.5 * noise).contains(&rms), "{sampler} {noise}: {rms}");
        let found = rendered.noise.expect("it was asked for");
        assert!(found.above == 0 && (0.6..1.4).contains(&(rms / found.rms)), "{rms} {found:?}");
        let (_, of_each, _) = measured(&over("pixel"), 2);
        // As many samples everywhere leave more noise than those that went where it was.
        let equal = (samples / reference.len() as f64).round();
        let (even, _, _) = measured(&format!("\"{sampler}\" \"integer pixelsamples\" {equal}"), 2);
        eprintln!(
            "{sampler} {noise}: true error {rms:.4}, {equal} samples; {:.4} if even; {:.2} of the samples",
            even.sqrt(),
            samples / of_each
        );
        assert!(samples < 0.8 * of_each && even > 1.15 * square, "{sampler}: {samples} {of_each} {even} {square}");
    }
}

#[test]
fn no_mean_changes() {
    // Independent samples, few of them, and much noise: what depends on the samples themselves shows here. `BHS_SEEDS` has more.
    let seeds: u64 = std::env::var("BHS_SEEDS").ok().and_then(|n| n.parse().ok()).unwrap_or(64);
    let mean = |rendered: Rendered| {
        let own = pixels(&rendered);
        own.iter().map(|[l, _]| l).sum::<f64>() / own.len() as f64
    };
    let of = |sampler: &str| {
        let means: Vec<f64> = (0..seeds).map(|seed| mean(rendered(sampler, 100 + seed))).collect();
        let average = means.iter().sum::<f64>() / seeds as f64;
        let variance = means.iter().map(|m| (m - average).powi(2)).sum::<f64>() / (seeds - 1) as f64;
        (average, (variance / seeds as f64).sqrt())
    };
    let (fixed, error) = of(r#""independent" "integer pixelsamples" 128"#);
    for sampler in [r#""independent" "float noise" 0.1"#, r#""independent" "float noise" 0.06 "string noiseover" "picture""#] {
        let (adaptive, adaptive_error) = of(sampler);
        let (ratio, error) = (adaptive / fixed, error.hypot(adaptive_error) / fixed);
        eprintln!("mean with adaptive sampling over that without: {ratio:.5} +- {error:.5}: {sampler}");
        assert!(error < 0.001 && (ratio - 1.0).abs() < 0.001 + 2.0 * error, "{ratio} +- {error}");
    }
}

#[test]
fn threads_change_no_byte_and_the_number_of_samples_ends_it() {
    let built = common::build(&scene(r#""sobol" "float noise" 0.03"#));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| common::render(&built))
    };
    assert!(picture(&with(1)).same_channels(&picture(&with(3))));
    let capped = rendered(r#""sobol" "float noise" 0.001 "integer pixelsamples" 50"#, 0);
    assert_eq!(capped.most_samples, 50);
    assert!(capped.noise.is_some_and(|found| found.above > 0));
    // A picture without noise ends at once, a black one too.
    for sky in [1.0, 0.0] {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 20 Sampler \"sobol\" \"float noise\" 0.01 WorldBegin LightSource \"infinite\" \"float L\" {sky}"
        );
        assert_eq!(common::render(&common::build(&text)).most_samples, 16, "{sky}");
    }
}

#[test]
fn what_is_shown_black_or_white_has_no_noise() {
    let light = |scale: f64, measure: &str| {
        let sampler =
            format!("\"sobol\" \"float noise\" 0.02 \"string noisemeasure\" \"{measure}\" \"integer pixelsamples\" 512");
        let text = scene(&sampler).replace("\"float L\" 20", &format!("\"float L\" {}", 20.0 * scale));
        let text = text.replace("\"float scale\" 0.2", &format!("\"float scale\" {}", 0.2 * scale));
        common::render(&common::build(&text)).frame.samples()
    };
    // A thousand times as bright all is white.
    assert_eq!(light(1.0, "relative"), light(1024.0, "relative"));
    assert_eq!(light(1000.0, "shown"), 40 * 30 * 16);
    assert!(light(1.0, "shown") > 40 * 30 * 16);
}

#[test]
fn the_command_line_says_it_and_resumes_to_less_noise() {
    let folder = Folder::new(&scene(r#""sobol" "integer pixelsamples" 4"#));
    let run = |args: &[&str]| {
        let (code, said) = folder.run(&[&["render", "scene.bhs"], args].concat());
        assert_eq!(code, 0, "{args:?}: {said}");
        said
    };
    let said = run(&["--noise", "0.05", "-o", "a.exr", "--checkpoint"]);
    assert!(said.contains(" 16 to ") && said.contains(" spp in "), "{said}");
    run(&["--noise", "0.03", "-o", "b.exr"]);
    run(&["--noise", "0.05", "-o", "c.exr", "--checkpoint=c.checkpoint", "--spp", "16"]);
    run(&["--noise", "0.05", "-o", "c.exr", "--checkpoint=c.checkpoint", "--resume"]);
    folder.assert_same("a", "c");
    // Parts have as many samples everywhere.
    let said = run(&["--noise", "0.05", "--part", "1/2", "-o", "1.bhspart"]);
    assert!(said.contains("--noise is for whole pictures"), "{said}");
    run(&["--part", "2/2", "-o", "2.bhspart"]);
    let (code, said) = folder.run(&["merge", "-o", "m.exr", "1.bhspart", "2.bhspart"]);
    assert!(code == 0 && said.contains("4 spp"), "{said}");
    // What cannot be.
    for (args, word) in [(["--noise", "0"], "above 0"), (["--noise", "2"], "up to 1"), (["--noise", "low"], "such as 0.01")] {
        let (code, said) = folder.run(&["render", "scene.bhs", args[0], args[1]]);
        assert!(code != 0 && said.contains(word), "{said}");
    }
    folder.write("s.bhs", scene(r#""stratified""#));
    let (code, said) = folder.run(&["render", "s.bhs", "--noise", "0.1", "--noise-over", "picture"]);
    assert!(code == 1 && said.contains("noise") && said.contains("sobol") && !said.contains("unknown"), "{said}");
    // What noise is over means something where there is a target.
    let said = run(&["--noise-over", "picture", "-o", "d.exr"]);
    assert!(said.contains("`noiseover` does nothing here") && said.contains("--noise 0.02"), "{said}");
    let (code, said) = folder.run(&["render", "scene.bhs", "--noise-over", "room"]);
    assert!(code == 2 && said.contains("expected `pixel` or `picture`"), "{said}");
    let (code, said) = folder.run(&["render", "scene.bhs", "--noise-over", "picture", "--part", "1/2", "-o", "3.bhspart"]);
    assert!(code == 2 && said.contains("--noise-over belongs to --noise"), "{said}");
}
