//! The tests of the whole program, in one program: `cargo test --release --test all` runs all of them,
//! `cargo test --release --test all reference::` those of `reference.rs`.

#![allow(clippy::print_stderr, reason = "tests say what they measured and what they skip")]

mod common;

mod allocations;
mod checkpoint;
mod command_line;
mod confined;
mod contact;
mod coplanar;
mod corpus;
mod curved;
mod diagnostics;
mod diagnostics_look;
mod disk_faults;
mod editor;
mod extremes;
mod films;
mod flat;
mod format;
mod frames;
mod fuzz;
mod header;
mod instances;
mod layers;
mod lensing;
mod limits;
mod memory;
mod motions;
mod offsets;
mod optics;
mod outputs;
mod pbrt_facts;
mod point_light;
mod redshift;
mod reference;
mod replacing;
mod replay;
mod shapes;
mod signals;
mod sky_lights;
mod spacetimes;
mod standard_error;
mod textures;
mod thin;
mod tolman;
mod tutorial;
mod unbiased;
mod visible_surface;
mod watertight;

/// A file that no `mod` names would be tests that never run.
#[test]
fn every_file_of_tests_is_part_of_this_program() {
    let here = common::read("tests/main.rs");
    let mut missing = Vec::new();
    for entry in std::fs::read_dir(common::root().join("tests")).expect("the folder is there") {
        let name = entry.expect("it can be read").file_name().to_string_lossy().into_owned();
        let module = name.strip_suffix(".rs").filter(|module| *module != "main");
        missing.extend(module.filter(|module| !here.contains(&format!("\nmod {module};\n"))).map(str::to_owned));
    }
    assert!(missing.is_empty(), "tests/main.rs has no `mod` for {missing:?}");
}
