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
    /// From the keyword to the last value.
    pub span: Span,
    /// Whether parts of it are missing here, because they were at fault and have been reported.
    pub faulty: bool,
}

/// An argument without a name: a text, a number, or a bracketed list.
#[derive(Clone, Debug, PartialEq)]
pub struct Arg {
    /// Its values.
    pub values: Values,
    /// Its place, quotes or brackets included.
    pub span: Span,
}
