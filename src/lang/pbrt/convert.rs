//! A scene as one text in our own terms: pbrt-v4's directives translated, included files in their places, paths seen from where the text is to
//! stand. It describes the same scene, to the bit.

use crate::lang::ast::{Directive, Holder};
use crate::lang::params;
use crate::lang::parse::Directives;
use crate::lang::pbrt::Translator;
use crate::lang::source::SourceMap;
use crate::lang::variables::Variables;
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::value::{Param, ParamType, Values};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The text of the scene whose first file is number `file`, for a file in `folder`.
///
/// # Errors
/// What is wrong with its syntax and its files.
pub fn convert(sources: &mut SourceMap, file: u16, given: &Variables, folder: &Path) -> Result<String, Vec<Diagnostic>> {
    let mut converter = Converter {
        sources,
        given,
        defined: BTreeMap::new(),
        translator: Translator::default(),
        folder: real(folder),
        out: String::new(),
        found: Vec::new(),
    };
    converter.file(file);
    let scene = file;
    for path in converter.sources.additions().to_vec() {
        converter.translator.start_addition();
        match converter.sources.open_addition(&path, file) {
            Ok(file) => {
                converter.out += "AttributeBegin\nIdentity\n";
                if converter.sources.get(scene).is_some_and(|s| s.is_model) {
                    converter.out += "Scale 1 1 -1\n";
                }
                converter.file(file);
                converter.out += "AttributeEnd\n";
            }
            Err(fault) => converter.found.push(*fault),
        }
    }
    let rest = converter.translator.finish(&mut converter.found);
    rest.iter().for_each(|d| converter.print(d));
    if crate::lang::has_errors(&converter.found) { Err(converter.found) } else { Ok(converter.out) }
}

struct Converter<'s> {
    sources: &'s mut SourceMap,
    given: &'s Variables,
    /// Numbers of `Define`.
    defined: BTreeMap<String, f64>,
    translator: Translator,
    /// Where the text is to stand.
    folder: PathBuf,
    out: String,
    found: Vec<Diagnostic>,
}

