//! Directives that are plainly right, read without the grammar: most of a large scene is made of them, and pest takes ten times
//! as long.
//!
//! What is read here is read as the grammar would read it, to the last span (a test compares the two on every scene and on a great
//! many mutations). Whatever is at fault, or only unusual, is left to the grammar: the answer is `None`.

use super::quoted_bools;
use super::values::{read_number, reference};
use crate::lang::ast::{Arg, Directive, Holder, Reference};
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::value::{Param, ParamType, Values};

/// The directive at the byte `from` of `text`, which is file number `file`; blanks and comments may stand before it.
pub(super) fn directive(text: &str, from: usize, file: u16) -> Option<Directive> {
    let mut reader = Reader { text, at: from, file, references: Vec::new() };
    reader.skip();
    let mut directive = Directive::new(reader.keyword()?);
    loop {
        directive.span.end = reader.at as u32;
        reader.skip();
        match reader.peek() {
            None => break,
            Some(b'A'..=b'Z') => {
                // The next directive begins here, if it is one.
                reader.keyword()?;
                break;
            }
            Some(b'"') => {
                let text = reader.string()?;
                match declaration(&text) {
                    Some((ty, name)) => {
                        let of = Holder::Param(directive.params.len());
                        directive.params.push(reader.parameter(ty, name, of)?);
                    }
                    // After a parameter there can only be another one.
                    None if directive.params.is_empty() => {
                        let span = text.span;
                        let values = Values::Strings(vec![Spanned::new(text.value.to_owned(), span)]);
                        directive.args.push(Arg { values, span });
                    }
                    None => return None,
                }
            }
            Some(_) if directive.params.is_empty() => {
                let (values, span) = reader.value(Holder::Arg(directive.args.len()))?;
                directive.args.push(Arg { values, span });
            }
            Some(_) => return None,
        }
    }
    directive.references = reader.references;
    Some(directive)
}

/// Type word and name of `"type name"`, if that is what a text is.
fn declaration<'t>(text: &Spanned<&'t str>) -> Option<(Spanned<&'t str>, Spanned<&'t str>)> {
    let space = [' ', '\t'];
    let inner = text.value.trim_matches(space);
    let (ty, rest) = inner.split_once(space)?;
    let name = rest.trim_start_matches(space);
    if name.contains(space) {
        return None;
    }
    // Behind the quote and the spaces before the type word.
    let start = text.span.start as usize + 1 + (text.value.len() - text.value.trim_start_matches(space).len());
    let place =
        |from: usize, length: usize| Span { start: (start + from) as u32, end: (start + from + length) as u32, ..text.span };
    let name_place = place(inner.len() - name.len(), name.len());
    Some((Spanned::new(ty, place(0, ty.len())), Spanned::new(name, name_place)))
}

fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t'..=b'\r')
}

/// Whether a word ends before this byte.
fn ends_word(b: u8) -> bool {
    is_blank(b) || matches!(b, b'"' | b'[' | b']' | b'#')
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
    file: u16,
    /// The variables that have been read.
    references: Vec<Reference>,
}

