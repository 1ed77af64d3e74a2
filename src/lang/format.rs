//! The text of a scene, printed neatly: the second consumer of the parser.
//!
//! One directive a line as long as it fits, what is between `Begin` and `End` indented, lists filled up to the width, numbers of
//! points together. Words, numbers and comments stay as they are; of several blank lines one is left. Formatting what has been
//! formatted changes nothing.

use crate::lang::ast::Directive;
use crate::lang::parse::Directives;
use crate::lang::resolve::directives::KEYWORDS;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::value::Param;

/// Columns that a line fills, unless a single word is longer.
const WIDTH: usize = 100;

/// Columns of one level of indentation.
const INDENT: usize = 4;

/// Levels of indentation that are drawn; deeper ones look like this one.
const DEEPEST: usize = 10;

/// The text of a scene, which is file number `file`, printed neatly.
///
/// # Errors
/// What is wrong with its syntax. Directives and plugins may be unknown.
pub fn format(text: &str, file: u16) -> Result<String, Vec<Diagnostic>> {
    let mut reader = Directives::new(text, file).suggesting(KEYWORDS);
    let directives: Vec<Directive> = reader.by_ref().collect();
    let found = reader.into_faults();
    if !found.is_empty() {
        return Err(found);
    }
    let tokens = tokens(text);
    let mut printer = Printer { text, tokens: &tokens, next: 0, out: String::new(), line: String::new(), depth: 0 };
    for (i, directive) in directives.iter().enumerate() {
        printer.comments_before(directive.keyword.span.start as usize);
        // What belongs to a directive ends with the last token before the next one that is no comment.
        let end = directives.get(i + 1).map_or(text.len(), |d| d.keyword.span.start as usize);
        printer.directive(directive, end);
    }
    printer.comments_before(usize::MAX);
    printer.flush();
    Ok(printer.out)
}

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Word,
    Text,
    Open,
    Close,
    Comment,
}

/// A piece of a scene that is without fault.
#[derive(Clone, Copy, Debug)]
struct Token<'t> {
    kind: Kind,
    text: &'t str,
    start: usize,
    /// Whether it is the first one on its line.
    first: bool,
    /// Whether a blank line stands before it.
    after_blank_line: bool,
}

/// Takes a text apart that the parser has found to be without fault.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let bytes = text.as_bytes();
    let is_blank = |b: &u8| matches!(b, b' ' | b'\t'..=b'\r');
    let mut tokens = Vec::new();
    let (mut at, mut line_ends) = (0, 1);
    while at < bytes.len() {
        if is_blank(&bytes[at]) {
            line_ends += usize::from(bytes[at] == b'\n');
            at += 1;
            continue;
        }
        let rest = &bytes[at..];
        let (kind, length) = match rest[0] {
            b'[' => (Kind::Open, 1),
            b']' => (Kind::Close, 1),
            b'#' => (Kind::Comment, rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len())),
            b'"' => (Kind::Text, quoted(rest)),
            _ => {
                let ends = |b: &u8| is_blank(b) || matches!(b, b'"' | b'[' | b']' | b'#');
                (Kind::Word, rest.iter().position(ends).unwrap_or(rest.len()))
            }
        };
        let text = text[at..at + length].trim_end();
        tokens.push(Token { kind, text, start: at, first: line_ends > 0, after_blank_line: line_ends > 1 && at > 0 });
        at += length;
        line_ends = 0;
    }
    tokens
}

/// The length of the quoted text that `bytes` start with, quotes included.
fn quoted(bytes: &[u8]) -> usize {
    let mut i = 1;
    while i < bytes.len() && bytes[i] != b'"' {
        i += if bytes[i] == b'\\' { 2 } else { 1 };
    }
    (i + 1).min(bytes.len())
}

/// Writes lines that are not too long.
struct Printer<'t> {
    text: &'t str,
    tokens: &'t [Token<'t>],
    /// The first token that has not been printed.
    next: usize,
    out: String,
    line: String,
    depth: usize,
}

impl<'t> Printer<'t> {
    fn flush(&mut self) {
        if !self.line.is_empty() {
            self.out += &self.line;
            self.out.push('\n');
            self.line.clear();
        }
    }

    /// Columns before the line of a directive.
    fn indent(&self) -> usize {
        self.depth.min(DEEPEST) * INDENT
    }

    /// Prints a piece that is not broken, after `gap` if it fits on the line.
    fn piece(&mut self, piece: &str, gap: &str, indent: usize) {
        let width = |s: &str| s.chars().count();
        if !self.line.is_empty() && width(&self.line) + width(gap) + width(piece) <= WIDTH {
            self.line += gap;
        } else {
            self.flush();
            self.line.extend(std::iter::repeat_n(' ', indent));
        }
        self.line += piece;
    }

    /// Prints a comment where it stood: behind something, or on a line of its own.
    fn comment(&mut self, token: &Token, indent: usize) {
        if token.first {
            self.flush();
            self.line.extend(std::iter::repeat_n(' ', indent));
        } else if !self.line.is_empty() {
            self.line += "  ";
        }
        self.line += token.text;
        self.flush();
    }

    fn blank_line(&mut self, token: &Token) {
        if token.after_blank_line && !self.out.is_empty() {
            self.out.push('\n');
        }
    }

    /// Prints the comments before the byte `end`, ends the line, and leaves a blank one if what follows had one before it.
    fn comments_before(&mut self, end: usize) {
        while let Some(token) = self.tokens.get(self.next).filter(|t| t.start < end) {
            if token.first {
                self.flush();
                self.blank_line(token);
            }
            self.comment(token, self.indent());
            self.next += 1;
        }
        self.flush();
        if let Some(token) = self.tokens.get(self.next) {
            self.blank_line(token);
        }
    }

