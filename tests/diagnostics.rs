//! Faulty scenes say what is wrong with them, where, and what to do.
//!
//! Every `tests/diagnostics/*.bhs` states its findings in comments above the lines they are about:
//!
//! ```text
//! # error: 8-15 unknown shape `shpere`
//! # help: did you mean `sphere`?
//! Shape "shpere"
//! ```
//!
//! with the first and the last column that is underlined, `none` at the top of the file for what has no place. `warning:` and
//! `and:` (a second place) work likewise. `BLESS=1 cargo test --test all diagnostics::` writes what is found into the files.

use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Severity, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

pub const FOLDER: &str = "tests/diagnostics";
const MARKS: [&str; 4] = ["# error: ", "# warning: ", "# and: ", "# help: "];

pub fn findings(path: &str, overrides: &Overrides) -> (Vec<Diagnostic>, SourceMap) {
    let mut sources = SourceMap::new();
    let found = match lang::load(path, &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => built.warnings,
        Err(found) => found,
    };
    (found, sources)
}

/// Columns of a span on its first line.
fn columns(sources: &SourceMap, span: Span) -> String {
    let text = &sources.get(span.file).expect("spans lie in files").text;
    let (_, first) = sources.line_column(span.file, span.start);
    let underlined = text[span.start as usize..span.end as usize].lines().next().unwrap_or("");
    match underlined.chars().count() {
        0 | 1 => format!("{first}"),
        n => format!("{first}-{}", first + n - 1),
    }
}

/// The comments that the findings ask for, by file and line (line 0 for what has no place).
fn wanted(found: &[Diagnostic], sources: &SourceMap) -> BTreeMap<u16, BTreeMap<usize, Vec<String>>> {
    let mut wanted: BTreeMap<u16, BTreeMap<usize, Vec<String>>> = BTreeMap::new();
    for d in found {
        let word = match d.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        let (file, line, place) = match &d.primary {
            Some(p) => (p.span.file, sources.line_column(p.span.file, p.span.start).0, columns(sources, p.span)),
            None => (0, 0, "none".into()),
        };
        let said = d.primary.as_ref().map(|p| p.text.as_str()).filter(|t| !t.is_empty());
        let said = said.map(|t| format!(" ({t})")).unwrap_or_default();
        let comments = wanted.entry(file).or_default().entry(line).or_default();
        comments.push(format!("# {word}: {place} {}{said}", d.message));
        for l in &d.labels {
            let line = sources.line_column(l.span.file, l.span.start).0;
            // Comments move lines, so that its text stands for the line.
            let text = original_line(sources, l.span.file, line);
            comments.push(format!("# and: {} `{text}` {}", columns(sources, l.span), l.text));
        }
        comments.extend(d.help.iter().map(|h| format!("# help: {h}")));
    }
    wanted
}

fn original_line(sources: &SourceMap, file: u16, line: usize) -> String {
    let text = &sources.get(file).expect("labels lie in files").text;
    text.lines().nth(line.wrapping_sub(1)).unwrap_or("").trim().to_owned()
}

/// A file with the comments that are wanted, in place of those that it has.
fn annotated(text: &str, wanted: &BTreeMap<usize, Vec<String>>) -> String {
    let mut out: Vec<&str> = Vec::new();
    out.extend(wanted.get(&0).into_iter().flatten().map(String::as_str));
    for (number, line) in text.split_inclusive('\n').enumerate() {
        if MARKS.iter().any(|m| line.starts_with(m)) {
            continue;
        }
        out.extend(wanted.get(&(number + 1)).into_iter().flatten().map(String::as_str));
        out.push(line);
    }
    out.iter()
        .map(|l| if l.ends_with('\n') || l == out.last().unwrap_or(&"") { (*l).to_owned() } else { format!("{l}\n") })
        .collect()
}

/// What a scene's files should say and do not; writes it into them if asked to.
fn check(path: &Path, bless: bool) -> Vec<String> {
    let (found, sources) = findings(&path.to_string_lossy(), &Overrides::default());
    let wanted = wanted(&found, &sources);
    let mut wrong = Vec::new();
    for (number, source) in sources.iter().enumerate() {
        if source.name.starts_with('<') {
            continue;
        }
        let nothing = BTreeMap::new();
        let expected = annotated(&source.text, wanted.get(&(number as u16)).unwrap_or(&nothing));
        if *expected != *source.text {
            if bless {
                fs::write(&source.name, &expected).expect("the scenes can be written");
            }
            wrong.push(format!("--- {} should read\n{expected}", source.name));
        }
    }
    if found.is_empty() {
        wrong.push(format!("--- {}: nothing is wrong with it", path.display()));
    }
    wrong
}

fn scenes() -> Vec<PathBuf> {
    let entries = fs::read_dir(FOLDER).expect("the folder is there").map(|e| e.expect("and can be read").path());
    let mut scenes: Vec<PathBuf> = entries.filter(|p| p.extension().is_some_and(|e| e == "bhs")).collect();
    scenes.sort();
    scenes
}

#[test]
fn faulty_scenes_say_what_is_wrong() {
    let bless = std::env::var_os("BLESS").is_some();
    let scenes = scenes();
    assert!(scenes.len() >= 90, "only {} scenes", scenes.len());
    let wrong: Vec<String> = scenes.iter().flat_map(|s| check(s, bless)).collect();
    assert!(wrong.is_empty(), "{}\nBLESS=1 writes this into the scenes", wrong.join("\n"));
}

