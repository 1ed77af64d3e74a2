//! What a scene's text says, word for word: directives with their arguments, nothing resolved.
//!
//! Every part keeps its place, and the text between the places (comments, blank lines) stays in the source map, so that a
//! formatter can put them back.

use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::value::{Param, Values};

/// One directive: `Keyword "name" 1 2 3 "type name" values`.
#[derive(Clone, Debug, PartialEq)]
pub struct Directive {
    /// The word that it starts with, known or not.
    pub keyword: Spanned<String>,
    /// What stands between the keyword and the first parameter.
    pub args: Vec<Arg>,
    /// The parameters.
    pub params: Vec<Param>,
    /// The values that are variables.
    pub references: Vec<Reference>,
    /// From the keyword to the last value.
    pub span: Span,
    /// Whether parts of it are missing here, because they were at fault and have been reported.
    pub faulty: bool,
}

impl Directive {
    /// A word without anything behind it.
    pub fn new(keyword: Spanned<String>) -> Self {
        let span = keyword.span;
        Self { keyword, args: Vec::new(), params: Vec::new(), references: Vec::new(), span, faulty: false }
    }
}

/// An argument without a name: a text, a number, or a bracketed list.
#[derive(Clone, Debug, PartialEq)]
pub struct Arg {
    /// Its values.
    pub values: Values,
    /// Its place, quotes or brackets included.
    pub span: Span,
}

/// A value that is the number of a variable: `$name` or `-$name`. Among the values stands 0 in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Whose value it is.
    pub of: Holder,
    /// Which one of its numbers, counted from 0.
    pub index: usize,
    /// The variable's name; its place is that of the sign, `$` and the name.
    pub name: Spanned<String>,
    /// Whether the number is to be taken with the other sign.
    pub negative: bool,
}

/// The part of a directive that values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// The argument of this number.
    Arg(usize),
    /// The parameter of this number.
    Param(usize),
}
