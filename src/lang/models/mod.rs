//! Files of other programs that bring materials, lights or instances with their meshes.
//!
//! A `Shape` that names such a file becomes the directives that describe what is in it, which the resolver runs in its place; each mesh is then a
//! `Shape` of the same file that names its part. So all that follows knows such files as it knows any scene: what is wrong is said at the `Shape`, and
//! hashes, `bhs watch` and `--root` see every file that is read.

use crate::lang::resolve::Resolver;
use crate::lang::source::SourceMap;
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_models::beside;

mod gltf;
mod mtl;
mod obj;
mod picture;

/// A file that a `Shape` names, while directives are made of it.
pub(super) struct ModelFile<'f> {
    /// Its path as the scene writes it.
    pub path: &'f str,
    /// Where.
    pub at: Span,
    /// Begins the names of all that the scene does not name itself.
    pub prefix: String,
}

impl ModelFile<'_> {
    /// The path of a file that this one names, as the scene would write it.
    pub fn beside(&self, name: &str) -> String {
        beside(self.path, &name.replace('\\', "/"))
    }

    /// A file that this one names: beside it, or where its path says nothing to this system, by its last name beside it. `None` if it is not there.
    pub fn find(&self, name: &str, sources: &SourceMap) -> Option<String> {
        let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let mut paths = vec![self.beside(name), self.beside(last)];
        paths.dedup();
        // The first one is watched for, should it appear.
        paths.into_iter().find(|path| sources.is_there(path, self.at))
    }

    /// A warning about it.
    pub fn warning(&self, code: &'static str, message: String, label: &str) -> Diagnostic {
        Diagnostic::warning(code, message).at(self.at, label)
    }
}

/// At most so many of a list of names, each in quotes.
pub(super) fn few<'n>(names: impl ExactSizeIterator<Item = &'n str>) -> String {
    const FEW: usize = 5;
    let count = names.len();
    let shown: Vec<String> = names.take(FEW).map(|name| format!("`{}`", bhs_core::diagnostics::shorten(name))).collect();
    let rest = if count > FEW { format!(" and {} more", count - FEW) } else { String::new() };
    shown.join(", ") + &rest
}

impl Resolver<'_> {
    /// The number of a file that brings things without names of their own.
    fn model_number(&mut self) -> usize {
        self.models += 1;
        self.models
    }
}