    /// Prints a directive whose tokens stand before the byte `end`.
    fn directive(&mut self, directive: &Directive, end: usize) {
        let word = directive.keyword.value.as_str();
        if word.ends_with("End") {
            self.depth = self.depth.saturating_sub(1);
        }
        let all = &self.tokens[self.next..];
        let before_end = all.iter().take_while(|t| t.start < end).count();
        let own = all[..before_end].iter().rposition(|t| t.kind != Kind::Comment).map_or(0, |last| last + 1);
        let own = &all[..own];
        self.next += own.len();

        // The keyword and its arguments, then one segment for each parameter.
        let starts: Vec<usize> = directive.params.iter().map(|p| p.ty.span.start as usize).collect();
        let declares = |t: &Token| {
            t.kind == Kind::Text
                && starts.get(starts.partition_point(|s| *s <= t.start)).is_some_and(|s| *s < t.start + t.text.len())
        };
        let mut at = own.iter().position(declares).unwrap_or(own.len());
        self.segment(&own[..at], None, group_of_args(word));
        for param in &directive.params {
            let length = own[at + 1..].iter().position(declares).map_or(own.len() - at, |n| n + 1);
            self.segment(&own[at..at + length], Some(param), group_of_param(param));
            at += length;
        }
        if word.ends_with("Begin") && word != "WorldBegin" {
            self.depth += 1;
        }
    }

    /// Prints a part of a directive: in one piece if it fits on a line, else broken between its values. Values in groups of
    /// `group` stand together.
    fn segment(&mut self, tokens: &[Token], param: Option<&Param>, group: usize) {
        // Comments behind the last value belong to what follows.
        let values = tokens.iter().rposition(|t| t.kind != Kind::Comment).map_or(0, |last| last + 1);
        let (tokens, comments) = tokens.split_at(values);
        self.values(tokens, param, group);
        for comment in comments {
            self.comment(comment, self.indent() + INDENT);
        }
    }

    fn values(&mut self, tokens: &[Token], param: Option<&Param>, group: usize) {
        let first = match param {
            Some(p) => {
                let source = |s: bhs_core::diagnostics::Span| &self.text[s.start as usize..s.end as usize];
                format!("\"{} {}\"", source(p.ty.span), source(p.name.span))
            }
            None => tokens.first().map_or_else(String::new, |t| t.text.to_owned()),
        };
        let indent = self.indent() + if param.is_some() { INDENT } else { 0 };
        let rest = tokens.get(1..).unwrap_or(&[]);
        let commented = rest.iter().any(|t| t.kind == Kind::Comment);
        let pieces = pieces(rest, if commented { 0 } else { group });
        let flat: usize = pieces.iter().map(|p| p.gap.len() + p.text.chars().count()).sum();
        if !commented && indent + first.chars().count() + flat <= WIDTH {
            let whole = pieces.iter().fold(first, |all, p| all + p.gap + &p.text);
            return self.piece(&whole, " ", indent);
        }
        self.flush();
        self.piece(&first, " ", indent);
        let indent = indent + INDENT;
        for piece in pieces {
            match piece.comment {
                Some(token) => self.comment(token, indent),
                None => self.piece(&piece.text, piece.gap, indent),
            }
        }
    }
}

/// Values that stay together on a line, or a comment.
struct Piece<'t> {
    text: String,
    gap: &'static str,
    comment: Option<&'t Token<'t>>,
}

/// The values of a segment, with brackets attached to the first and the last one.
fn pieces<'t>(tokens: &'t [Token<'t>], group: usize) -> Vec<Piece<'t>> {
    let is_value = |t: &Token| matches!(t.kind, Kind::Word | Kind::Text);
    let count = tokens.iter().filter(|t| is_value(t)).count();
    // What does not come out even is not what it seems to be.
    let group = if group > 0 && count > group && count % group == 0 { group } else { 0 };
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut values, mut opened) = (0, false);
    for token in tokens {
        let gap = if group > 0 && values > 0 && values % group == 0 { "  " } else { " " };
        match token.kind {
            Kind::Comment => pieces.push(Piece { text: String::new(), gap, comment: Some(token) }),
            Kind::Close => match pieces.last_mut().filter(|p| p.comment.is_none()) {
                Some(last) => last.text.push(']'),
                None => pieces.push(Piece { text: "]".into(), gap, comment: None }),
            },
            Kind::Open => pieces.push(Piece { text: "[".into(), gap: " ", comment: None }),
            Kind::Word | Kind::Text => {
                let continues = opened || (group > 0 && values % group > 0);
                match pieces.last_mut().filter(|p| continues && p.comment.is_none()) {
                    Some(last) => {
                        last.text += if opened { "" } else { " " };
                        last.text += token.text;
                    }
                    None => pieces.push(Piece { text: token.text.to_owned(), gap, comment: None }),
                }
                values += 1;
            }
        }
        opened = token.kind == Kind::Open;
    }
    pieces
}

/// How many numbers after a keyword belong together.
fn group_of_args(keyword: &str) -> usize {
    match keyword {
        "LookAt" => 3,
        "Transform" | "ConcatTransform" => 4,
        _ => 0,
    }
}

/// How many values of a parameter belong together.
fn group_of_param(param: &Param) -> usize {
    use bhs_core::value::{ParamType, Values};
    let is_numbers = matches!(param.values, Values::Numbers { .. });
    match param.ty.value {
        ParamType::Point3 | ParamType::Vector3 | ParamType::Normal | ParamType::Rgb => 3,
        ParamType::Point2 | ParamType::Vector2 => 2,
        ParamType::Spectrum if is_numbers => 2,
        ParamType::Integer if param.name.value == "indices" => 3,
        _ => 0,
    }
}
