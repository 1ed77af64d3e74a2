//! Which texts are pbrt-v4's, and what is read at the end of a scene.

use crate::files;
use crate::lang::gltf_scene;
use crate::lang::source::SourceMap;
use bhs_core::diagnostics::{Diagnostic, Span};
use std::path::{Path, PathBuf};

impl SourceMap {
    /// Whether the scene that is opened next is read with pbrt-v4's meaning even if its name does not end in `.pbrt`, and the files that are
    /// read at its end.
    #[must_use]
    pub fn reading(self, pbrt: bool, additions: Vec<PathBuf>) -> Self {
        Self { pbrt, additions, ..self }
    }

    /// The files that are read at the end of the scene.
    pub fn additions(&self) -> &[PathBuf] {
        &self.additions
    }

    /// Opens a file that is read at the end of the scene, whose first file is number `scene`.
    ///
    /// # Errors
    /// That it cannot be read.
    pub fn open_addition(&mut self, path: &Path, scene: u16) -> Result<u16, Box<Diagnostic>> {
        let bytes = self.content(path, path, None).map_err(|why| {
            let message = format!("cannot read `{}`: {why}", path.display());
            Box::new(Diagnostic::error("cannot-read", message).maybe_help(files::pipe_help(path).map(str::to_owned)))
        })?;
        let file = self.push_file(path, bytes, None)?;
        let is_ours = path.extension().is_some_and(|e| e == "bhs");
        let is_pbrt = is_pbrt_file(path) || (!is_ours && self.get(scene).is_some_and(|s| s.is_pbrt));
        self.mark(file, is_pbrt);
        Ok(file)
    }

    /// Adds the scene of a glTF file.
    pub(super) fn push_model(&mut self, path: &Path, bytes: &[u8]) -> Result<u16, String> {
        let made = gltf_scene::scene(&path.to_string_lossy(), bytes)?;
        let file = self.push_file(path, made.text.into_bytes(), None).map_err(|fault| fault.message)?;
        if let Some(source) = self.sources.get_mut(usize::from(file)) {
            source.is_model = true;
        }
        let note = |note: String| Diagnostic::warning("model", format!("`{}`: {note}", path.display()));
        self.notes.extend(made.notes.into_iter().map(note));
        Ok(file)
    }

    /// What is to be said of scenes that have been made of models.
    pub(crate) fn take_notes(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.notes)
    }

    /// Notes whether a file is read with pbrt-v4's meaning.
    pub(super) fn mark(&mut self, file: u16, is_pbrt: bool) {
        if let Some(source) = self.sources.get_mut(usize::from(file)) {
            source.is_pbrt = is_pbrt;
        }
    }

    /// Whether what the text at `span` includes is read with pbrt-v4's meaning; and the folder where its relative paths start, if that is not its
    /// own: in pbrt-v4 it is that of the scene.
    pub(super) fn meaning_within(&self, path: &Path, span: Span) -> (bool, Option<PathBuf>) {
        let outer = self.get(span.file).filter(|s| s.is_pbrt);
        let is_ours = path.extension().is_some_and(|e| e == "bhs");
        let is_pbrt = is_pbrt_file(path) || (outer.is_some() && !is_ours);
        (is_pbrt, outer.map(|s| s.folder.clone()))
    }
}

/// Whether the name of a file says that it is pbrt-v4's.
pub(super) fn is_pbrt_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pbrt"))
}
