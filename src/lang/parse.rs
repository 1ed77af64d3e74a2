//! Text to directives. Knows the grammar, and neither directives nor plugins.
//!
//! Reading never stops: what is at fault is reported where it opens, left out, and the next directive is read.

use crate::lang::ast::{Arg, Directive, Holder, Reference};
use crate::lang::foreign;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean, shorten};
use bhs_core::value::{Param, ParamType, Values};
use grammar::{Grammar, Rule};
use pest::Parser;
use pest::iterators::Pair;

mod plain;
mod values;

pub(crate) use values::{is_variable_name, read_number};

/// The parser that pest makes from the grammar.
mod grammar {
    #![allow(missing_docs)] // generated
    #[derive(pest_derive::Parser)]
    #[grammar = "../grammar/bhs.pest"]
    pub struct Grammar;
}

/// Reads all of `text`, which is file number `file`.
pub fn parse(text: &str, file: u16) -> (Vec<Directive>, Vec<Diagnostic>) {
    let mut directives = Directives::new(text, file);
    let all = directives.by_ref().collect();
    (all, directives.into_faults())
}

/// Errors of a scene that are looked for; behind the last of them reading ends.
pub const MAX_ERRORS: usize = 1000;

/// Says that reading ends at a byte of a file.
pub(super) fn too_many(file: u16, at: u32) -> Diagnostic {
    let message = format!("there are {MAX_ERRORS} errors; what follows is not read");
    Diagnostic::error("too-many-errors", message).at(Span { file, start: at, end: at }, "").help("mend those before it first")
}

/// Reads `text` directive by directive, so that memory is needed for one at a time.
pub struct Directives<'t> {
    lower: Lower<'t>,
    /// First byte that has not been read.
    position: usize,
    /// Whether everything is read by the grammar, what is plainly right too.
    by_grammar: bool,
}

impl<'t> Directives<'t> {
    /// Starts at the beginning of `text`, which is file number `file`.
    pub fn new(text: &'t str, file: u16) -> Self {
        Self { lower: Lower::new(text, file), position: 0, by_grammar: false }
    }

    /// The same, with `keywords` as the words that are suggested in place of one that is unknown.
    #[must_use]
    pub fn suggesting(mut self, keywords: &'static [&'static str]) -> Self {
        self.lower.keywords = keywords;
        self
    }

    /// As [`Directives::new`], with the same result, but slower: even what is plainly right is read by the grammar.
    pub fn by_grammar(text: &'t str, file: u16) -> Self {
        Self { by_grammar: true, ..Self::new(text, file) }
    }

    /// Takes the faults found since the last call.
    pub fn take_faults(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.lower.faults)
    }

    /// Ends the reading with the faults that have not been taken.
    pub fn into_faults(self) -> Vec<Diagnostic> {
        self.lower.faults
    }
}

impl Iterator for Directives<'_> {
    type Item = Directive;

    fn next(&mut self) -> Option<Directive> {
        if self.position == 0
            && let Some(language) = foreign::other_language(self.lower.text)
        {
            let start = self.lower.text.len() - foreign::after_comments(self.lower.text).len();
            let here = self.lower.range(start, start + 1);
            let help = "scenes are written as for pbrt-v4: docs/tutorial.md has a first one".to_owned();
            self.lower.fault(
                "other-language",
                format!("this is no scene of bhs: it looks like {language}"),
                here,
                "",
                Some(help),
            );
            self.position = usize::MAX;
        }
        loop {
            if self.lower.count >= MAX_ERRORS && self.position < self.lower.text.len() {
                self.lower.faults.push(too_many(self.lower.file, self.position as u32));
                self.position = usize::MAX;
                return None;
            }
            if !self.by_grammar
                && self.position < self.lower.text.len()
                && let Some(directive) = plain::directive(self.lower.text, self.position, self.lower.file)
            {
                self.position = directive.span.end as usize;
                return Some(directive);
            }
            let rest = self.lower.text.get(self.position..)?;
            let pair = match Grammar::parse(Rule::statement, rest) {
                Ok(mut pairs) => pairs.next()?,
                Err(error) => {
                    // The grammar has a rule for everything; what is left is pest's guard of a nearly full stack.
                    self.lower.base = self.position;
                    let here = self.lower.range(0, 0);
                    self.lower.fault("unreadable", "the scene cannot be read any further", here, error.variant.message(), None);
                    self.position = usize::MAX;
                    return None;
                }
            };
            self.lower.base = self.position;
            self.position += pair.as_span().end();
            match pair.as_rule() {
                Rule::EOI => return None,
                Rule::directive => return Some(self.lower.lower_directive(pair)),
                _ => {
                    let is_comment =
                        pair.as_rule() == Rule::stray && (pair.as_str().starts_with("//") || pair.as_str().starts_with("/*"));
                    self.lower.lower_outside(pair);
                    if is_comment {
                        // What follows on the line is no directive either.
                        let rest = &self.lower.text[self.position..];
                        self.position += rest.find('\n').unwrap_or(rest.len());
                    }
                }
            }
        }
    }
}

