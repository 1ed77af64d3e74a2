//! Samples that are replayed, and numbers of a render that no picture can show: what is said of them.

use crate::common;
use assert_cmd::Command;
use bhs::image::Picture;
use bhs::lang::Overrides;
use bhs::not_finite::SampleId;
use bhs::render::Job;
use bhs::replay::Replay;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// Runs `bhs` in `dir` and returns exit code, standard output and standard error.
fn run(dir: &Path, args: &[&str]) -> (i32, String, String) {
    let out = Command::new(assert_cmd::cargo::cargo_bin!("bhs")).current_dir(dir).args(args).output().expect("bhs starts");
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    (out.status.code().unwrap_or(-1), text(&out.stdout), text(&out.stderr))
}

/// A folder with the scene `scene.bhs`.
fn folder(text: &str) -> TempDir {
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("scene.bhs"), text).expect("the temporary folder can be written");
    dir
}

fn picture(dir: &Path, name: &str) -> Picture {
    Picture::read_exr(&dir.join(name)).expect("a picture")
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Lamps, matt, rough and clear surfaces, a sky and a point light: all that a path can meet.
const ROOM: &str = r#"
    LightSource "infinite" "float L" 0.2
    LightSource "point" "point3 from" [2 3 -1] "float I" 4
    Material "diffuse" "rgb reflectance" [0.7 0.4 0.2]
    Shape "disk" "float radius" 4
    AttributeBegin Translate -0.8 0.6 0.5 Material "conductor" "float roughness" 0.2 Shape "sphere" "float radius" 0.6 AttributeEnd
    AttributeBegin Translate 0.9 0.7 0 Material "dielectric" "spectrum eta" "glass-SF11" Shape "sphere" "float radius" 0.6 AttributeEnd
    AttributeBegin Translate 0 2.5 0 Rotate 90 1 0 0 AreaLightSource "diffuse" "float L" 5 Shape "disk" "float radius" 0.5 AttributeEnd
"#;

const OPTIONS: &str = r#"
    LookAt 0 1.2 -4  0 0.6 0  0 1 0
    Camera "perspective" "float fov" 50 "float lensradius" 0.05 "float focaldistance" 4
    Film "spectral" "integer nbuckets" 4 "integer xresolution" 17 "integer yresolution" 19 "string filename" "small.exr"
    Sampler "sobol" "integer pixelsamples" 9
    LightTransport "path" "integer maxdepth" 7
    WorldBegin Rotate -90 1 0 0
"#;

#[test]
fn all_samples_together_are_the_picture() {
    let hole = "BlackHole \"schwarzschild\" \"point3 center\" [0 1.6 1.5] \"float rs\" 0.2";
    let guided = OPTIONS.replace("\"integer maxdepth\" 7", "\"integer maxdepth\" 7 \"bool guiding\" true");
    for (options, hole, transport) in [
        (OPTIONS, "", "path"),
        (OPTIONS, hole, "path"),
        (OPTIONS, hole, "hemisphere"),
        (OPTIONS, "", "normals"),
        (&guided, "", "path"),
    ] {
        let overrides = Overrides { transport: Some(transport.into()), ..Default::default() };
        let built = common::build_with(&format!("{options}{hole}{ROOM}"), &overrides);
        let picture = common::render(&built).frame.picture();
        let mut replay = Replay::new(Job::of(&built));
        let pixels = || (0..17).flat_map(|x| (0..19).map(move |y| (x, y)));
        let mut sums = vec![vec![0.0; picture.channels.len()]; pixels().count()];
        for sample in 0..9 {
            for ((x, y), sums) in pixels().zip(&mut sums) {
                let replayed = replay.follow(SampleId { pixel: [x, y], sample });
                assert!(replayed.is_finite && !replayed.events.is_empty());
                sums.iter_mut().zip(&replayed.channels).for_each(|(sum, c)| *sum += c);
            }
        }
        for ((x, y), sums) in pixels().zip(sums) {
            let mean: Vec<f32> = sums.iter().map(|s| (s / 9.0) as f32).collect();
            assert_eq!(mean, picture.pixel(x as usize, y as usize), "{hole} {transport} {x},{y}");
        }
    }
}

#[test]
fn a_replay_tells_the_path_and_writes_no_file() {
    let dir = folder(&format!("{OPTIONS}{ROOM}"));
    // Not all samples find a light on their side.
    let replayed = (0..9).map(|sample: u32| {
        let sample = sample.to_string();
        let (code, out, err) = run(dir.path(), &["render", "scene.bhs", "--pixel", "8,13", "--sample", &sample, "--seed", "5"]);
        assert_eq!((code, err.as_str()), (0, ""));
        let told = json(&out);
        assert_eq!((&told["seed"], told["sample"].to_string(), &told["pixel"]), (&5.into(), sample, &serde_json::json!([8, 13])));
        (told, out)
    });
    let (told, out) =
        replayed.into_iter().find(|(told, _)| told["vertices"][0]["lights"].is_array()).expect("one that finds a light");
    let vertices = told["vertices"].as_array().expect("vertices");
    let first = &vertices[0];
    let float = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
    assert_eq!((&first["outcome"], &first["surface"]["plugin"]), (&"hit".into(), &"disk".into()), "{out}");
    assert_eq!((&first["shape"], &first["surface"]["material"]), (&0.into(), &"diffuse".into()));
    assert!(first["surface"]["place"].as_str().is_some_and(|p| p.starts_with("scene.bhs:")), "{out}");
    // The floor, and where its light comes from.
    assert!(float(&first["point"][1]).abs() < 1e-6 && float(&first["normal"][1]) > 0.999, "{out}");
    assert!(first["scattered"]["density_per_sr"].is_number() && vertices.len() > 1, "{out}");
    // Each ray starts where the last one ended.
    let gap: f64 = (0..3).map(|k| (float(&first["point"][k]) - float(&vertices[1]["from"][k])).abs()).sum();
    assert!(gap < 1e-4, "{out}");
    let files: Vec<_> = std::fs::read_dir(dir.path()).expect("readable").collect();
    assert_eq!(files.len(), 1, "{files:?}");

    // What cannot be replayed is the command line's fault.
    for (args, word) in [
        (&["--pixel", "17,0", "--sample", "0"][..], "17 columns and 19 rows"),
        (&["--pixel", "1,1"], "--sample"),
        (&["--sample", "1"], "--pixel"),
        (&["--pixel", "1", "--sample", "0"], "column and row"),
        (&["--pixel", "1,1", "--sample", "0", "-o", "x.exr"], "--output"),
    ] {
        let (code, out, err) = run(dir.path(), &[&["render", "scene.bhs"], args].concat());
        assert!(code == 2 && out.is_empty() && err.contains(word), "{args:?}: {err}");
    }
}

#[test]
fn each_of_several_cameras_replays_its_own() {
    let text = format!("{OPTIONS}{ROOM}").replace(
        "Film",
        "Camera \"perspective\" \"string name\" \"wide\" \"float fov\" 90 Camera \"spherical\" \"string name\" \"all\" Film",
    );
    let dir = folder(&text);
    let departure = |args: &[&str]| {
        let (code, out, err) = run(dir.path(), &[&["render", "scene.bhs", "--pixel", "1,1", "--sample", "0"], args].concat());
        assert_eq!(code, 0, "{err}");
        (json(&out)["camera"].clone(), json(&out)["vertices"][0]["departure"].clone())
    };
    let (plain, wide, all) = (departure(&[]), departure(&["--camera", "wide"]), departure(&["--camera", "all"]));
    assert_eq!((plain.0, wide.0, all.0), (Value::Null, "wide".into(), "all".into()));
    assert!(plain.1 != wide.1 && wide.1 != all.1);
    let named = text.replacen("Camera \"perspective\"", "Camera \"perspective\" \"string name\" \"narrow\"", 1);
    std::fs::write(dir.path().join("scene.bhs"), named).expect("writable");
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--pixel", "1,1", "--sample", "0"]);
    assert!(code == 2 && err.contains("narrow, wide, all"), "{err}");
}

/// A floor whose upper left part lies so close under a point light that light there overflows.
const OVERFLOW: &str = r#"
    LookAt 0 4 0  0 0 0  0 0 1
    Camera "perspective" "float fov" 30
    Film "rgb" "integer xresolution" 12 "integer yresolution" 8 "string filename" "bright.exr"
    Sampler "independent" "integer pixelsamples" 3
    WorldBegin
    LightSource "point" "point3 from" [-0.5 0.1 0.5] "float I" 3.3e38
    Rotate -90 1 0 0
    Shape "disk" "float radius" 3
"#;

#[test]
fn samples_that_are_not_finite_are_named_counted_and_replayed() {
    let dir = folder(OVERFLOW);
    let args = ["render", "scene.bhs", "--quiet", "--seed", "3", "--spp", "2", "--stats", "stats.json"];
    let (code, _, err) = run(dir.path(), &args);
    assert_eq!(code, 0, "{err}");
    let count: u64 = err.split_whitespace().nth(1).and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{err}"));
    assert!((1..40).contains(&count) && err.contains("not finite"), "{err}");
    let commands: Vec<&str> = err.lines().filter_map(|l| Some(l.split_once("seed 3: bhs ")?.1)).collect();
    assert_eq!(commands.len() as u64, count.min(5), "{err}");
    for command in commands {
        let (code, out, err) = run(dir.path(), &command.split_whitespace().collect::<Vec<_>>());
        assert_eq!(code, 0, "{command}: {err}");
        let told = json(&out);
        assert_eq!(told["finite"], false, "{command}: {out}");
        assert!(out.contains("\"inf\"") && told["vertices"][0]["lights"][0]["light"]["plugin"] == "point", "{out}");
    }
    let stats = json(&std::fs::read_to_string(dir.path().join("stats.json")).expect("readable"));
    assert_eq!((&stats["counts"]["samples_not_finite"], &stats["not_finite"]["samples"]), (&count.into(), &count.into()));
    assert_eq!(stats["not_finite"]["first_samples"].as_array().map(Vec::len), Some(count.min(5) as usize));
    let header = exr::meta::MetaData::read_from_file(dir.path().join("bright.exr"), false).expect("a header");
    let count = exr::meta::attribute::AttributeValue::F64(count as f64);
    assert_eq!(header.headers[0].own_attributes.other.get(&exr::prelude::Text::from("bhs:samplesNotFinite")), Some(&count));
    assert!(picture(dir.path(), "bright.exr").data.iter().all(|v| v.is_finite()));
    // Named in the same order by any number of threads.
    for threads in ["1", "3"] {
        let again = run(dir.path(), &[&args[..], &["--threads", threads]].concat());
        assert_eq!(again.2, err);
    }
}

#[test]
fn a_point_light_of_1e38_lights_the_floor() {
    // Lambert: I rho cos / (pi r^2), 4 below it: black where powers were summed in single precision.
    let text = OVERFLOW
        .replace("[-0.5 0.1 0.5] \"float I\" 3.3e38", "[0 4 0] \"float I\" 1e38")
        .replace("\"float fov\" 30", "\"float fov\" 0.1");
    let dir = folder(&text);
    // It is 122 stops too bright, which the choice of an exposure keeps from being said.
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--quiet", "--exposure", "auto"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let picture = picture(dir.path(), "bright.exr");
    let mean = picture.data.iter().map(|v| f64::from(*v)).sum::<f64>() / picture.data.len() as f64;
    // Equal energy has a mean of red, green and blue of 1.034.
    let expected = 1e38 * 0.5 / (std::f64::consts::PI * 16.0);
    assert!((mean / expected - 1.034).abs() < 0.05, "{mean:e} {expected:e}");
}

#[test]
fn values_that_the_file_cannot_hold_are_named_and_finite() {
    // A sky of equal energy is 1.2 times as red as it is bright: beyond single precision, though no sample is.
    let text = r#"
        Film "rgb" "integer xresolution" 4 "integer yresolution" 4 "string filename" "bright.exr" "string layers" "variance"
        Sampler "independent" "integer pixelsamples" 4
        Camera "perspective"
        WorldBegin
        LightSource "infinite" "float L" 3.3e38
    "#;
    let dir = folder(text);
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--quiet", "--stats", "stats.json"]);
    assert_eq!(code, 0);
    for channel in ["R", "Variance.R", "Variance.G", "Variance.B"] {
        assert!(err.contains(&format!("in the channel {channel} that")), "{err}");
    }
    assert!(!err.contains("not finite"), "{err}");
    let picture = picture(dir.path(), "bright.exr");
    assert!(picture.data.iter().all(|v| v.is_finite()) && picture.data.contains(&f32::MAX));
    let stats = json(&std::fs::read_to_string(dir.path().join("stats.json")).expect("readable"));
    assert!(stats["not_finite"]["beyond_single_precision"].as_array().is_some_and(|b| b.len() >= 4), "{stats}");
    // The PNG is white, not black.
    for curve in ["clip", "reinhard", "aces"] {
        let shown = text.replace("Film \"rgb\"", &format!("Film \"rgb\" \"string tonecurve\" \"{curve}\" \"float exposure\" 64"));
        std::fs::write(dir.path().join("scene.bhs"), shown).expect("writable");
        assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet"]).0, 0);
        let png = image::open(dir.path().join("bright.png")).expect("a picture").to_rgb8();
        assert!(png.iter().all(|v| *v == 255), "{curve}: {:?}", png.get_pixel(0, 0));
    }
}

#[test]
fn seeds_are_exact_and_have_an_end() {
    let scene = |seed: &str| OVERFLOW.replace("WorldBegin", &format!("Option \"integer seed\" {seed}\nWorldBegin"));
    let seed_of = |text: &str| {
        let dir = folder(text);
        let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--quiet", "--spp", "1", "--stats", "s.json"]);
        assert_eq!(code, 0, "{err}");
        json(&std::fs::read_to_string(dir.path().join("s.json")).expect("readable"))["seed"].as_u64()
    };
    // Beyond 2^53 neighbours have the same double.
    for seed in [0, 7, 9_007_199_254_740_993, 9_223_372_036_854_775_806, 9_223_372_036_854_775_807_u64] {
        assert_eq!(seed_of(&scene(&seed.to_string())), Some(seed));
        assert_eq!(seed_of(&scene(&format!("[ {seed} ]"))), Some(seed));
    }
    for seed in
        ["9223372036854775808", "9223372036854775809", "18446744073709551616", "-1", "1e30", "100000000000000000000000000"]
    {
        let dir = folder(&scene(seed));
        for command in ["render", "check"] {
            let (code, _, err) = run(dir.path(), &[command, "scene.bhs"]);
            assert!(code == 1 && err.contains("seed") && err.contains("scene.bhs:6:2"), "{seed}: {err}");
            assert!(seed == "1e30" || err.contains("from 0 to 9223372036854775807"), "{seed}: {err}");
        }
    }
    let dir = folder(OVERFLOW);
    for seed in ["9223372036854775808", "18446744073709551615", "18446744073709551616", "-1"] {
        let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--seed", seed]);
        assert_eq!(code, 2, "{err}");
    }
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--quiet", "--seed", "9223372036854775807"]);
    assert_eq!(code, 0, "{err}");
}