impl Converter<'_> {
    fn file(&mut self, file: u16) {
        let Some((text, is_pbrt)) = self.sources.get(file).map(|s| (Arc::clone(&s.text), s.is_pbrt)) else { return };
        let mut reader = Directives::new(&text, file);
        while let Some(mut directive) = reader.next() {
            self.found.extend(reader.take_faults());
            if !is_pbrt {
                self.run(directive);
                continue;
            }
            self.substitute(&mut directive);
            let translated = self.translator.translate(directive, &mut self.found);
            translated.directives.into_iter().for_each(|d| self.run(d));
            if translated.is_import {
                self.translator.end_import();
            }
        }
        self.found.extend(reader.into_faults());
    }

    /// Prints a directive, or what it includes.
    fn run(&mut self, d: Directive) {
        if d.keyword.value != "Include" {
            return self.print(&d);
        }
        let Some(path) = params::text(&d, 0).cloned() else { return self.print(&d) };
        match self.sources.include(&path.value, path.span) {
            Ok(file) => self.file(file),
            Err(fault) => self.found.push(*fault),
        }
    }

    /// Numbers in place of the variables of a directive that is to be translated.
    fn substitute(&mut self, d: &mut Directive) {
        if d.keyword.value == "Define"
            && let (Some(name), Some(value)) = (params::text(d, 0), params::numbers(d).first())
        {
            self.defined.insert(name.value.clone(), *value);
        }
        for reference in std::mem::take(&mut d.references) {
            let values = match reference.of {
                Holder::Arg(i) => d.args.get_mut(i).map(|a| &mut a.values),
                Holder::Param(i) => d.params.get_mut(i).map(|p| &mut p.values),
            };
            let name = &reference.name.value;
            let number = self.given.find(name).map(|(v, _)| v).or_else(|| self.defined.get(name).copied()).unwrap_or(0.0);
            if let Some(Values::Numbers { values, whole }) = values
                && let Some(value) = values.get_mut(reference.index)
            {
                *value = if reference.negative { -number } else { number };
                *whole &= number.fract() == 0.0;
            }
        }
    }

    fn print(&mut self, d: &Directive) {
        self.out += &d.keyword.value;
        for (i, arg) in d.args.iter().enumerate() {
            self.out.push(' ');
            let is_list = !matches!(&arg.values, Values::Strings(s) if s.len() == 1) && self.is_listed(arg.span);
            self.values(d, Holder::Arg(i), &arg.values, is_list);
        }
        for (i, param) in d.params.iter().enumerate() {
            let _ = write!(self.out, " \"{} {}\" ", param.ty.value.word(), param.name.value);
            let values = self.placed(d, param);
            let is_list = count(&values) != 1;
            self.values(d, Holder::Param(i), &values, is_list);
        }
        self.out.push('\n');
    }

    /// Whether an argument stands in brackets where it was written.
    fn is_listed(&self, span: Span) -> bool {
        self.sources.get(span.file).and_then(|s| s.text.get(span.start as usize..)).is_some_and(|t| t.starts_with('['))
    }

    fn values(&mut self, d: &Directive, of: Holder, values: &Values, is_list: bool) {
        if is_list {
            self.out.push('[');
        }
        let mut gap = "";
        let mut next = |out: &mut String| out.push_str(std::mem::replace(&mut gap, " "));
        match values {
            Values::Numbers { values, whole } => {
                for (index, value) in values.iter().enumerate() {
                    next(&mut self.out);
                    match d.references.iter().find(|r| r.of == of && r.index == index) {
                        Some(r) => {
                            let _ = write!(self.out, "{}${}", if r.negative { "-" } else { "" }, r.name.value);
                        }
                        None => number(&mut self.out, *value, *whole),
                    }
                }
            }
            Values::Strings(texts) => {
                for text in texts {
                    next(&mut self.out);
                    let _ = write!(self.out, "\"{}\"", text.value.replace('\\', "\\\\").replace('"', "\\\""));
                }
            }
            Values::Bools(all) => {
                for value in all {
                    next(&mut self.out);
                    let _ = write!(self.out, "{value}");
                }
            }
        }
        if is_list {
            self.out.push(']');
        }
    }

    /// The values of a parameter, with paths of files as they are seen from where the text is to stand.
    fn placed(&mut self, d: &Directive, param: &Param) -> Values {
        // The picture that is to be written is named from where the program is started.
        let is_output = d.keyword.value == "Film";
        let (Values::Strings(texts), false) = (&param.values, is_output) else { return param.values.clone() };
        let is_path = |text: &str| match param.ty.value {
            ParamType::String => matches!(param.name.value.as_str(), "filename" | "normalmap"),
            ParamType::Spectrum => text.contains(['/', '.']),
            _ => false,
        };
        let mut texts = texts.clone();
        for text in texts.iter_mut().filter(|t| is_path(&t.value)) {
            let path = real(&self.sources.folder(text.span)).join(&text.value);
            // What the scene reads is not to be written over.
            self.sources.add_input(&path, "the scene");
            if !Path::new(&text.value).is_absolute() {
                text.value = seen_from(&self.folder, &path);
            }
        }
        Values::Strings(texts)
    }
}

fn count(values: &Values) -> usize {
    match values {
        Values::Numbers { values, .. } => values.len(),
        Values::Strings(texts) => texts.len(),
        Values::Bools(all) => all.len(),
    }
}

/// Writes a number so that reading it again gives the same one.
fn number(out: &mut String, value: f64, whole: bool) {
    let plain = value == 0.0 || (1e-6..1e16).contains(&value.abs());
    let _ = match (whole, plain) {
        (true, _) | (false, true) => write!(out, "{value}"),
        (false, false) => write!(out, "{value:e}"),
    };
}

/// A folder without links and `..`, as far as it is there.
fn real(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    folder.canonicalize().or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.to_owned())
}

/// The path `path` as it is seen from `folder`; both are absolute.
fn seen_from(folder: &Path, path: &Path) -> String {
    let mut parts: Vec<Component> = Vec::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(parts.last(), Some(Component::Normal(_))) => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    let own: Vec<Component> = folder.components().collect();
    let shared = own.iter().zip(&parts).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return path.to_string_lossy().into_owned();
    }
    let up = std::iter::repeat_n("..".to_owned(), own.len() - shared);
    let down = parts[shared..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned());
    let relative: Vec<String> = up.chain(down).collect();
    // A spectrum is a file if its name says so.
    relative.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_another_folder() {
        let seen = |from: &str, to: &str| seen_from(Path::new(from), Path::new(to));
        assert_eq!(seen("/a/b", "/a/b/c/d.ply"), "c/d.ply");
        assert_eq!(seen("/a/b", "/a/x/./y/../d.ply"), "../x/d.ply");
    }

    #[test]
    fn numbers_come_back_as_they_were() {
        for value in [0.1, 1.0 / 3.0, 1e-30, -2.5e300, 0.0, -0.0, 123_456_789.123_456_78, 5e-324, f64::MAX] {
            let mut text = String::new();
            number(&mut text, value, false);
            assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(value.to_bits()), "{text}");
        }
    }
}
