//! The cookbook keeps up with the program: its scenes are without fault and show something, its commands can be typed, and the black scene is
//! explained as it says.
//!
//! `BLESS=1 cargo test --release --test all cookbook::` writes what is said of the black scene into `docs/cookbook.md`.

use crate::common;
use crate::common::examples::{blocks, build_all, examples};
use crate::common::program::Folder;
use bhs::cli::Cli;
use bhs::diagnosis;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs::render::render_quietly;
use clap::Parser;
use std::fs;

const PATH: &str = "docs/cookbook.md";

/// The file that a scene names itself in its first line.
fn name(scene: &str) -> &str {
    scene.lines().next().and_then(|line| line.strip_prefix("# ")).unwrap_or_else(|| panic!("a scene without a name:\n{scene}"))
}

/// The commands of the page, in their order.
fn typed(text: &str) -> Vec<&str> {
    blocks(text, "console").into_iter().flat_map(str::lines).filter_map(|line| line.strip_prefix("$ ")).collect()
}

/// What is said of a small picture of a scene, before it is rendered and after.
fn said(scene: &str) -> Vec<String> {
    let overrides = Overrides { resolution: Some([48, 32]), spp: Some(4), ..Overrides::default() };
    let built = lang::load_text(name(scene), scene, &Registry::builtin(), &overrides, &mut SourceMap::new());
    let built = built.unwrap_or_else(|found| panic!("{found:?}\n{scene}"));
    let before = diagnosis::before(&built).into_iter().map(|d| d.message);
    before.chain(diagnosis::after(&built, &render_quietly(&built)).map(|said| said.to_string())).collect()
}

#[test]
fn every_recipe_is_without_fault_and_shows_something() {
    let text = common::read(PATH);
    assert!(examples(&text).len() >= 8);
    build_all(PATH, &text);
    for scene in examples(&text) {
        assert_eq!(said(scene), [""; 0], "{}", name(scene));
    }
}

#[test]
fn commands_can_be_typed_and_name_recipes() {
    let text = common::read(PATH);
    let scenes: Vec<&str> = examples(&text).into_iter().chain(blocks(&text, "bhs black")).map(name).collect();
    let lines = typed(&text);
    assert!(lines.len() >= 3, "{lines:?}");
    for line in lines {
        Cli::try_parse_from(line.split_whitespace()).unwrap_or_else(|e| panic!("{line}\n{e}"));
        let named = line.split_whitespace().find(|word| word.ends_with(".bhs"));
        assert!(named.is_none_or(|scene| scenes.contains(&scene)), "{line}");
    }
}

#[test]
fn the_black_scene_is_explained_as_shown() {
    let text = common::read(PATH);
    let [scene] = blocks(&text, "bhs black")[..] else { panic!("there is one") };
    let [shown] = blocks(&text, "text")[..] else { panic!("there is one") };
    let said = said(scene).join("\n");
    let right = text.replace(&format!("```text\n{shown}"), &format!("```text\n{said}\n"));
    if right != text && std::env::var_os("BLESS").is_some() {
        fs::write(PATH, &right).expect("the cookbook can be written");
    }
    assert_eq!(text, right, "BLESS=1 writes this into {PATH}");
}

/// The commands one after the other, each with what those before it wrote, by the program itself. Pictures are small.
#[test]
fn commands_do_what_the_page_says() {
    let page = common::read(PATH);
    let folder = Folder::new("");
    for scene in examples(&page).into_iter().chain(blocks(&page, "bhs black")) {
        folder.write(name(scene), scene);
    }
    let [keys] = blocks(&page, "csv")[..] else { panic!("there is one table") };
    folder.write("flight.csv", keys);
    for line in typed(&page) {
        let mut args: Vec<&str> = line.split_whitespace().skip(1).collect();
        if args[0] == "render" {
            args.extend(["--resolution", "32x24"]);
            args.extend(if args.contains(&"--spp") { [].as_slice() } else { &["--spp", "2"] });
        }
        let run = folder.run(&args);
        let has_no_library = run.code == 1 && run.err.contains("Open Image Denoise");
        if has_no_library && args.iter().any(|word| word.contains("denoise")) {
            common::skipped("Open Image Denoise is not there: ./test fetches it");
            folder.write("clean.exr", folder.read("room.exr"));
            continue;
        }
        assert_eq!(run.code, 0, "{line}\n{}", run.err);
    }
    for name in ["clean.exr", "bright.png", "film.png", "difference.png", "flight.0023.png", "flight.gif"] {
        assert!(folder.files().iter().any(|file| file == name), "{name}: {:?}", folder.files());
    }
    numbers(&page, &folder);
}

/// The page's program in Python, where its packages are.
fn numbers(page: &str, folder: &Folder) {
    let [program] = blocks(page, "python")[..] else { panic!("there is one program") };
    folder.write("numbers.py", program);
    if folder.shell("python3 -c 'import numpy, OpenEXR'").code != 0 {
        common::skipped("python3 has no numpy or OpenEXR: pip install openexr");
        return;
    }
    let run = folder.shell("python3 numbers.py");
    let edge: f64 = run.out.trim().parse().unwrap_or_else(|_| panic!("{}{}", run.out, run.err));
    // Pixels are coarse: it is near the edge of the shadow, 2.598 rs.
    assert!((edge - 2.598).abs() < 0.3, "{edge}");
}
