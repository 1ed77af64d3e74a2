//! What `bhs plugins` prints: the plugins, and their parameters as their constructors ask for them.

use crate::glossary;
use crate::lang::option_params;
use crate::registry::{PluginInfo, Registry, full_name};
use bhs_core::diagnostics::did_you_mean;
use bhs_engine::layer::LayerFormat;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// The name of a kind on the command line: one word.
fn word(kind: &str) -> String {
    match kind {
        "light transport" => "transport".into(),
        other => other.replace(' ', "-"),
    }
}

/// The kind that a word means: also a directive, and several of a kind.
fn meant(kind: &str) -> String {
    let plain = kind.to_lowercase().replace(['_', '-', ' '], "");
    match plain.strip_suffix('s').unwrap_or(&plain) {
        "blackhole" | "wormhole" | "hole" => "spacetime".into(),
        "lightsource" => "light".into(),
        "arealight" | "arealightsource" => "area-light".into(),
        "lighttransport" => "transport".into(),
        "pixelfilter" => "filter".into(),
        "makenamedmaterial" | "namedmaterial" => "material".into(),
        "spectra" => "spectrum".into(),
        one if Registry::KINDS.iter().any(|k| word(k) == one) || one == OPTION => one.to_owned(),
        _ => kind.to_owned(),
    }
}

/// What is no kind of plugin, but has parameters too.
const OPTION: &str = "option";

/// The table of `Option`.
fn options(registry: &Registry) -> PluginInfo {
    let params = option_params(registry);
    PluginInfo {
        kind: OPTION,
        name: "Option",
        summary: "what holds for the whole render",
        params,
        format: None,
        names: Vec::new(),
    }
}

/// The list of all plugins, of one kind, or of one plugin.
///
/// # Errors
/// If there is no such kind or plugin, with what there is.
pub fn render(registry: &Registry, kind: Option<&str>, name: Option<&str>) -> Result<String, String> {
    let all = registry.describe();
    let kinds: Vec<String> = Registry::KINDS.iter().map(|k| word(k)).collect();
    let mut text = String::new();
    let Some(kind) = kind else {
        for (kind, shown) in Registry::KINDS.iter().zip(&kinds) {
            heading(&mut text, shown);
            all.iter().filter(|p| p.kind == *kind).for_each(|p| summary_line(&mut text, p));
        }
        return Ok(text);
    };
    let kind = &*meant(kind);
    if kind == OPTION {
        heading(&mut text, kind);
        table(&mut text, &options(registry));
        return Ok(text);
    }
    if !kinds.iter().any(|k| k == kind) {
        let there_is: Vec<&str> = kinds.iter().map(String::as_str).chain([OPTION]).collect();
        return Err(unknown("kind of plugin", kind, &there_is));
    }
    let of_kind: Vec<&PluginInfo> = all.iter().filter(|p| word(p.kind) == kind).collect();
    match name {
        None => {
            heading(&mut text, kind);
            of_kind.iter().for_each(|p| table(&mut text, p));
        }
        Some(name) => match of_kind.iter().find(|p| p.name == name || p.name == full_name(kind, name)) {
            Some(plugin) => table(&mut text, plugin),
            None => {
                let there_is: Vec<&str> = of_kind.iter().map(|p| p.name).collect();
                let known = Registry::KINDS.iter().find(|k| word(k) == kind).and_then(|kind| glossary::plugin(kind, name));
                return Err(
                    known.map_or_else(|| unknown(kind, name, &there_is), |advice| format!("unknown {kind} `{name}`; {advice}"))
                );
            }
        },
    }
    Ok(text)
}

/// What [`render`] shows, as JSON: an array with an object for each plugin.
///
/// # Errors
/// As [`render`].
pub fn to_json(registry: &Registry, kind: Option<&str>, name: Option<&str>) -> Result<Value, String> {
    // The same faults in the same words.
    render(registry, kind, name)?;
    let kind = kind.map(meant);
    let kind = kind.as_deref();
    if kind == Some(OPTION) {
        return Ok(json!([plugin_json(&options(registry))]));
    }
    let all = registry.describe();
    let wanted = |p: &&PluginInfo| {
        kind.is_none_or(|k| k == word(p.kind)) && name.is_none_or(|n| n == p.name || full_name(p.kind, n) == p.name)
    };
    Ok(all.iter().filter(wanted).map(plugin_json).collect())
}

fn plugin_json(plugin: &PluginInfo) -> Value {
    let parameters = plugin.params.iter().map(|p| {
        let default = Some(p.default.as_str()).filter(|d| !matches!(*d, "required" | "none"));
        json!({
            "name": p.name, "type": p.ty, "default": default, "required": p.default == "required", "unit": p.unit, "meaning": p.about,
        })
    });
    let mut shown = json!({
        "kind": word(plugin.kind), "name": plugin.name, "summary": plugin.summary, "parameters": parameters.collect::<Vec<_>>(),
    });
    if let Some(format) = &plugin.format {
        shown["channels"] = json!(format.channels);
        shown["unit"] = json!(format.unit);
    }
    if !plugin.names.is_empty() {
        shown["names"] = json!(plugin.names);
    }
    shown
}

fn unknown(what: &str, name: &str, there_is: &[&str]) -> String {
    let hint = match did_you_mean(name, there_is.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there is {}", there_is.join(", ")),
    };
    format!("unknown {what} `{name}`; {hint}")
}

// Writing to a string cannot fail, so the results below are not looked at.

fn heading(text: &mut String, kind: &str) {
    let _ = writeln!(text, "{kind}");
}

fn summary_line(text: &mut String, plugin: &PluginInfo) {
    let _ = writeln!(text, "  {:<20} {}", plugin.name, plugin.summary);
}

fn table(text: &mut String, plugin: &PluginInfo) {
    summary_line(text, plugin);
    if let Some(LayerFormat { channels, unit, .. }) = plugin.format {
        let unit = if unit.is_empty() { String::new() } else { format!("  [{unit}]") };
        let _ = writeln!(text, "      {}{unit}", channels.join(", "));
    }
    if !plugin.names.is_empty() {
        let _ = writeln!(text, "      {}", plugin.names.join(", "));
    }
    let wide = |f: fn(&PluginInfo, usize) -> usize| (0..plugin.params.len()).map(|i| f(plugin, i)).max().unwrap_or(0);
    let (types, names) = (wide(|p, i| p.params[i].ty.len()), wide(|p, i| p.params[i].name.len()));
    let (defaults, units) = (wide(|p, i| p.params[i].default.len()), wide(|p, i| p.params[i].unit.len()));
    for p in &plugin.params {
        let _ = writeln!(
            text,
            "      {:<types$}  {:<names$}  {:<defaults$}  {:<units$}  {}",
            p.ty, p.name, p.default, p.unit, p.about
        );
    }
}
