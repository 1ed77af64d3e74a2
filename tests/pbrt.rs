//! Files of pbrt-v4, read as they are: one small file a feature in `tests/pbrt/`, with the mean of its picture where arithmetic says it, and the
//! words that are warned of.
//!
//! In the first lines of a file: `# mean: R G B`, `# luminance: Y`, `# within: SHARE` (0.01 without it), `# warns: WORD`.

use crate::common;
use crate::common::program::Folder;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap, Variables};
use bhs::registry::Registry;
use std::path::{Path, PathBuf};

/// The files, in order.
fn files() -> Vec<PathBuf> {
    let folder = common::root().join("tests/pbrt");
    let entries = std::fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("it can be read").path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "pbrt")).collect();
    files.sort();
    assert!(files.len() >= 100, "{}", files.len());
    files
}

/// What a line `# word: ...` of a file says.
fn stated<'t>(text: &'t str, word: &'t str) -> impl Iterator<Item = &'t str> {
    text.lines()
        .take_while(|l| l.starts_with('#'))
        .filter_map(move |l| l.strip_prefix("# ")?.strip_prefix(word)?.strip_prefix(": "))
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|n| n.parse().expect("a number")).collect()
}

fn load(path: &Path) -> Result<BuiltScene, String> {
    let mut sources = SourceMap::new();
    lang::load(path, &Registry::builtin(), &Overrides::default(), &mut sources)
        .map_err(|found| bhs::report::render(&found, &sources, false).to_string())
}

/// The pixels of the picture, colours alone.
fn pixels(built: &BuiltScene) -> Vec<[f64; 3]> {
    let picture = common::render(built).frame.picture();
    picture.pixels().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

fn mean(pixels: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|c| pixels.iter().map(|p| p[c]).sum::<f64>() / pixels.len() as f64)
}

/// What is wrong with a file.
fn fault(path: &Path) -> Option<String> {
    let text = std::fs::read_to_string(path).expect("it can be read");
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let built = match load(path) {
        Ok(built) => built,
        Err(why) => return Some(format!("{name}: {why}")),
    };
    let said: Vec<&str> =
        built.warnings.iter().filter(|w| w.code == "pbrt" || w.code == "sky-layout").map(|w| &*w.message).collect();
    let wanted: Vec<&str> = stated(&text, "warns").collect();
    if let Some(word) = wanted.iter().find(|word| !said.iter().any(|s| s.contains(**word))) {
        return Some(format!("{name}: `{word}` is not warned of: {said:?}"));
    }
    if let Some(more) = said.iter().find(|s| !wanted.iter().any(|word| s.contains(word))) {
        return Some(format!("{name}: {more}"));
    }
    let mean = mean(&pixels(&built));
    let within: f64 = stated(&text, "within").next().map_or(0.01, |w| w.parse().expect("a number"));
    let off = |found: f64, expected: f64| (found - expected).abs() > within * expected.abs().max(0.01) + 1e-6;
    let mut wrong = !mean.iter().all(|c| c.is_finite());
    for expected in stated(&text, "mean").map(numbers) {
        wrong |= (0..3).any(|c| off(mean[c], expected[c]));
    }
    for expected in stated(&text, "luminance").map(numbers) {
        wrong |= off(common::lights::luminance(&mean.map(|c| c as f32)), expected[0]);
    }
    wrong.then(|| format!("{name}: the mean is {mean:?}"))
}

#[test]
fn every_file_is_read_as_pbrt_reads_it() {
    let faults: Vec<String> = files().iter().filter_map(|path| fault(path)).collect();
    assert!(faults.is_empty(), "{} faults\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn a_converted_file_is_the_same_scene_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for path in files() {
        let mut sources = SourceMap::new();
        let (text, _) = lang::convert(&path, &mut sources, &Variables::default(), folder.path())
            .unwrap_or_else(|found| panic!("{}: {}", path.display(), bhs::report::render(&found, &sources, false)));
        let converted = folder.path().join("scene.bhs");
        std::fs::write(&converted, &text).expect("writable");
        let again = load(&converted).unwrap_or_else(|why| panic!("{}: {why}\n{text}", path.display()));
        assert!(again.warnings.iter().all(|w| w.code != "pbrt"), "{}", path.display());
        let (one, other) = (pixels(&load(&path).expect("it loads")), pixels(&again));
        assert!(one == other, "{}: {:?} and {:?}\n{text}", path.display(), mean(&one), mean(&other));
    }
}

