//! The tests of the whole program, in one program: `cargo test --release --test all` runs all of them,
//! `cargo test --release --test all reference::` those of `reference.rs`.

#![allow(clippy::print_stderr, reason = "tests say what they measured and what they skip")]

mod common;

mod adaptive;
mod allocations;
mod animation;
mod black;
mod bumps;
mod caustics;
mod checkpoint;
mod clamps;
mod colours;
mod command_line;
mod confined;
mod contact;
mod cookbook;
mod coplanar;
mod corpus;
mod curved;
mod denoise;
mod develop;
mod diagnostics;
mod diagnostics_look;
mod discs;
mod disk_faults;
mod display;
mod editor;
mod extremes;
mod farm;
mod films;
mod flat;
mod format;
mod frames;
mod fuzz;
mod guides;
mod guiding;
mod header;
mod instances;
mod layers;
mod lensing;
mod limits;
mod loading;
mod memory;
mod models;
mod motions;
mod offsets;
mod optics;
mod outputs;
mod outside;
mod pages;
mod parts;
mod patches;
mod pbrt;
mod pbrt_facts;
mod point_light;
mod progress;
mod redshift;
mod reference;
mod replacing;
mod replay;
mod several;
mod shapes;
mod signals;
mod sky_lights;
mod sources;
mod spacetimes;
mod sphere_lights;
mod standard_error;
mod stars;
mod textures;
mod thin;
mod tolman;
mod trace;
mod turning;
mod tutorial;
mod unbiased;
mod variables;
mod visible_surface;
mod watch;
mod watertight;
mod wavelengths;

/// Names of the Rust files in a folder of the project, without `.rs`.
fn rust_files(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(common::root().join(folder)).expect("the folder is there");
    let names = entries.map(|e| e.expect("it can be read").file_name().to_string_lossy().into_owned());
    names.filter_map(|name| name.strip_suffix(".rs").map(str::to_owned)).collect()
}

/// A file that no `mod` names would be tests that never run.
#[test]
fn every_file_of_tests_is_part_of_this_program() {
    let mut missing = Vec::new();
    let mut check = |parent: &str, folder: &str| {
        let text = common::read(parent);
        let is_named = |module: &str| ["mod", "pub mod"].iter().any(|word| text.contains(&format!("\n{word} {module};\n")));
        let modules = rust_files(folder).into_iter().filter(|module| !["main", "mod"].contains(&module.as_str()));
        missing.extend(modules.filter(|module| !is_named(module)).map(|module| format!("{parent}: {module}")));
    };
    check("tests/main.rs", "tests");
    check("tests/common/mod.rs", "tests/common");
    for module in rust_files("tests").iter().filter(|module| common::root().join("tests").join(module).is_dir()) {
        check(&format!("tests/{module}.rs"), &format!("tests/{module}"));
    }
    assert!(missing.is_empty(), "no `mod` names these files: {missing:?}");
}