/// Turns pest's pairs into the tree, one function for each rule.
struct Lower<'t> {
    text: &'t str,
    file: u16,
    /// Where the pairs' own offsets start.
    base: usize,
    faults: Vec<Diagnostic>,
    /// Faults found so far, those that have been taken or left out among them.
    count: usize,
    /// Words that begin directives.
    keywords: &'static [&'static str],
    /// The variables among the values that are being read.
    references: Vec<Reference>,
}

impl<'t> Lower<'t> {
    fn new(text: &'t str, file: u16) -> Self {
        Self { text, file, base: 0, faults: Vec::new(), count: 0, keywords: &[], references: Vec::new() }
    }

    /// The variables that have been read since this was last asked, as those of `of`.
    fn take_references(&mut self, of: Holder) -> impl Iterator<Item = Reference> {
        std::mem::take(&mut self.references).into_iter().map(move |r| Reference { of, ..r })
    }
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        self.range(span.start(), span.end())
    }

    /// The place `start..end`, relative to `base`.
    fn range(&self, start: usize, end: usize) -> Span {
        Span { file: self.file, start: (self.base + start) as u32, end: (self.base + end) as u32 }
    }

    fn fault(
        &mut self,
        code: &'static str,
        message: impl Into<String>,
        span: Span,
        label: impl Into<String>,
        help: Option<String>,
    ) {
        self.add(Diagnostic::error(code, message).at(span, label).maybe_help(help));
    }

    /// Keeps a fault, unless there are too many: a text that is no scene must not take many times its own size.
    fn add(&mut self, fault: Diagnostic) {
        self.count += 1;
        if self.count <= MAX_ERRORS {
            self.faults.push(fault);
        }
    }

    fn lower_directive(&mut self, pair: Pair<Rule>) -> Directive {
        let span = self.span(&pair);
        let mut directive = Directive::new(Spanned::new(String::new(), span));
        let mut surplus = false;
        // The grammar's own span may go on to the blanks after it.
        directive.span.end = directive.span.start;
        for part in pair.into_inner() {
            directive.span.end = self.span(&part).end;
            // Of several arguments in a row that do not belong here, the first says it all.
            let follows_surplus = std::mem::take(&mut surplus);
            let ok = match part.as_rule() {
                Rule::keyword => {
                    directive.keyword = Spanned::new(part.as_str().to_owned(), self.span(&part));
                    true
                }
                Rule::name => match part.into_inner().next() {
                    Some(text) => self.lower_arg(text, &mut directive),
                    None => false,
                },
                Rule::parameter => self.lower_parameter(part, &mut directive),
                Rule::stray => {
                    let at = self.span(&part);
                    let fresh_line = self.text[..at.start as usize].trim_end_matches([' ', '\t']).ends_with('\n');
                    if fresh_line && part.as_str() != "]" {
                        // A misspelt directive: what follows belongs to it.
                        self.lower_unknown(part.as_str(), at);
                        directive.span.end = directive.params.last().map_or(directive.keyword.span.end, |p| p.span.end);
                        break;
                    }
                    surplus = true;
                    if !follows_surplus {
                        self.lower_stray(part.as_str(), at);
                    }
                    false
                }
                Rule::number | Rule::variable | Rule::boolean | Rule::list | Rule::string if !directive.params.is_empty() => {
                    surplus = true;
                    if !follows_surplus {
                        self.lower_surplus(part, &directive);
                    }
                    false
                }
                _ => self.lower_arg(part, &mut directive),
            };
            directive.faulty |= !ok;
        }
        directive
    }

    /// What stands before the first directive.
    fn lower_outside(&mut self, pair: Pair<Rule>) {
        let span = self.span(&pair);
        match pair.as_rule() {
            Rule::stray if pair.as_str() != "]" => self.lower_unknown(pair.as_str(), span),
            Rule::unclosed_string | Rule::unclosed_list => {
                self.lower_values(pair);
            }
            _ => self.fault("stray", "expected a directive", span, "this belongs to none", None),
        }
    }

    /// A word where a directive should stand.
    fn lower_unknown(&mut self, word: &str, span: Span) {
        let near = did_you_mean(word, self.keywords.iter().copied());
        let elsewhere = foreign::mark(word).or_else(|| foreign::directive(word).map(str::to_owned));
        let help = match (near, elsewhere) {
            (Some(near), _) if near.eq_ignore_ascii_case(word) => format!("did you mean `{near}`?"),
            (_, Some(help)) => help,
            (Some(near), None) => format!("did you mean `{near}`?"),
            (None, None) => "directives start with a capital letter, text stands in quotes, comments start with `#`".to_owned(),
        };
        self.fault("unknown-directive", format!("unknown directive `{}`", shorten(word)), span, "", Some(help));
    }

    /// An argument without a name. False if it was at fault.
    fn lower_arg(&mut self, pair: Pair<Rule>, directive: &mut Directive) -> bool {
        let span = self.span(&pair);
        match self.lower_values(pair) {
            Some(values) => {
                directive.references.extend(self.take_references(Holder::Arg(directive.args.len())));
                directive.args.push(Arg { values, span });
                true
            }
            None => false,
        }
    }

    /// An argument without a name after a parameter, where there can only be another parameter.
    fn lower_surplus(&mut self, pair: Pair<Rule>, directive: &Directive) {
        let before = directive.params.last().map_or("", |p| p.name.value.as_str());
        let help = match pair.as_rule() {
            Rule::number if before == "xresolution" => format!("write the height too: \"integer yresolution\" {}", pair.as_str()),
            Rule::string => "a parameter is written \"type name\" and its value, such as \"float radius\" 1".to_owned(),
            _ => format!("several values of `{before}` stand in brackets, such as [1 2 3]"),
        };
        let text = shorten(pair.as_str());
        let span = self.span(&pair);
        self.fault("stray", format!("expected a parameter, found `{text}`"), span, "", Some(help));
    }

    /// `"type name" values`. False if it was at fault.
    fn lower_parameter(&mut self, pair: Pair<Rule>, directive: &mut Directive) -> bool {
        let (mut ty, mut name, mut values) = (None, None, None);
        let mut declaration = self.span(&pair);
        for part in pair.into_inner() {
            let span = self.span(&part);
            match part.as_rule() {
                Rule::declaration => {
                    declaration = span;
                    for word in part.into_inner() {
                        let spanned = Spanned::new(word.as_str().to_owned(), self.span(&word));
                        match word.as_rule() {
                            Rule::type_word => ty = Some(spanned),
                            _ => name = Some(spanned),
                        }
                    }
                }
                _ => match self.lower_values(part) {
                    Some(v) => values = Some(Spanned::new(v, span)),
                    None => return false,
                },
            }
        }
        let (Some(word), Some(name)) = (ty, name) else { return false };
        let Some(ty) = ParamType::from_word(&word.value) else {
            let meant = foreign::type_word(&word.value);
            let help = match meant.or_else(|| did_you_mean(&word.value, ParamType::ALL.map(ParamType::word))) {
                Some("rgb") if meant.is_some() => format!("a colour is written \"rgb {}\"", name.value),
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the types are {}", ParamType::ALL.map(ParamType::word).join(", ")),
            };
            self.fault("unknown-type", format!("unknown type `{}`", shorten(&word.value)), word.span, "", Some(help));
            return false;
        };
        let Some(values) = values else {
            let message = format!("parameter `{}` has no value", name.value);
            let help = format!("expected {} after it", example(ty));
            self.fault("missing-value", message, declaration, "no value follows", Some(help));
            return false;
        };
        let (values, span) = (quoted_bools(ty, values.value), values.span);
        directive.references.extend(self.take_references(Holder::Param(directive.params.len())));
        directive.params.push(Param { ty: Spanned::new(ty, word.span), name, values, span });
        true
    }
}

/// pbrt also writes `"true"` and `"false"`.
fn quoted_bools(ty: ParamType, values: Values) -> Values {
    let Values::Strings(strings) = &values else { return values };
    if ty != ParamType::Bool {
        return values;
    }
    let bools = strings.iter().map(|s| match s.value.as_str() {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    });
    match bools.collect() {
        Some(bools) => Values::Bools(bools),
        None => values,
    }
}

/// A value of a type, for help.
fn example(ty: ParamType) -> &'static str {
    match ty {
        ParamType::Float => "a number",
        ParamType::Integer => "an integer",
        ParamType::Bool => "`true` or `false`",
        ParamType::String | ParamType::Texture => "a text in quotes",
        ParamType::Point2 | ParamType::Vector2 => "two numbers in brackets",
        ParamType::Point3 | ParamType::Vector3 | ParamType::Normal | ParamType::Rgb => "three numbers in brackets",
        ParamType::Spectrum => "a name or numbers in brackets",
        ParamType::Blackbody | ParamType::Tolman => "a temperature in kelvin",
    }
}
