//! Findings drawn as text, with the places they are about underlined.

use crate::lang::source::{SourceMap, floor_char};
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use bhs_core::diagnostics::{Diagnostic, Label, Severity, Span};
use serde_json::{Value, json};
use std::ops::Range;

/// Findings that are drawn; further ones are counted.
pub const MAX_SHOWN: usize = 50;

/// Lines between two places of one file that are drawn in one piece of text; places further apart get one each.
const MAX_GAP: usize = 200;

/// Draws all findings, one after the other, with colour on request.
pub fn render(found: &[Diagnostic], sources: &SourceMap, color: bool) -> String {
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut out = String::new();
    for diagnostic in found.iter().take(MAX_SHOWN) {
        out += &renderer.render(&[group(diagnostic, sources)]);
        out += "\n\n";
    }
    if found.len() > MAX_SHOWN {
        out += &format!("... and {} more\n\n", found.len() - MAX_SHOWN);
    }
    let errors = found.iter().filter(|d| d.severity == Severity::Error).count();
    if errors > 0 {
        out += &format!("{errors} error{}\n", if errors == 1 { "" } else { "s" });
    }
    out
}

/// A finding as a JSON object; lines and columns count from 1, columns in characters, and `end` is the place behind the last one.
pub fn to_json(d: &Diagnostic, sources: &SourceMap) -> Value {
    let severity = match d.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let mut object = json!({ "severity": severity, "code": d.code, "message": d.message, "help": d.help });
    if let Some(primary) = &d.primary {
        merge(&mut object, place(primary.span, sources));
        merge(&mut object, json!({ "label": primary.text }));
        let mut chain = Vec::new();
        let mut at = sources.get(primary.span.file).and_then(|s| s.included_at);
        while let Some(span) = at {
            chain.push(place(span, sources));
            at = sources.get(span.file).and_then(|s| s.included_at);
        }
        merge(&mut object, json!({ "included_from": chain }));
    } else if let Some(scene) = sources.get(0) {
        merge(&mut object, json!({ "file": scene.name }));
    }
    let label = |l: &Label| {
        let mut label = place(l.span, sources);
        merge(&mut label, json!({ "message": l.text }));
        label
    };
    merge(&mut object, json!({ "labels": d.labels.iter().map(label).collect::<Vec<_>>() }));
    object
}

/// File and range of a span; of what has been made of a model, the file alone.
fn place(span: Span, sources: &SourceMap) -> Value {
    if let Some(source) = sources.get(span.file).filter(|s| s.is_model) {
        return json!({ "file": source.name });
    }
    let (line, column) = sources.line_column(span.file, span.start);
    let (end_line, end_column) = sources.line_column(span.file, span.end);
    let file = sources.get(span.file).map(|s| s.name.as_str());
    json!({ "file": file, "line": line, "column": column, "end": { "line": end_line, "column": end_column } })
}

/// Adds the members of the object `from`.
fn merge(to: &mut Value, from: Value) {
    if let (Value::Object(to), Value::Object(from)) = (to, from) {
        to.extend(from);
    }
}

fn group<'a>(d: &'a Diagnostic, sources: &'a SourceMap) -> Group<'a> {
    let level = match d.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group = level.primary_title(d.message.as_str()).elements(snippets(d, sources));
    if let Some(name) = nameless(d, sources) {
        group = group.element(Origin::path(name));
    }
    if let Some((model, label)) = of_model(d, sources) {
        group = group.element(Origin::path(model));
        if !label.is_empty() {
            group = group.element(Level::NOTE.message(label));
        }
    }
    if let Some(help) = &d.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    // How the file came in, from the inside out.
    let mut at = d.primary.as_ref().and_then(|p| sources.get(p.span.file)?.included_at);
    while let Some(span) = at {
        let Some(source) = sources.get(span.file) else { break };
        let (line, column) = sources.line_column(span.file, span.start);
        group = group.element(Level::NOTE.message(format!("included from {}:{line}:{column}", source.name)));
        at = source.included_at;
    }
    group
}

