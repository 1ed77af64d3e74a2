//! Scenes that stand in documents.

use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;

/// The blocks of a document that are marked with `mark`.
pub fn blocks<'t>(text: &'t str, mark: &str) -> Vec<&'t str> {
    let fence = format!("```{mark}\n");
    text.split(&*fence).skip(1).map(|rest| rest.split("```").next().unwrap_or(rest)).collect()
}

/// The scenes in a document, or in a part of one.
pub fn examples(text: &str) -> Vec<&str> {
    blocks(text, "bhs")
}

/// Builds every scene of the document `path`, which is `text`.
///
/// # Panics
/// If there are errors or warnings.
pub fn build_all(path: &str, text: &str) {
    for example in examples(text) {
        let built = lang::load_text(path, example, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
        let built = built.unwrap_or_else(|found| panic!("{found:?}\n{example}"));
        assert!(built.warnings.is_empty(), "{:?}\n{example}", built.warnings);
    }
}
