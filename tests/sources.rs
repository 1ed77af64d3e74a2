//! What ARCHITECTURE.md says of the sources, where reading them can tell.

mod circles;

use crate::common::{read, root};
use std::path::Path;

/// Folders whose Rust files are the project's.
const FOLDERS: [&str; 8] = ["src", "plugins", "tests", "benches", "examples", "fuzz", "python", "setup"];

/// Files that may have more lines than others: none.
const LONG: [&str; 0] = [];

/// The Rust files below a folder of the project, by their paths in it.
fn rust_files_below(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("the folder can be read") {
            let path = entry.expect("it can be read").path();
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let within = path.strip_prefix(root()).expect("it is within the project");
                found.push(within.to_str().expect("names are text").replace('\\', "/"));
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no Rust files in {folder}");
    found
}

fn all_rust_files() -> Vec<String> {
    FOLDERS.iter().flat_map(|folder| rust_files_below(folder)).collect()
}

/// The text without comments that take the rest of a line.
fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// What stands before the tests of a file.
fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default()
}

/// The words of a text: letters, digits and underscores.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// Functions of the standard library, and of glam by them, whose last digit depends on the machine.
const UNLIKE: [&str; 32] = [
    "sin",
    "cos",
    "tan",
    "sin_cos",
    "asin",
    "acos",
    "atan",
    "atan2",
    "exp",
    "exp2",
    "exp_m1",
    "ln",
    "ln_1p",
    "log",
    "log2",
    "log10",
    "powf",
    "cbrt",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "hypot",
    "from_axis_angle",
    "from_scaled_axis",
    "from_euler",
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "from_angle",
];

