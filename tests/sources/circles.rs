//! Files that import one another in a circle: a module and the files of its own folder are one thing; other circles stand in ARCHITECTURE.md.

use super::{rust_files_below, without_comments, without_tests};
use crate::common::{read, root};
use std::collections::{BTreeMap, BTreeSet};

/// A module by the names on the way to it from the crate's root.
type Module = Vec<String>;

/// The files of a crate by module.
fn modules(src: &str) -> BTreeMap<Module, String> {
    let mut found = BTreeMap::new();
    for file in rust_files_below(src) {
        let within = &file[src.len() + 1..file.len() - ".rs".len()];
        let mut module: Module = within.split('/').map(str::to_owned).collect();
        if module.last().is_some_and(|name| name == "mod") {
            module.pop();
        }
        if !matches!(within, "lib" | "main") && module.last().is_some_and(|name| name != "tests") {
            found.insert(module, file);
        }
    }
    found
}

/// Takes the paths of a `use` apart: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let Some((head, rest)) = tree.split_once('{') else { return vec![tree.trim().to_owned()] };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let (mut all, mut depth, mut part) = (Vec::new(), 0, String::new());
    for c in inner.chars().chain([',']) {
        match c {
            ',' if depth == 0 => {
                all.extend(expand(&part).into_iter().map(|path| format!("{}{path}", head.trim())));
                part.clear();
                continue;
            }
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        part.push(c);
    }
    all
}

/// All paths of names that a text has, those of `use` taken apart.
fn paths(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut rest = String::new();
    for statement in text.split_inclusive(';') {
        match statement.rsplit_once("use ") {
            Some((before, tree)) if before.is_empty() || before.ends_with(['\n', ' ', ')']) => {
                all.extend(expand(tree.trim_end_matches(';')));
                rest.push_str(before);
            }
            _ => rest.push_str(statement),
        }
    }
    all.extend(
        rest.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).filter(|p| p.contains("::")).map(str::to_owned),
    );
    all
}

/// The module that a path in `module` leads to, if it is one of the crate's.
fn target(path: &str, module: &Module, modules: &BTreeMap<Module, String>) -> Option<Module> {
    let mut names = path.split("::").map(str::trim).peekable();
    let mut at: Module = match names.peek().copied()? {
        "crate" => Vec::new(),
        "self" | "super" => module.clone(),
        first if modules.contains_key(&[&module[..], &[first.to_owned()]].concat()) => module.clone(),
        _ => return None,
    };
    while let Some(name) = names.next_if(|name| matches!(*name, "crate" | "self" | "super")) {
        if name == "super" {
            at.pop();
        }
    }
    for name in names {
        at.push(name.split(' ').next()?.to_owned());
        if !modules.contains_key(&at) {
            at.pop();
            break;
        }
    }
    (at != *module && !at.is_empty()).then_some(at)
}

/// The circles between files of a crate that are more than a module with the files of its own folder.
fn circles(src: &str) -> BTreeSet<BTreeSet<String>> {
    let modules = modules(src);
    let mut reached: BTreeMap<&Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, file) in &modules {
        let text = without_comments(without_tests(&read(file)));
        reached.insert(module, paths(&text).iter().filter_map(|path| target(path, module, &modules)).collect());
    }
    loop {
        let before: usize = reached.values().map(BTreeSet::len).sum();
        for module in modules.keys() {
            let further: Vec<Module> = reached[module].iter().flat_map(|next| reached[next].iter().cloned()).collect();
            reached.entry(module).or_default().extend(further);
        }
        if before == reached.values().map(BTreeSet::len).sum::<usize>() {
            break;
        }
    }
    let circle_of = |module: &&Module| -> Vec<&Module> {
        modules.keys().filter(|other| reached[*module].contains(*other) && reached[*other].contains(*module)).collect()
    };
    let is_family = |circle: &Vec<&Module>| circle.iter().any(|head| circle.iter().all(|module| module.starts_with(head)));
    let name = |module: &&Module| format!("{src}/{}", module.join("/"));
    modules.keys().map(|m| circle_of(&m)).filter(|c| c.len() > 1 && !is_family(c)).map(|c| c.iter().map(name).collect()).collect()
}

/// The circles that ARCHITECTURE.md names, one a line of its list.
fn told() -> BTreeSet<BTreeSet<String>> {
    let text = read("ARCHITECTURE.md");
    let (_, after) = text.split_once("\n## Circles\n").expect("a section of circles");
    let section = after.split("\n## ").next().unwrap_or_default();
    let items = section.split("\n- ").skip(1);
    items.map(|item| item.split('`').skip(1).step_by(2).filter(|name| name.contains('/')).map(str::to_owned).collect()).collect()
}

#[test]
fn circles_of_imports_are_those_that_are_told() {
    let mut found = circles("src");
    for entry in std::fs::read_dir(root().join("plugins")).expect("the folder can be read") {
        let name = entry.expect("it can be read").file_name().into_string().expect("names are text");
        found.extend(circles(&format!("plugins/{name}/src")));
    }
    assert_eq!(found, told(), "left: circles between files; right: those of ARCHITECTURE.md");
}

/// The reader of imports sees a circle where there is one.
#[test]
fn paths_are_read() {
    assert_eq!(
        expand("crate::a::{self, b::{C, D}, e as f}"),
        ["crate::a::self", "crate::a::b::C", "crate::a::b::D", "crate::a::e as f"]
    );
    let text = "use crate::a::B;\npub(super) use super::c::{D, E};\nfn f() { g::h(crate::i::J) }\n";
    let all = paths(text);
    for path in ["crate::a::B", "super::c::D", "super::c::E", "g::h", "crate::i::J"] {
        assert!(all.iter().any(|p| p == path), "{path} in {all:?}");
    }
    let modules: BTreeMap<Module, String> =
        [vec!["a"], vec!["a", "b"], vec!["c"]].map(|m| (m.into_iter().map(str::to_owned).collect(), String::new())).into();
    let at = vec!["a".to_owned()];
    let to = |path: &str| target(path, &at, &modules).map(|m| m.join("/"));
    assert_eq!(to("b::X").as_deref(), Some("a/b"));
    assert_eq!(to("crate::c::f").as_deref(), Some("c"));
    assert_eq!(to("super::c").as_deref(), Some("c"));
    assert_eq!((to("std::fs"), to("self::Y"), to("crate::Z")), (None, None, None));
}
