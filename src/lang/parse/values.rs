//! Values: numbers, texts, and lists of them, which are split by hand.

use super::Lower;
use super::grammar::Rule;
use crate::lang::ast::{Holder, Reference};
use crate::lang::foreign;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, shorten};
use bhs_core::value::{ParamType, Values};
use pest::iterators::Pair;

/// Faults that are reported of one list; the others would say the same.
const MAX_FAULTS_IN_LIST: usize = 3;

impl Lower<'_> {
    /// A value or a list of values.
    pub(super) fn lower_values(&mut self, pair: Pair<Rule>) -> Option<Values> {
        let span = self.span(&pair);
        self.references.clear();
        match pair.as_rule() {
            Rule::number | Rule::variable => {
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
            self.add(d);
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
        if let Some(reference) = reference(word, at, into.values.len()) {
            self.references.push(reference);
            into.values.push(0.0);
            return;
        }
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
    pub(super) fn lower_stray(&mut self, word: &str, at: Span) {
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
        let (message, help) = match word {
            _ if let Some(help) = foreign::mark(word) => (format!("expected a value, found `{shown}`"), help),
            _ if word.contains(',') && word.split_terminator(',').all(|w| read_number(w).is_some()) => {
                (format!("expected a number, found `{shown}`"), "separate numbers by blanks, without commas".to_owned())
            }
            _ if word.starts_with(QUOTES) => {
                let bare = shorten(word.trim_matches(QUOTES));
                let help = format!("text stands in straight double quotes: \"{bare}\"");
                (format!("expected a value, found `{shown}`"), help)
            }
            _ if word.trim_start_matches(['+', '-']).starts_with('$') => {
                let help = "such as $radius or -$radius; names have letters, digits and `_`, and begin with none of the digits";
                (format!("`{shown}` does not name a variable"), help.to_owned())
            }
            _ if word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                (format!("`{shown}` is not a number"), "numbers look like 1, -0.5 or 2e-3".to_owned())
            }
            _ if word.contains(',') => {
                (format!("expected a value, found `{shown}`"), "values are separated by blanks".to_owned())
            }
            _ if word.starts_with(|c: char| c.is_ascii_uppercase()) => {
                (format!("expected a value, found `{shown}`"), "is a `]` missing before it?".to_owned())
            }
            _ => {
                let help = format!("text stands in quotes: \"{shown}\"; a parameter is written \"type name\" and its value");
                (format!("expected a value, found `{shown}`"), help)
            }
        };
        self.fault("stray", message, at, "", Some(help));
    }
}

/// Marks that stand around text elsewhere.
const QUOTES: [char; 7] = ['\'', '`', '\u{2018}', '\u{2019}', '\u{201c}', '\u{201d}', '\u{201e}'];

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
pub(crate) fn read_number(word: &str) -> Option<(f64, bool)> {
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

/// The variable that `word`, at `at`, is: number `index` of its list. Whose list it is, is not known here.
pub(super) fn reference(word: &str, at: Span, index: usize) -> Option<Reference> {
    let unsigned = word.strip_prefix(['+', '-']).unwrap_or(word);
    let name = unsigned.strip_prefix('$').filter(|name| is_variable_name(name))?;
    let name = Spanned::new(name.to_owned(), at);
    Some(Reference { of: Holder::Arg(0), index, name, negative: word.starts_with('-') })
}

/// Whether a variable may be called so.
pub(crate) fn is_variable_name(name: &str) -> bool {
    let inner = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.starts_with(|c: char| inner(c) && !c.is_ascii_digit()) && name.chars().all(inner)
}