impl<'t> Reader<'t> {
    fn rest(&self) -> &'t [u8] {
        &self.text.as_bytes()[self.at..]
    }

    fn peek(&self) -> Option<u8> {
        self.rest().first().copied()
    }

    fn span(&self, start: usize) -> Span {
        Span { file: self.file, start: start as u32, end: self.at as u32 }
    }

    /// Steps over blanks and comments.
    fn skip(&mut self) {
        while let Some(b) = self.peek() {
            if is_blank(b) {
                self.at += 1;
            } else if b == b'#' {
                self.at += self.rest().iter().position(|b| *b == b'\n').unwrap_or(self.rest().len());
            } else {
                break;
            }
        }
    }

    /// The word that starts here.
    fn word(&mut self) -> &'t str {
        let start = self.at;
        self.at += self.rest().iter().position(|b| ends_word(*b)).unwrap_or(self.rest().len());
        &self.text[start..self.at]
    }

    fn keyword(&mut self) -> Option<Spanned<String>> {
        let start = self.at;
        let word = self.word();
        let plain = word.starts_with(|c: char| c.is_ascii_uppercase()) && word.bytes().all(|b| b.is_ascii_alphanumeric());
        let number = ["nan", "inf", "infinity"].iter().any(|n| word.eq_ignore_ascii_case(n));
        (plain && !number).then(|| Spanned::new(word.to_owned(), self.span(start)))
    }

    /// A quoted text without escapes; its span has the quotes.
    fn string(&mut self) -> Option<Spanned<&'t str>> {
        let start = self.at;
        let length = self.rest()[1..].iter().position(|b| *b == b'"' || *b == b'\\' || (*b < b' ' && *b != b'\t'))?;
        let end = start + 1 + length;
        if self.text.as_bytes()[end] != b'"' {
            return None;
        }
        self.at = end + 1;
        Some(Spanned::new(&self.text[start + 1..end], self.span(start)))
    }

    /// What follows a declaration: the values of `of`.
    fn parameter(&mut self, ty: Spanned<&str>, name: Spanned<&str>, of: Holder) -> Option<Param> {
        let ty = Spanned::new(ParamType::from_word(ty.value)?, ty.span);
        let name = Spanned::new(name.value.to_owned(), name.span);
        self.skip();
        let (values, span) = match self.peek()? {
            b'"' => {
                let text = self.string()?;
                if declaration(&text).is_some() {
                    return None;
                }
                (Values::Strings(vec![Spanned::new(text.value.to_owned(), text.span)]), text.span)
            }
            _ => self.value(of)?,
        };
        Some(Param { values: quoted_bools(ty.value, values), ty, name, span })
    }

    /// A list, a number, or `true` or `false`: the values of `of`.
    fn value(&mut self, of: Holder) -> Option<(Values, Span)> {
        let start = self.at;
        if self.peek()? == b'[' {
            let values = self.list(of)?;
            return Some((values, self.span(start)));
        }
        let values = match self.word() {
            "true" => Values::Bools(vec![true]),
            "false" => Values::Bools(vec![false]),
            word => {
                let (value, whole) = self.number(word, of, 0)?;
                Values::Numbers { values: vec![value], whole }
            }
        };
        Some((values, self.span(start)))
    }

    fn list(&mut self, of: Holder) -> Option<Values> {
        self.at += 1;
        self.skip();
        match self.peek()? {
            b'"' => self.strings(),
            b't' | b'f' => self.bools(),
            _ => self.numbers(of),
        }
    }

    fn strings(&mut self) -> Option<Values> {
        let mut texts = Vec::new();
        loop {
            match self.peek()? {
                b'"' => {
                    let text = self.string()?;
                    texts.push(Spanned::new(text.value.to_owned(), text.span));
                }
                b']' => break,
                _ => return None,
            }
            self.skip();
        }
        self.at += 1;
        Some(Values::Strings(texts))
    }

    fn bools(&mut self) -> Option<Values> {
        let mut bools = Vec::new();
        while self.peek()? != b']' {
            match self.word() {
                "true" => bools.push(true),
                "false" => bools.push(false),
                _ => return None,
            }
            self.skip();
        }
        self.at += 1;
        Some(Values::Bools(bools))
    }

    fn numbers(&mut self, of: Holder) -> Option<Values> {
        // Counted first: a large mesh is not to be moved as it grows. Comments make the count too large, which does no harm.
        let inside = self.rest().split(|b| matches!(b, b']' | b'[' | b'"')).next()?;
        let starts = inside.windows(2).filter(|w| is_blank(w[0]) && !is_blank(w[1])).count();
        let mut values = Vec::with_capacity(starts + 1);
        let mut all_whole = true;
        while self.peek()? != b']' {
            let word = self.word();
            let (value, whole) = self.number(word, of, values.len())?;
            all_whole &= whole;
            values.push(value);
            self.skip();
        }
        self.at += 1;
        Some(Values::Numbers { values, whole: all_whole })
    }

    /// The finite number that `word`, which has just been read, is, and whether it is written as an integer; or the variable, which is
    /// noted as number `index` of `of`.
    fn number(&mut self, word: &str, of: Holder, index: usize) -> Option<(f64, bool)> {
        if let Some(number) = read_number(word) {
            return Some(number).filter(|(value, _)| value.is_finite());
        }
        let reference = reference(word, self.span(self.at - word.len()), index)?;
        self.references.push(Reference { of, ..reference });
        Some((0.0, true))
    }
}