/// The model that a finding is about and what its label says, where the scene has been made of one.
fn of_model<'a>(d: &'a Diagnostic, sources: &'a SourceMap) -> Option<(&'a str, &'a str)> {
    let primary = d.primary.as_ref()?;
    let source = sources.get(primary.span.file).filter(|s| s.is_model)?;
    Some((source.name.as_str(), primary.text.as_str()))
}

/// The scene's file, for a finding that has no place and does not name it.
fn nameless<'a>(d: &Diagnostic, sources: &'a SourceMap) -> Option<&'a str> {
    let name = sources.get(0).map(|scene| scene.name.as_str())?;
    (d.primary.is_none() && !d.message.contains(name)).then_some(name)
}

/// Whole lines of a file, with what is underlined in them.
struct Window<'a> {
    file: u16,
    lines: Range<usize>,
    labels: Vec<(AnnotationKind, Range<usize>, &'a str)>,
}

/// The pieces of text that the labels are about.
fn snippets<'a>(d: &'a Diagnostic, sources: &'a SourceMap) -> Vec<Snippet<'a, Annotation<'a>>> {
    // One window of lines for labels of one file that are near each other.
    let mut windows: Vec<Window> = Vec::new();
    let labels =
        d.primary.iter().map(|l| (AnnotationKind::Primary, l)).chain(d.labels.iter().map(|l| (AnnotationKind::Context, l)));
    for (kind, Label { span, text }) in labels {
        // Nobody has written what is made of a model.
        let Some(source) = sources.get(span.file).filter(|s| !s.is_model) else { continue };
        let place = first_line(&source.text, *span);
        let lines = line_range(&source.text, &place);
        let entry = (kind, place, text.as_str());
        let near = windows.iter_mut().find(|w| w.file == span.file && gap(&source.text, &w.lines, &lines) <= MAX_GAP);
        match near {
            Some(window) => {
                window.lines = window.lines.start.min(lines.start)..window.lines.end.max(lines.end);
                window.labels.push(entry);
            }
            None => windows.push(Window { file: span.file, lines, labels: vec![entry] }),
        }
    }
    windows.into_iter().filter_map(|window| draw(window, sources)).collect()
}

fn draw<'a>(window: Window<'a>, sources: &'a SourceMap) -> Option<Snippet<'a, Annotation<'a>>> {
    let Window { file, lines, labels } = window;
    let source = sources.get(file)?;
    let (line, _) = sources.line_column(file, lines.start as u32);
    let text = &source.text[lines.clone()];
    let annotations = labels.into_iter().map(|(kind, place, text)| {
        let annotation = kind.span(place.start - lines.start..place.end - lines.start);
        if text.is_empty() { annotation } else { annotation.label(text) }
    });
    Some(Snippet::source(text).path(source.name.as_str()).line_start(line).annotations(annotations))
}

/// The bytes of `span` up to the end of its first line.
fn first_line(text: &str, span: Span) -> Range<usize> {
    let start = floor_char(text, span.start as usize);
    let end = floor_char(text, span.end as usize).max(start);
    let line_end = text[start..end].find('\n').map_or(end, |i| start + i);
    let line_end = start + text[start..line_end].trim_end_matches('\r').len();
    start..line_end
}

/// The bytes of the whole lines around `place`.
fn line_range(text: &str, place: &Range<usize>) -> Range<usize> {
    let start = text[..place.start].rfind('\n').map_or(0, |i| i + 1);
    let end = text[place.end..].find('\n').map_or(text.len(), |i| place.end + i);
    start..end
}

/// Lines between two ranges.
fn gap(text: &str, a: &Range<usize>, b: &Range<usize>) -> usize {
    let (from, to) = if a.start <= b.start { (a.end, b.start) } else { (b.end, a.start) };
    if from >= to { 0 } else { text.as_bytes()[from..to].iter().filter(|b| **b == b'\n').count() }
}
