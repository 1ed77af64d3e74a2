//! Black pictures are explained, and good ones are not.
//!
//! Every `tests/black/*.bhs` states what is said of it in comments that begin with `# said: `; of those in `tests/black/good` nothing is said.
//! Lines are counted without these comments. `BLESS=1 cargo test --release --test all black::` writes what is said into the files.

use crate::common::program::Folder;
use bhs::diagnosis::{self, BlackFrames};
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs::render::render_quietly;
use std::fs;
use std::path::{Path, PathBuf};

const FOLDER: &str = "tests/black";
const MARK: &str = "# said: ";

fn scenes(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("and can be read").path());
    let mut scenes: Vec<PathBuf> = entries.filter(|p| p.extension().is_some_and(|e| e == "bhs")).collect();
    scenes.sort();
    scenes
}

/// What is said of the scene `text` before it is rendered and after.
fn said(name: &str, text: &str) -> Vec<String> {
    let mut sources = SourceMap::new();
    let mut built = lang::load_text(name, text, &Registry::builtin(), &Overrides::default(), &mut sources)
        .unwrap_or_else(|found| panic!("{}", bhs::report::render(&found, &sources, false)));
    built.warnings.extend(diagnosis::before(&built));
    let before = built.warnings.iter().map(|d| {
        let at = d.primary.as_ref().map_or((0, 0), |p| sources.line_column(p.span.file, p.span.start));
        let help = d.help.as_deref().unwrap_or("");
        format!("warning: {}:{} {}; {help}", at.0, at.1, d.message)
    });
    let mut said: Vec<String> = before.collect();
    let rendered = render_quietly(&built);
    said.extend(diagnosis::after(&built, &rendered).map(|explanation| explanation.to_string()));
    said
}

fn name(path: &Path) -> String {
    path.file_name().expect("files have names").to_string_lossy().into_owned()
}

#[test]
fn every_black_picture_is_explained_in_one_sentence() {
    let bless = std::env::var_os("BLESS").is_some();
    let scenes = scenes(FOLDER);
    assert!(scenes.len() >= 40, "{}", scenes.len());
    let mut wrong = String::new();
    for path in scenes {
        let text = fs::read_to_string(&path).expect("scenes can be read");
        let scene: String = text.split_inclusive('\n').filter(|line| !line.starts_with(MARK)).collect();
        let said = said(&name(&path), &scene);
        let expected: String = said.iter().map(|line| format!("{MARK}{line}\n")).chain([scene]).collect();
        if said.len() != 1 {
            wrong += &format!("--- {} has {} sentences: {said:#?}\n", path.display(), said.len());
        }
        if expected != text {
            wrong += &format!("--- {} should begin with\n{}\n", path.display(), said.join("\n"));
            if bless {
                fs::write(&path, expected).expect("scenes can be written");
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn nothing_is_said_of_good_pictures() {
    let scenes = scenes(&format!("{FOLDER}/good"));
    assert!(scenes.len() >= 15, "{}", scenes.len());
    for path in scenes {
        let said = said(&name(&path), &fs::read_to_string(&path).expect("scenes can be read"));
        assert!(said.is_empty(), "{}: {said:#?}", path.display());
    }
}

#[test]
fn a_light_that_is_not_found_hides_no_other_cause() {
    let scene = crate::common::read("tests/black/lamp_in_ball_hemisphere.bhs");
    let lines = scene.lines().map(|line| match line.starts_with("WorldBegin") {
        true => "WorldBegin\nLightSource \"point\" \"spectrum I\" 40 \"point3 from\" [0 3 -2]\n".to_owned(),
        false => format!("{line}\n"),
    });
    let said = said("both.bhs", &lines.collect::<String>());
    assert!(
        said.len() == 2 && said[0].contains("does not find this light") && said[1].contains("the lights are enclosed"),
        "{said:#?}"
    );
}

#[test]
fn a_layer_in_place_of_the_picture_has_no_exposure_of_its_own() {
    let run = |flags: &[&str]| {
        let folder = Folder::new(&crate::common::read("tests/black/too_dark.bhs"));
        folder.run(&[&["render", "scene.bhs"], flags].concat()).err
    };
    assert!(run(&[]).contains("stops too dark"));
    let layer = run(&["--aov", "depth", "--layer", "depth"]);
    assert!(!layer.contains("stops too dark"), "{layer}");
}

#[test]
fn a_preview_is_explained_on_standard_error_with_the_place_in_the_file() {
    let run = |scene: &str, flags: &[&str]| {
        let folder = Folder::new(&crate::common::read(scene));
        let run = folder.run(&[&["render", "scene.bhs", "--quick"], flags].concat());
        assert_eq!(run.code, 0, "{run:?}");
        run.err
    };
    let inside = run("tests/black/inside_ball.bhs", &[]);
    assert!(inside.contains("spp in") && inside.contains("warning: the picture is black: the camera"), "{inside}");
    assert!(inside.contains("scene.bhs:4:8") && inside.contains("scene.bhs:9:7"), "{inside}");
    // Warnings stay with `--quiet`, notes go.
    assert!(run("tests/black/inside_ball.bhs", &["--quiet"]).starts_with("warning: the picture is black"));
    assert!(run("tests/black/behind.bhs", &[]).contains("note: no camera ray meets a surface"));
    assert_eq!(run("tests/black/behind.bhs", &["--quiet"]), "");
    let good = run("tests/black/good/glass.bhs", &[]);
    assert!(good.lines().count() == 1 && good.contains("spp in"), "{good}");
}

#[test]
fn one_black_frame_of_a_film_is_not_told_of_and_two_are_told_of_once() {
    let film = BlackFrames::new(5);
    let told: Vec<bool> = (0..4).map(|_| film.tells("camera-inside")).collect();
    assert_eq!(told, [false, true, false, false]);
    assert!(BlackFrames::new(1).tells("camera-inside"));
}