const SCENE: &str = r#"
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "out.exr"
Sampler "halton" "integer pixelsamples" 4
Integrator "volpath"
Camera "perspective" "float fov" 5
WorldBegin
LightSource "infinite" "spectrum L" [400 9 700 9]
Material "diffuse"
Translate 3 3 3
"#;

/// The mean of a picture that the program has written.
fn written(folder: &Folder, name: &str) -> f64 {
    let picture = bhs::image::Picture::read_exr(&folder.at(name)).expect("a picture");
    let [r, g, b] = mean(&picture.pixels().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect::<Vec<_>>());
    (r + g + b) / 3.0
}

#[test]
fn the_ending_or_a_flag_says_what_is_pbrts_and_a_hole_is_added_unasked() {
    let folder = Folder::new("");
    folder.write("room.pbrt", SCENE);
    folder.write("room.txt", SCENE);
    folder.write("hole.bhs", "Translate 0 0 5\nBlackHole \"schwarzschild\" \"float rs\" 1\n");
    let run = |args: &[&str]| {
        let run = folder.run(args);
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        run.err
    };
    let said = run(&["render", "room.pbrt", "--quiet"]);
    assert!(said.contains("volpath") && said.matches("volpath").count() <= 2, "{said}");
    assert!((written(&folder, "out.exr") - 1.0).abs() < 0.1);
    // Without the ending it is ours, and its integrator unknown; the flag says otherwise.
    assert_eq!(folder.run(&["render", "room.txt", "--quiet"]).code, 1);
    run(&["render", "room.txt", "--pbrt", "--quiet", "-o", "flag.exr"]);
    assert!((written(&folder, "flag.exr") - 1.0).abs() < 0.1);
    // The hole stands where its own file says, not under the transform that the scene ends with.
    run(&["render", "room.pbrt", "--include", "hole.bhs", "--quiet", "-o", "hole.exr"]);
    assert_eq!(written(&folder, "hole.exr"), 0.0);
    assert_eq!(std::fs::read_to_string(folder.at("room.pbrt")).expect("it is there"), SCENE);
    // And in the converted scene.
    run(&["convert", "room.pbrt", "--include", "hole.bhs", "-o", "both.bhs"]);
    run(&["render", "both.bhs", "--quiet", "-o", "both.exr"]);
    assert_eq!(written(&folder, "both.exr"), 0.0);
}

#[test]
fn convert_replaces_nothing_that_it_reads_and_sees_files_from_its_own_folder() {
    let folder = Folder::new("");
    folder.write("in/grey.pfm", [b"PF\n1 1\n-1\n".as_slice(), &[0.5f32, 0.5, 0.5].map(f32::to_le_bytes).concat()].concat());
    let scene =
        SCENE.replace("\"spectrum L\" [400 9 700 9]", "\"string filename\" \"grey.pfm\"").replace("halton", "independent");
    folder.write("in/room.pbrt", &scene);
    for input in ["in/room.pbrt", "in/grey.pfm"] {
        let refused = folder.run(&["convert", "in/room.pbrt", "-o", input]);
        assert!(refused.code == 1 && refused.err.contains(input), "{}", refused.err);
    }
    let made = folder.run(&["convert", "in/room.pbrt", "-o", "out/room.bhs"]);
    assert_eq!(made.code, 1, "there is no such folder: {}", made.err);
    let made = folder.run(&["convert", "in/room.pbrt", "-o", "room.bhs"]);
    assert_eq!(made.code, 0, "{}", made.err);
    let text = std::fs::read_to_string(folder.at("room.bhs")).expect("it is there");
    assert!(text.contains("\"in/grey.pfm\""), "{text}");
    assert_eq!(folder.run(&["render", "room.bhs", "--quiet", "-o", "p.exr"]).code, 0);
    assert!((written(&folder, "p.exr") - 0.5).abs() < 0.05);
    // Faults have their places, and nothing is written.
    folder.write("bad.pbrt", "Camera \"perspective\"\nWorldBegin\nShape \"sphere\" \"float radius\" [1\n");
    let bad = folder.run(&["convert", "bad.pbrt", "-o", "bad.bhs"]);
    assert!(bad.code == 1 && bad.err.contains("bad.pbrt:3") && !folder.at("bad.bhs").exists(), "{}", bad.err);
}

#[test]
fn a_shutter_that_never_opens_is_a_fault() {
    let folder = Folder::new("");
    folder.write("a.pbrt", "Camera \"perspective\" \"float shutteropen\" 1\nWorldBegin\nLightSource \"infinite\"\n");
    let run = folder.run(&["check", "a.pbrt"]);
    assert!(run.code == 1 && run.err.contains("a.pbrt:1") && run.err.contains("shutter"), "{}", run.err);
}
