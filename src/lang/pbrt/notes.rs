//! What is said of a file of pbrt's: each word that means something else here, once.

use bhs_core::diagnostics::{Diagnostic, Span, shorten};
use std::collections::BTreeSet;

/// The words that have been spoken of.
#[derive(Default)]
pub(super) struct Notes {
    said: BTreeSet<String>,
    found: Vec<Diagnostic>,
}

impl Notes {
    /// Takes what has been found since this was last asked.
    pub fn take(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.found)
    }

    /// Adds an error.
    pub fn error(&mut self, error: Diagnostic) {
        self.found.push(error);
    }

    /// Warns of `what`, which names a word of the file, once.
    pub fn warn(&mut self, what: &str, span: Span, label: &str, help: &str) {
        if self.said.insert(what.to_owned()) {
            let help = Some(help.to_owned()).filter(|h| !h.is_empty());
            self.found.push(Diagnostic::warning("pbrt", what).at(span, label).maybe_help(help));
        }
    }

    /// Says that the word `word` of the kind `kind` is taken for something else.
    pub fn mapped(&mut self, kind: &str, word: &str, to: &str, span: Span, help: &str) {
        self.warn(&format!("{kind} `{}` is read as {to}", shorten(word)), span, "", help);
    }

    /// Says that `word` does nothing here.
    pub fn ignored(&mut self, word: &str, span: Span, lacks: &str) {
        self.warn(&format!("`{}` is ignored", shorten(word)), span, "", lacks);
    }
}
