//! The inputs that fuzzing has found worth keeping, and the faults that it has found, run through the code of the fuzz targets.

#[path = "../fuzz/src/targets.rs"]
pub mod targets;

use std::collections::BTreeSet;
use std::path::Path;

/// Names in a folder.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    entries.map(|e| e.expect("it can be read").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn kept_inputs_do_no_harm() {
    let mut size = 0;
    for name in targets::NAMES {
        let folder = Path::new("fuzz/corpus").join(name);
        let files = names(&folder);
        assert!(!files.is_empty(), "no input is kept for `{name}`");
        for file in files {
            let path = folder.join(file);
            let data = std::fs::read(&path).expect("it can be read");
            size += data.len();
            // The failing one is the last that is said.
            println!("{}", path.display());
            targets::run(name, &data);
        }
    }
    assert!(size < 1 << 20, "the corpus has {size} bytes: minimize it, see fuzz/README.md");
}

#[test]
fn every_target_has_a_program_and_inputs() {
    let all: BTreeSet<String> = targets::NAMES.map(str::to_owned).into();
    assert_eq!(names(Path::new("fuzz/corpus")), all);
    assert_eq!(names(Path::new("fuzz/fuzz_targets")), all.iter().map(|name| format!("{name}.rs")).collect());
    let manifest = std::fs::read_to_string("fuzz/Cargo.toml").expect("it can be read");
    for name in &all {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name}");
    }
}