/// Kinds of findings that no faulty scene of the folder shows, and why.
const SHOWN_ELSEWHERE: &[(&str, &str)] = &[
    ("bad-keys", "of a file of keys: src/animation/keys.rs"),
    ("cannot-write", "of outputs, which are looked at when the scene is built: tests/outputs.rs"),
    ("output-is-input", "likewise"),
    ("output-not-exr", "likewise"),
    ("outputs-coincide", "likewise"),
    ("outside-root", "likewise: tests/confined.rs"),
    ("would-overwrite", "likewise"),
    ("camera-inside", "of a picture that is black, when it is done: tests/black"),
    ("camera-shut-in", "likewise"),
    ("lights-enclosed", "likewise"),
    ("nothing-there", "likewise"),
    ("only-the-hole", "likewise"),
    ("reflects-nothing", "likewise"),
    ("specular-only", "likewise"),
    ("unlit-side", "likewise"),
    ("attribute-depth", "a scene of a thousand lines: src/lang/tests.rs"),
    ("file-too-large", "takes 4 GiB"),
    ("include-depth", "takes 65 files: src/lang/tests.rs"),
    ("incomplete", "a fault of bhs"),
    ("intersector-failed", "a fault of the intersector"),
    ("negative-light", "takes a picture of floats, which the folder has none of"),
    ("nested-too-deep", "a scene of a hundred lines: tests/limits.rs"),
    ("plugin-failed", "a fault of a plugin"),
    ("too-large", "depends on the machine: tests/memory.rs"),
    ("too-many-errors", "a scene of a thousand lines: tests/limits.rs"),
    ("too-many-files", "a scene of 65,536 lines: src/lang/tests.rs"),
    ("unknown-camera", "on the command line: tests/command_line.rs"),
    ("unused-variable", "on the command line: tests/variables.rs"),
    ("unreadable", "a scene that the grammar does not cover: there is none"),
];

/// The kinds of findings that the source files below `folder` make, by the name that follows one of the functions that make them.
fn codes(folder: &Path, into: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).expect("the folder is there") {
        let path = entry.expect("and can be read").path();
        if path.is_dir() {
            codes(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).expect("source files can be read");
            let text = text.split("#[cfg(test)]").next().unwrap_or("");
            for made in ["error(", "warning(", "fault(", "refuse("] {
                for rest in text.split(made).skip(1).filter_map(|rest| rest.trim_start().strip_prefix('"')) {
                    let code = rest.split('"').next().unwrap_or("");
                    if code.contains('-') && code.bytes().all(|b| b.is_ascii_lowercase() || b == b'-') {
                        into.insert(code.to_owned());
                    }
                }
            }
        }
    }
}

#[test]
fn every_kind_of_finding_has_a_scene() {
    let mut made = BTreeSet::new();
    codes(Path::new("src"), &mut made);
    for plugin in fs::read_dir("plugins").expect("the folder is there") {
        codes(&plugin.expect("and can be read").path().join("src"), &mut made);
    }
    assert!(made.len() > 40, "{made:?}");
    let shown: BTreeSet<&str> =
        scenes().iter().flat_map(|s| findings(&s.to_string_lossy(), &Overrides::default()).0).map(|d| d.code).collect();
    let missing: Vec<&String> =
        made.iter().filter(|c| !shown.contains(c.as_str()) && SHOWN_ELSEWHERE.iter().all(|(e, _)| e != c)).collect();
    assert!(missing.is_empty(), "no scene in {FOLDER} shows {missing:?}");
}

#[test]
fn every_directive_is_at_fault_somewhere() {
    let texts: Vec<String> = scenes().iter().map(|s| fs::read_to_string(s).unwrap_or_default()).collect();
    for keyword in lang::keywords() {
        let faulty = texts.iter().any(|text| {
            let lines: Vec<&str> = text.lines().collect();
            lines.windows(2).any(|w| MARKS.iter().any(|m| w[0].starts_with(m)) && w[1].split(' ').next() == Some(keyword))
        });
        assert!(faulty, "no scene in {FOLDER} has a fault in `{keyword}`");
    }
}

#[test]
fn a_missing_scene_is_an_error_and_so_is_a_folder() {
    for (path, message) in [
        (
            "tests/diagnostics/unknown_paramter.bhs",
            "there is no such file in `tests/diagnostics`; did you mean `unknown_parameter.bhs`?",
        ),
        ("tests/diagnostics", "it is a directory"),
        ("tests/nowhere/scene.bhs", "there is no folder `tests/nowhere`"),
    ] {
        let (found, _) = findings(path, &Overrides::default());
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].message, format!("cannot read the scene `{path}`: {message}"));
    }
}

#[test]
fn many_errors_are_counted() {
    let mut sources = SourceMap::new();
    let file = sources.add("many", &"Nonsense\n".repeat(120));
    let (description, found) = lang::resolve::resolve(&mut sources, file);
    let Err(found) = lang::build(description, found, &Registry::builtin(), &Overrides::default(), &mut sources) else {
        panic!("it is faulty")
    };
    let text = bhs::report::render(&found, &sources, false);
    assert!(text.ends_with("... and 71 more\n\n121 errors\n"), "{text}");
}