#[test]
fn elementary_functions_are_those_that_are_the_same_everywhere() {
    let mut found = Vec::new();
    let files = ["src", "plugins", "python"].iter().flat_map(|folder| rust_files_below(folder));
    for file in files.filter(|f| !f.contains("/tests/") && !f.ends_with("/tests.rs") && !f.starts_with("plugins/elementary/")) {
        let text = without_comments(without_tests(&read(&file)));
        for name in UNLIKE {
            let is_called = |before: &str| text.contains(&format!("{before}{name}("));
            let is_named = ["f64::", "f32::"].iter().any(|of| words_after(&text, of).any(|word| word == name));
            if is_called(".") || is_called("::") || is_named {
                found.push(format!("{file}: `{name}`: use bhs_elementary"));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// The words that follow `before` at once.
fn words_after<'t>(text: &'t str, before: &'t str) -> impl Iterator<Item = &'t str> {
    text.split(before).skip(1).filter_map(|after| words(after).next())
}

#[test]
fn unsafe_code_stands_in_two_files() {
    let unsafe_files: Vec<String> =
        all_rust_files().into_iter().filter(|f| words(&without_comments(&read(f))).any(|w| w == concat!("un", "safe"))).collect();
    // Each is the only one that speaks to a foreign library.
    assert_eq!(unsafe_files, ["src/denoise/oidn.rs", "plugins/intersectors/src/embree.rs"]);
}

#[test]
fn files_are_short() {
    for file in all_rust_files() {
        let lines = read(&file).lines().count();
        assert!(lines <= 400 || LONG.contains(&file.as_str()), "{file} has {lines} lines: split it by what it speaks of");
    }
}

#[test]
fn functions_take_six_arguments_at_most() {
    assert!(read("clippy.toml").contains("too-many-arguments-threshold = 6"));
    let allow = concat!("too_many_", "arguments");
    for file in all_rust_files() {
        assert!(!read(&file).contains(allow), "{file} allows more arguments");
    }
}

/// How rays meet surfaces does not depend on what bends them.
#[test]
fn tracing_knows_no_spacetime() {
    let mut names: Vec<String> = bhs_spacetimes::ALL.iter().flat_map(|p| p.name.split('-').map(str::to_owned)).collect();
    names.extend(["rs", "hole", "wormhole", "mass", "Class", "Spherical", "GradedIndex", "Metric"].map(str::to_owned));
    for file in rust_files_below("plugins/integrators/src/tracing") {
        let text = read(&file);
        let named =
            words(&text).find(|word| names.iter().any(|name| name == word || name.eq_ignore_ascii_case(word) && name.len() > 2));
        assert_eq!(named, None, "{file} names what bends light");
    }
}

/// Light transports and what records light never ask what the spacetime is.
#[test]
fn transports_ask_for_no_class() {
    for folder in ["plugins/transports", "plugins/films", "plugins/cameras", "plugins/lights", "plugins/materials", "src/render"]
    {
        for file in rust_files_below(folder) {
            assert!(!words(&read(&file)).any(|word| word == "Class"), "{file} asks what the spacetime is");
        }
    }
}

/// The names of the crates of bhs in the part of a manifest between two headings.
fn crates_of(manifest: &str, heading: &str) -> Vec<String> {
    let text = read(manifest);
    let Some((_, after)) = text.split_once(&format!("\n[{heading}]\n")) else { return Vec::new() };
    let part = after.split("\n[").next().unwrap_or_default();
    part.lines()
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .filter(|n| n.starts_with("bhs-"))
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_rooms_depend_on_what_is_below_them() {
    let none: [&str; 0] = [];
    assert_eq!(crates_of("plugins/elementary/Cargo.toml", "dependencies"), none);
    assert_eq!(crates_of("plugins/core/Cargo.toml", "dependencies"), ["bhs-elementary"]);
    assert_eq!(crates_of("plugins/colour/Cargo.toml", "dependencies"), ["bhs-elementary"]);
    assert_eq!(crates_of("plugins/engine/Cargo.toml", "dependencies"), ["bhs-core"]);
    let mut run_on_it = Vec::new();
    for entry in std::fs::read_dir(root().join("plugins")).expect("the folder can be read") {
        let name = entry.expect("it can be read").file_name().into_string().expect("names are text");
        let manifest = format!("plugins/{name}/Cargo.toml");
        let crates = crates_of(&manifest, "dependencies");
        assert!(!crates.iter().any(|c| c == "bhs"), "{name} depends on the program");
        if crates.iter().any(|c| c == "bhs-engine") {
            run_on_it.push(name);
        }
    }
    run_on_it.sort();
    assert_eq!(run_on_it, ["integrators", "layers", "transports"]);
}

#[test]
fn the_contract_and_the_engine_read_and_write_nothing() {
    for folder in ["plugins/core/src", "plugins/engine/src"] {
        for file in rust_files_below(folder) {
            // The test that a crate's files are listed is written there, and runs elsewhere.
            let text = without_comments(&read(&file)).replace("std::fs::read_dir(concat!(env!", "");
            for outside in ["std::fs", "std::io", "std::net", "std::process", "std::env", "println!", "eprint!"] {
                assert!(!text.contains(outside), "{file} uses {outside}");
            }
        }
    }
}

#[test]
fn standard_error_is_written_to_in_one_place() {
    for file in rust_files_below("src") {
        let text = without_comments(&read(&file));
        let writes = text.contains("stderr().lock()") || text.contains("eprint");
        assert_eq!(writes, file == "src/message.rs", "{file}");
    }
}

/// Whatever ARCHITECTURE.md and CONTRIBUTING.md name is there.
#[test]
fn what_the_guides_name_is_there() {
    let architecture = read("ARCHITECTURE.md");
    assert!(architecture.lines().count() <= 200, "ARCHITECTURE.md has {} lines", architecture.lines().count());
    for guide in [&architecture, &read("CONTRIBUTING.md")] {
        let quoted = guide.split('`').skip(1).step_by(2);
        let roots =
            |name: &&str| FOLDERS.iter().chain(&["docs", "grammar", "scenes"]).any(|f| name.starts_with(&format!("{f}/")));
        let plain = |name: &&str| name.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
        for name in quoted.filter(roots).filter(plain) {
            assert!(Path::new(root()).join(name).exists(), "{name} is named, and is not there");
        }
    }
}
