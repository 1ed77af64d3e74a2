//! What the tests share: scenes from text, and rays through them.

pub mod examples;
pub mod lights;
pub mod physics;
pub mod process;
pub mod program;
pub mod room;
pub mod viewer;

use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs::render::Rendered;
use std::path::Path;

/// The project's root folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file of the project.
pub fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("cannot read {path}: {e}"))
}

/// Builds a scene from text; relative paths start at the project's root, where Cargo starts tests.
pub fn build(text: &str) -> BuiltScene {
    build_with(text, &Overrides::default())
}

/// Builds a scene from text, with changes.
pub fn build_with(text: &str, overrides: &Overrides) -> BuiltScene {
    let mut sources = SourceMap::new();
    match lang::load_text("test.bhs", text, &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => built,
        Err(found) => panic!("{}", bhs::report::render(&found, &sources, false)),
    }
}

/// Renders a built scene on the current thread pool.
pub fn render(built: &BuiltScene) -> Rendered {
    bhs::render::render_quietly(built)
}

/// Says that a test cannot be made here.
pub fn skipped(why: &str) {
    eprintln!("skipped: {why}");
}

/// The measured Cornell box with a wall in front, closed on all sides: options block not included.
pub fn closed_cornell_box() -> String {
    let scene = read("scenes/cornell_box.bhs");
    let front = r#"
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
            "point3 P" [0 0 0  552.8 0 0  556 548.8 0  0 548.8 0]
    "#;
    let world = scene.split_once("WorldBegin").expect("the scene has a world block").1;
    format!("{world}\n{front}")
}
