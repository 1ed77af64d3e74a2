//! Pictures that are too large for the memory that there is: known before, and refused.

#![cfg(target_os = "linux")] // where the system tells what there is

use crate::common;
use allocation_counter::measure;
use bhs::develop::{self, Texts};
use bhs::false_color::FalseColor;
use bhs::film::Framebuffer;
use bhs::lang::{BuiltScene, Overrides};
use bhs::layers::LayerPicture;
use bhs::memory::Bytes;
use bhs::memory::picture::Need;
use std::path::Path;
use std::process::{Command, Output};

const SCENE: &str = r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16 "string filename" "out.exr"
    Sampler "independent" "integer pixelsamples" 1
    Camera "perspective"
    WorldBegin
    LightSource "infinite"
    "#;

/// Runs `bhs` on a scene `scene.bhs` in a folder, with at most so many kB of address space.
fn limited(dir: &Path, kilobytes: u64, args: &str) -> Output {
    let bhs = assert_cmd::cargo::cargo_bin!("bhs");
    let line = format!("ulimit -v {kilobytes} && exec '{}' {args}", bhs.display());
    Command::new("sh").arg("-c").arg(line).current_dir(dir).output().expect("there is a shell")
}

fn folder(scene: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("scene.bhs"), scene).expect("the folder can be written");
    dir
}

fn files(dir: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(dir)
        .expect("the folder is there")
        .map(|e| e.expect("it can be read").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// More than the program takes for a small picture, and less than a large one.
const LIMIT: u64 = 8_000_000;

#[test]
fn a_picture_that_is_too_large_is_refused_before_anything_is_written() {
    let large = SCENE.replace("resolution\" 16", "resolution\" 65536");
    let layers = "--aov normal --aov position --aov variance";
    for (scene, args, film) in [
        (SCENE, "render scene.bhs --resolution 65536x65536".to_owned(), "275 GB"),
        (&large, "render scene.bhs".to_owned(), "275 GB"),
        (&large, format!("render scene.bhs {layers} --false-color"), "1.31 TB"),
        (&large, "render scene.bhs --crop 0,0.5,0,0.5".to_owned(), "68.7 GB"),
        (&large, "render scene.bhs --checkpoint --stats s.json -o elsewhere.exr".to_owned(), "275 GB"),
    ] {
        let dir = folder(scene);
        let out = limited(dir.path(), LIMIT, &args);
        let err = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(1), "{args}: {err}");
        assert!(err.contains("too large") && err.contains(film) && err.contains("ulimit -v"), "{args}: {err}");
        assert_eq!(files(dir.path()), ["scene.bhs"], "{args}");
    }
    // Where it would be written something stands already.
    let dir = folder(&large);
    std::fs::write(dir.path().join("out.exr"), "old").expect("the folder can be written");
    assert_eq!(limited(dir.path(), LIMIT, "render scene.bhs").status.code(), Some(1));
    assert_eq!(std::fs::read(dir.path().join("out.exr")).expect("it is there"), b"old");
}

#[test]
fn check_warns_of_a_picture_that_is_too_large() {
    let dir = folder(&SCENE.replace("resolution\" 16", "resolution\" 65536"));
    let out = limited(dir.path(), LIMIT, "check scene.bhs");
    let err = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success() && err.starts_with("warning") && err.contains("275 GB"), "{err}");
}

#[test]
fn pictures_that_fit_are_rendered() {
    let dir = folder(SCENE);
    for args in ["render scene.bhs", "render scene.bhs --resolution 1024x1024 --aov normal", "check scene.bhs"] {
        let out = limited(dir.path(), LIMIT, args);
        assert!(out.status.success(), "{args}: {}", String::from_utf8_lossy(&out.stderr));
    }
}

#[test]
fn rays_that_do_not_fit_are_refused() {
    let dir = folder(&format!("{SCENE} Translate 0 0 3 Shape \"sphere\""));
    let out = limited(dir.path(), LIMIT, "bench scene.bhs --rays 10000000 --only integrators");
    let err = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(1) && err.contains("not enough memory for the rays"), "{err}");
    // A line without end is not kept.
    std::fs::write(dir.path().join("rays.csv"), "1".repeat(1 << 20)).expect("the folder can be written");
    let out = limited(dir.path(), LIMIT, "trace scene.bhs --rays rays.csv");
    let err = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(1) && err.contains("line 1") && err.contains("longer than 65536 bytes"), "{err}");
}

/// What a picture takes while it is held and written as `bhs render` does; the picture is noise, which cannot be compressed.
fn written(built: &BuiltScene) -> [u64; 2] {
    let mut frame = None;
    let held = measure(|| frame = Framebuffer::new(&*built.film, &built.layers).ok());
    let frame = frame.expect("there is memory");
    for tile in &frame.tiles {
        let mut tile = tile.lock().expect("nobody has failed");
        let seed = tile.origin[0] * 65_537 + tile.origin[1];
        (0..tile.weights.len()).for_each(|i| tile.weights.add(i, 1.0));
        let mut random = u64::from(seed) + 1;
        for i in 0..tile.sums.len() {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            tile.sums.add(i, (random >> 40) as f64 / (1 << 24) as f64);
        }
    }
    let file = || tempfile::tempfile().expect("a temporary file");
    let writing = measure(|| {
        let layers: Vec<LayerPicture> = frame.layers().into_iter().map(LayerPicture::as_in_files).collect();
        let (picture, texts) = (frame.picture(), Texts::default());
        develop::write_png(file(), &picture, &built.look, &texts).expect("it can be written");
        let colors: Vec<_> = layers.iter().map(FalseColor::new).collect();
        for colors in &colors {
            develop::write_false_color(file(), picture.size, colors, &texts).expect("it can be written");
        }
        let all = if layers.is_empty() { None } else { Some(picture.clone().with_layers(&layers)) };
        all.as_ref().unwrap_or(&picture).write_exr(file(), &[]).expect("it can be written");
    });
    [held.bytes_max, writing.bytes_max]
}

#[test]
fn what_a_picture_needs_is_what_it_takes() {
    let films = [SCENE.to_owned(), SCENE.replace("Film \"rgb\"", "Film \"spectral\"")];
    let layers = [&[][..], &["normal"], &["depth", "position", "variance", "albedo"]];
    for (film, layers) in films.iter().flat_map(|f| layers.iter().map(move |l| (f, l))) {
        let overrides = Overrides {
            resolution: Some([1000, 700]),
            layers: layers.iter().map(|name| (*name).to_owned()).collect(),
            ..Overrides::default()
        };
        let built = common::build_with(film, &overrides);
        let need = Need::of(&*built.film, &built.layers);
        let [held, writing] = written(&built);
        for (what, needed, taken) in [("film", need.sums + need.tiles, held), ("writing", need.writing, writing)] {
            let ratio = needed as f64 / taken as f64;
            let shown = (Bytes(needed), Bytes(taken));
            assert!((0.97..1.35).contains(&ratio), "{what} {layers:?}: {} said, {} taken", shown.0, shown.1);
        }
    }
}
