//! Text to directives. Knows the grammar, and neither directives nor plugins.
//!
//! Reading never stops: what is at fault is reported where it opens, left out, and the next directive is read.

use crate::lang::ast::{Arg, Directive};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use bhs_core::value::{Param, ParamType, Values};
use grammar::{Grammar, Rule};
use pest::Parser;
use pest::iterators::Pair;

/// The parser that pest makes from the grammar.
mod grammar {
    #![allow(missing_docs)] // generated
    #[derive(pest_derive::Parser)]
    #[grammar = "../grammar/bhs.pest"]
    pub struct Grammar;
}

/// Faults that are reported of one list; the others would say the same.
const MAX_FAULTS_IN_LIST: usize = 3;

/// Reads all of `text`, which is file number `file`.
pub fn parse(text: &str, file: u16) -> (Vec<Directive>, Vec<Diagnostic>) {
    let mut directives = Directives::new(text, file);
    let all = directives.by_ref().collect();
    (all, directives.into_faults())
}

/// Reads `text` directive by directive, so that memory is needed for one at a time.
pub struct Directives<'t> {
    lower: Lower<'t>,
    /// First byte that has not been read.
    position: usize,
}

impl<'t> Directives<'t> {
    /// Starts at the beginning of `text`, which is file number `file`.
    pub fn new(text: &'t str, file: u16) -> Self {
        Self { lower: Lower { text, file, base: 0, faults: Vec::new() }, position: 0 }
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
        loop {
            let rest = self.lower.text.get(self.position..)?;
            // The grammar has a rule for everything, so there is no error of pest's own; if there were, reading would end.
            let pair = Grammar::parse(Rule::statement, rest).ok()?.next()?;
            self.lower.base = self.position;
            self.position += pair.as_span().end();
            match pair.as_rule() {
                Rule::EOI => return None,
                Rule::directive => return Some(self.lower.lower_directive(pair)),
                _ => self.lower.lower_outside(pair),
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
}

impl Lower<'_> {
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        self.range(span.start(), span.end())
    }

    /// The place `start..end`, relative to `base`.
    fn range(&self, start: usize, end: usize) -> Span {
        Span { file: self.file, start: (self.base + start) as u32, end: (self.base + end) as u32 }
    }

    fn fault(&mut self, code: &'static str, message: impl Into<String>, span: Span, label: impl Into<String>, help: Option<String>) {
        self.faults.push(Diagnostic::error(code, message).at(span, label).maybe_help(help));
    }

    fn lower_directive(&mut self, pair: Pair<Rule>) -> Directive {
        let span = self.span(&pair);
        let mut directive =
            Directive { keyword: Spanned::new(String::new(), span), args: Vec::new(), params: Vec::new(), span, faulty: false };
        let mut surplus = false;
        for part in pair.into_inner() {
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
                Rule::number | Rule::boolean | Rule::list | Rule::string if !directive.params.is_empty() => {
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
        let help = match did_you_mean(word, super::directives::keywords()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "directives start with a capital letter, text stands in quotes, comments start with `#`".to_owned(),
        };
        self.fault("unknown-directive", format!("unknown directive `{}`", shorten(word)), span, "", Some(help));
    }

    /// An argument without a name. False if it was at fault.
    fn lower_arg(&mut self, pair: Pair<Rule>, directive: &mut Directive) -> bool {
        let span = self.span(&pair);
        match self.lower_values(pair) {
            Some(values) => {
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
            let help = match did_you_mean(&word.value, ParamType::ALL.map(ParamType::word)) {
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
        directive.params.push(Param { ty: Spanned::new(ty, word.span), name, values, span });
        true
    }

    /// A value or a list of values.
    fn lower_values(&mut self, pair: Pair<Rule>) -> Option<Values> {
        let span = self.span(&pair);
        match pair.as_rule() {
            Rule::number => {
                let mut numbers = Numbers::default();
                self.lower_number(pair.as_str(), span, &mut numbers);
                (numbers.faults == 0).then_some(Values::Numbers { values: numbers.values, whole: numbers.whole })
            }
            Rule::boolean => Some(Values::Bools(vec![pair.as_str() == "true"])),
            Rule::string => Some(Values::Strings(vec![self.lower_string(pair)?])),
            Rule::list => self.lower_list(pair),
            Rule::unclosed_list => {
                let open = Span { end: span.start + 1, ..span };
                self.fault("unclosed-list", "this list is never closed", open, "opened here", Some("add a `]`".into()));
                None
            }
            Rule::unclosed_string => {
                let open = Span { end: span.start + 1, ..span };
                let help = "add a `\"`; text ends on the line it starts on".to_owned();
                self.fault("unclosed-string", "this text is never closed", open, "opened here", Some(help));
                None
            }
            _ => {
                self.lower_stray(pair.as_str(), span);
                None
            }
        }
    }

    /// A quoted text, with its escapes replaced; `None` if one of them is unknown.
    fn lower_string(&mut self, pair: Pair<Rule>) -> Option<Spanned<String>> {
        let span = self.span(&pair);
        let raw = pair.into_inner().next().map_or("", |chars| chars.as_str());
        if !raw.contains('\\') {
            return Some(Spanned::new(raw.to_owned(), span));
        }
        let mut known = true;
        let mut text = String::with_capacity(raw.len());
        let mut chars = raw.char_indices();
        while let Some((_, c)) = chars.next() {
            if c != '\\' {
                text.push(c);
                continue;
            }
            match chars.next() {
                Some((_, 'n')) => text.push('\n'),
                Some((_, 't')) => text.push('\t'),
                Some((_, 'r')) => text.push('\r'),
                Some((_, 'b')) => text.push('\u{8}'),
                Some((_, 'f')) => text.push('\u{c}'),
                Some((_, c @ ('\\' | '"' | '\''))) => text.push(c),
                Some((i, other)) => {
                    known = false;
                    // `i` counts from behind the opening quote.
                    let at = Span { start: span.start + i as u32, end: span.start + (i + 1 + other.len_utf8()) as u32, ..span };
                    let help = "a backslash itself is written `\\\\`; paths may use `/`".to_owned();
                    self.fault("unknown-escape", format!("unknown escape `\\{other}`"), at, "", Some(help));
                }
                None => {}
            }
        }
        known.then_some(Spanned::new(text, span))
    }

    /// `[ ... ]`.
    fn lower_list(&mut self, pair: Pair<Rule>) -> Option<Values> {
        let list = self.span(&pair);
        let mut numbers = Numbers::default();
        let mut strings = Vec::new();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::text => self.split(part.as_str(), part.as_span().start(), &mut numbers),
                _ => match self.lower_string(part) {
                    Some(text) => strings.push(text),
                    None => numbers.faults += 1,
                },
            }
        }
        if numbers.faults > 0 {
            return None;
        }
        let kinds = [!numbers.values.is_empty(), !strings.is_empty(), !numbers.bools.is_empty()];
        if kinds.into_iter().filter(|k| *k).count() > 1 {
            // Most often the `]` is missing, and the next parameter was taken for text.
            let open = Span { end: list.start + 1, ..list };
            let swallowed = strings.iter().find(|s| s.value.split(' ').next().and_then(ParamType::from_word).is_some());
            let mut d = Diagnostic::error("mixed-list", "a list holds values of one kind").at(open, "opened here");
            d = match swallowed {
                Some(s) => d.and(s.span, "is a `]` missing before this?"),
                None => d.help("put numbers, texts and `true`/`false` into lists of their own"),
            };
            self.faults.push(d);
            return None;
        }
        if !strings.is_empty() {
            return Some(Values::Strings(strings));
        }
        if !numbers.bools.is_empty() {
            return Some(Values::Bools(numbers.bools));
        }
        numbers.values.shrink_to_fit();
        Some(Values::Numbers { values: numbers.values, whole: numbers.whole })
    }

    /// Splits the unquoted part of a list, which starts at `start`.
    fn split(&mut self, text: &str, start: usize, into: &mut Numbers) {
        let bytes = text.as_bytes();
        let is_blank = |b: &u8| matches!(b, b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c);
        let mut i = 0;
        while i < bytes.len() {
            if is_blank(&bytes[i]) {
                i += 1;
                continue;
            }
            let end = bytes[i..].iter().position(is_blank).map_or(bytes.len(), |n| i + n);
            let word = &text[i..end];
            let at = self.range(start + i, start + end);
            match word {
                "true" => into.bools.push(true),
                "false" => into.bools.push(false),
                _ => self.lower_number(word, at, into),
            }
            i = end;
        }
    }

    fn lower_number(&mut self, word: &str, at: Span, into: &mut Numbers) {
        match read_number(word) {
            Some((value, whole)) if value.is_finite() => {
                into.whole &= whole;
                into.values.push(value);
            }
            _ => {
                into.faults += 1;
                if into.faults <= MAX_FAULTS_IN_LIST {
                    self.lower_stray(word, at);
                }
            }
        }
    }

    /// A word that is no value.
    fn lower_stray(&mut self, word: &str, at: Span) {
        let unsigned = word.trim_start_matches(['+', '-']).to_lowercase();
        let shown = shorten(word);
        if matches!(unsigned.as_str(), "nan" | "inf" | "infinity") {
            let help = "numbers are finite; write a large one for something far away".to_owned();
            return self.fault("not-finite", format!("expected a number, found `{shown}`"), at, "not finite", Some(help));
        }
        if read_number(word).is_some() {
            let help = "the largest number is about 1.8e308".to_owned();
            return self.fault("not-finite", format!("the number `{shown}` is too large"), at, "not finite", Some(help));
        }
        if word == "]" {
            return self.fault("stray", "this `]` closes nothing", at, "", Some("remove it, or open the list with `[`".into()));
        }
        let (message, help) = match word.trim_end_matches(',') {
            bare if bare != word && read_number(bare).is_some() => {
                (format!("expected a number, found `{shown}`"), "separate numbers by blanks, without commas".to_owned())
            }
            _ if word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                (format!("`{shown}` is not a number"), "numbers look like 1, -0.5 or 2e-3".to_owned())
            }
            _ if word.contains(',') => (format!("expected a value, found `{shown}`"), "values are separated by blanks".to_owned()),
            _ if word.starts_with(|c: char| c.is_ascii_uppercase()) => {
                (format!("expected a value, found `{shown}`"), "is a `]` missing before it?".to_owned())
            }
            _ => (format!("expected a value, found `{shown}`"), format!("text stands in quotes: \"{shown}\"")),
        };
        self.fault("stray", message, at, "", Some(help));
    }
}

/// What a list holds besides text.
struct Numbers {
    values: Vec<f64>,
    whole: bool,
    bools: Vec<bool>,
    faults: usize,
}

impl Default for Numbers {
    fn default() -> Self {
        Self { values: Vec::new(), whole: true, bools: Vec::new(), faults: 0 }
    }
}

/// The number that `word` is, which may be too large to be finite, and whether it is written as an integer.
fn read_number(word: &str) -> Option<(f64, bool)> {
    // Rust would read `inf` and `nan` too; of these characters it reads exactly the grammar's numbers.
    let mut whole = true;
    for b in word.bytes() {
        match b {
            b'0'..=b'9' | b'+' | b'-' => {}
            b'.' | b'e' | b'E' => whole = false,
            _ => return None,
        }
    }
    Some((word.parse().ok()?, whole))
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
        ParamType::Blackbody => "a temperature in kelvin",
    }
}

/// `text`, cut if it is long.
pub(crate) fn shorten(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((cut, _)) => format!("{}...", &text[..cut]),
        None => text.to_owned(),
    }
}
