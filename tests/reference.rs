//! The language reference keeps up with the language: its examples are scenes without fault, and every directive, every type and
//! every plugin has its section, the plugins with the parameter table that their constructors ask for.
//!
//! `BLESS=1 cargo test --test all reference::` writes the tables into `grammar/README.md`.

use crate::common::examples::{build_all, examples};
use bhs::lang;
use bhs::registry::{PluginInfo, Registry};
use bhs_core::value::ParamType;
use std::fs;

const PATH: &str = "grammar/README.md";
const TABLE: &str = "| parameter | type | default | unit | meaning |";

fn reference() -> String {
    fs::read_to_string(PATH).expect("the reference is there")
}

/// The part of `text` under the heading `heading`, up to the next one of the same or a higher level.
fn section<'t>(text: &'t str, heading: &str) -> Option<&'t str> {
    let from = text.find(&format!("\n{heading}\n"))? + 1;
    let level = heading.bytes().take_while(|b| *b == b'#').count();
    let mut to = from + heading.len();
    let mut code = false;
    for line in text[to..].split_inclusive('\n') {
        code ^= line.starts_with("```");
        let hashes = line.bytes().take_while(|b| *b == b'#').count();
        if !code && (1..=level).contains(&hashes) {
            break;
        }
        to += line.len();
    }
    Some(&text[from..to])
}

/// The heading over the plugins of a kind.
fn heading(kind: &str) -> String {
    let plural = if kind == "spectrum" { "spectra".to_owned() } else { format!("{kind}s") };
    format!("## {}{}", plural[..1].to_uppercase(), &plural[1..])
}

/// The table of a plugin's parameters; nothing if it has none.
fn table(plugin: &PluginInfo) -> String {
    if plugin.params.is_empty() {
        return String::new();
    }
    let rows = plugin.params.iter().map(|p| {
        let cell = |text: &str| text.replace('|', "\\|");
        let row = format!("| `{}` | {} | {} | {} | {} |\n", p.name, p.ty, cell(&p.default), p.unit, cell(p.about));
        row.replace("|  |", "| |").replace("|  |", "| |")
    });
    format!("{TABLE}\n|---|---|---|---|---|\n{}", rows.collect::<String>())
}

/// The section of a plugin with the table in it put right: after the text if there is none yet.
fn with_table(section: &str, table: &str) -> String {
    let (before, after) = match section.find(TABLE) {
        Some(from) => {
            let rows = section[from..].split_inclusive('\n').take_while(|l| l.starts_with('|')).map(str::len).sum::<usize>();
            (&section[..from], &section[from + rows..])
        }
        None if table.is_empty() => return section.to_owned(),
        None => section.split_at(section.find("```bhs").unwrap_or(section.len())),
    };
    let blank = if after.starts_with("```") { "\n" } else { "" };
    format!("{before}{table}{blank}{after}")
}

#[test]
fn every_example_is_a_scene_without_fault() {
    let text = reference();
    assert!(examples(&text).len() >= 50);
    build_all(PATH, &text);
}

#[test]
fn every_directive_has_a_section_with_an_example_of_it() {
    let text = reference();
    for keyword in lang::keywords() {
        let section = section(&text, &format!("### `{keyword}`")).unwrap_or_else(|| panic!("`{keyword}` has no section"));
        let shown = examples(section).iter().any(|e| e.split_whitespace().any(|word| word == keyword));
        assert!(shown, "no example under `{keyword}` shows it");
    }
}

#[test]
fn every_plugin_has_a_section_with_its_parameters_and_an_example_of_it() {
    let mut text = reference();
    let mut wrong = Vec::new();
    for plugin in Registry::builtin().describe() {
        let title = heading(plugin.kind);
        let kind = section(&text, &title).unwrap_or_else(|| panic!("`{title}` is missing"));
        let name = format!("### `{}`", plugin.name);
        let found =
            section(kind, &name).unwrap_or_else(|| panic!("{} `{}` has no section under `{title}`", plugin.kind, plugin.name));
        // Scenes do not write the names of what makes spectra.
        let is_written = plugin.kind != "spectrum";
        let shown = examples(found).iter().any(|e| !is_written || e.contains(&format!("\"{}\"", plugin.name)));
        assert!(shown, "no example under {} `{}` shows it", plugin.kind, plugin.name);
        let right = with_table(found, &table(&plugin));
        if right != found {
            wrong.push(format!("{} `{}`:\n{}", plugin.kind, plugin.name, table(&plugin)));
            text = text.replace(kind, &kind.replace(found, &right));
        }
    }
    if !wrong.is_empty() && std::env::var_os("BLESS").is_some() {
        fs::write(PATH, text).expect("the reference can be written");
    }
    assert!(wrong.is_empty(), "BLESS=1 writes these tables into {PATH}:\n{}", wrong.join("\n"));
}

#[test]
fn every_spectrum_of_a_name_is_listed() {
    let text = reference();
    let spectra = section(&text, "## Spectra").expect("there is one");
    for name in bhs_spectra::builtin_names() {
        assert!(spectra.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn every_type_stands_in_the_table_of_types() {
    let text = reference();
    let parameters = section(&text, "## Parameters").expect("there is one");
    for ty in ParamType::ALL {
        assert!(parameters.contains(&format!("`{}`", ty.word())), "{}", ty.word());
    }
}

#[test]
fn links_lead_to_headings() {
    let text = reference();
    let anchor = |line: &str| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
    };
    let anchors: Vec<String> = text.lines().filter(|l| l.starts_with('#')).map(anchor).collect();
    for link in text.split("](#").skip(1).map(|rest| rest.split(')').next().unwrap_or(rest)) {
        assert!(anchors.iter().any(|a| a == link), "#{link}");
    }
}
