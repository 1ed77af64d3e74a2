//! What comments cite of `docs/physics.md` stands there.

use std::fs;
use std::path::Path;

/// All source files below `folder` that are kept in the repository.
fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository").map(|entry| entry.expect("an entry").path()) {
        let name = entry.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if entry.is_dir() && !name.starts_with('.') && name != "target" {
            sources(&entry, found);
        } else if name.ends_with(".rs") {
            found.push(entry);
        }
    }
}

#[test]
fn cited_sections_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = fs::read_to_string(root.join("docs/physics.md")).expect("the page");
    let sections: Vec<&str> =
        page.lines().filter_map(|line| line.strip_prefix("## ")?.split_once(". ")).map(|(n, _)| n).collect();
    let numbered: Vec<String> = (1..=sections.len()).map(|n| n.to_string()).collect();
    assert_eq!(sections, numbered, "sections are numbered in their order");
    // Of the table of contents.
    for (number, title) in page.lines().filter_map(|line| line.strip_prefix("## ")?.split_once(". ")) {
        let anchor = format!("[{number}](#{number}-{})", title.to_lowercase().replace(' ', "-"));
        assert!(page.contains(&anchor), "no {anchor}");
    }
    let mut files = Vec::new();
    for folder in ["plugins", "src", "tests", "benches", "examples"] {
        sources(&root.join(folder), &mut files);
    }
    let mut cited = 0;
    for file in files {
        let text = fs::read_to_string(&file).expect("a source file").replace("\n//! ", " ").replace("\n/// ", " ");
        for rest in text.split(concat!("docs/physics.md", "`, section")).skip(1) {
            let numbers = rest.strip_prefix('s').unwrap_or(rest);
            let number: String = numbers.trim_start().chars().take_while(char::is_ascii_digit).collect();
            assert!(sections.contains(&number.as_str()), "{}: section `{number}`", file.display());
            cited += 1;
        }
    }
    assert!(cited > 5, "{cited}");
}
