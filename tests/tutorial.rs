//! The tutorial keeps up with the program: its scenes are without fault, its commands can be typed, they print what it shows, and its
//! pictures are there.
//!
//! `BLESS=1 cargo test --test all tutorial::` writes what the commands print into `docs/tutorial.md`.

use crate::common;
use crate::common::examples::{blocks, build_all, examples};
use bhs::cli::{Cli, Command};
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs::{plugins_table, report};
use clap::Parser;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const PATH: &str = "docs/tutorial.md";

/// The scene of the tutorial that names itself `name` in its first line.
fn scene<'t>(text: &'t str, name: &str) -> &'t str {
    let scenes = examples(text).into_iter().chain(blocks(text, "bhs faulty"));
    let comment = format!("# {name}\n");
    scenes.into_iter().find(|s| s.starts_with(&comment)).unwrap_or_else(|| panic!("no scene starts with `# {name}`"))
}

/// What a command line prints, of those whose output is always the same; `None` of a render.
fn output(text: &str, line: &str) -> Option<String> {
    let cli = Cli::try_parse_from(line.split_whitespace()).unwrap_or_else(|e| panic!("{line}\n{e}"));
    match cli.command {
        Command::Check { scenes, .. } => {
            let name = scenes[0].to_string_lossy();
            let mut sources = SourceMap::new();
            let found = lang::load_text(&name, scene(text, &name), &Registry::builtin(), &Overrides::default(), &mut sources);
            Some(report::render(&found.err().expect("it is faulty"), &sources, false))
        }
        Command::Plugins { kind, name, .. } => {
            Some(plugins_table::render(&Registry::builtin(), kind.as_deref(), name.as_deref()).expect("they exist"))
        }
        Command::Render(args) => {
            scene(text, &args.scenes[0].to_string_lossy());
            None
        }
        _ => None,
    }
}

#[test]
fn every_scene_is_without_fault() {
    let text = common::read(PATH);
    assert!(examples(&text).len() >= 3);
    build_all(PATH, &text);
}

#[test]
fn commands_print_what_is_shown() {
    let text = common::read(PATH);
    let mut right = text.clone();
    for block in blocks(&text, "console") {
        for line in block.lines().filter_map(|l| l.strip_prefix("$ ")) {
            if let Some(said) = output(&text, line) {
                right = right.replace(block, &format!("$ {line}\n{}\n", said.trim_end()));
            }
        }
    }
    for (untidy, shown) in blocks(&text, "bhs untidy").into_iter().zip(blocks(&text, "bhs formatted")) {
        let neat = lang::format(untidy, 0).expect("it can be read");
        right = right.replace(&format!("```bhs formatted\n{shown}"), &format!("```bhs formatted\n{neat}"));
    }
    if right != text && std::env::var_os("BLESS").is_some() {
        fs::write(PATH, &right).expect("the tutorial can be written");
    }
    assert_eq!(text, right, "BLESS=1 writes this into {PATH}");
}

#[test]
fn pictures_are_there_and_small() {
    let text = common::read(PATH);
    let shown: BTreeSet<&str> = text.split("![](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    let folder = fs::read_dir("docs/tutorial").expect("the folder is there");
    let files: BTreeSet<String> =
        folder.map(|e| format!("tutorial/{}", e.expect("and can be read").file_name().to_string_lossy())).collect();
    assert!(files.iter().map(String::as_str).eq(shown), "{files:?}");
    for file in files {
        let path = Path::new("docs").join(&file);
        let bytes = fs::metadata(&path).expect("it is there").len();
        let (width, _) = image::image_dimensions(&path).expect("it is a picture");
        assert!(bytes < 150_000 && width <= 400, "{file}: {bytes} bytes, {width} pixels wide");
    }
}
