//! How much is said of a scene with very many errors.

use bhs_core::diagnostics::{Diagnostic, Severity, did_you_mean};
use std::cell::Cell;

/// Counts the errors of a list that only grows, each once.
#[derive(Debug, Default)]
pub(super) struct ErrorCount {
    seen: usize,
    errors: usize,
}

impl ErrorCount {
    /// The errors in `found`, which has everything that it had before.
    pub fn count(&mut self, found: &[Diagnostic]) -> usize {
        let new = found.get(self.seen..).unwrap_or_default();
        self.errors += new.iter().filter(|d| d.severity == Severity::Error).count();
        self.seen = found.len();
        self.errors
    }
}

/// Looks for names that were probably meant: at most so often that it takes about a second in all.
#[derive(Debug)]
pub(super) struct Suggestions {
    /// Names that may still be compared.
    left: Cell<usize>,
}

impl Default for Suggestions {
    fn default() -> Self {
        Self { left: Cell::new(5_000_000) }
    }
}

impl Suggestions {
    /// The one of `names` that `unknown` was probably meant to be.
    pub fn near<'n>(&self, unknown: &str, names: impl ExactSizeIterator<Item = &'n str>) -> Option<&'n str> {
        self.left.set(self.left.get().checked_sub(names.len())?);
        did_you_mean(unknown, names)
    }
}
