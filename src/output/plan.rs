//! What is to be written, beside what is read: no file is both, and no two outputs are one file.

use super::OutputFile;
use crate::files::FileId;
use crate::lang::SourceMap;
use bhs_core::diagnostics::{Diagnostic, Span};
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// The finding that two outputs are one file.
pub const COINCIDE: &str = "outputs-coincide";

/// The finding that an output is read.
pub const IS_INPUT: &str = "output-is-input";

/// Where the name of an output comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedBy {
    /// The command line, which may name files outside of the folder of `--root`.
    CommandLine,
    /// The scene, here; or nobody, and it is made from the name of the scene.
    Scene(Option<Span>),
}

/// A file that is to be written, or that others write.
struct Planned {
    /// Its name as it is given.
    path: PathBuf,
    /// Who writes it, if that is not this command.
    writer: Option<String>,
}

/// All outputs of a command, and what is wrong with them.
///
/// Files are compared by what they are: links, `.` and `..`, hard links, and case where the file system ignores it, hide nothing.
pub struct Plan<'a> {
    sources: &'a SourceMap,
    /// The outputs so far.
    outputs: Vec<Planned>,
    by_id: HashMap<FileId, usize>,
    /// By the real folder, and the name in small letters.
    by_name: HashMap<(PathBuf, String), Vec<(OsString, usize)>>,
    /// Whether the file system of a folder ignores case, as far as it has been asked for.
    ignores_case: HashMap<PathBuf, bool>,
    found: Vec<Diagnostic>,
}

impl<'a> Plan<'a> {
    /// No outputs yet, of a scene that has read `sources`.
    pub fn new(sources: &'a SourceMap) -> Self {
        Self {
            sources,
            outputs: Vec::new(),
            by_id: HashMap::new(),
            by_name: HashMap::new(),
            ignores_case: HashMap::new(),
            found: Vec::new(),
        }
    }

    /// Adds a file that is to be written. `None` if it cannot be; [`finish`](Self::finish) says why. Touches nothing.
    pub fn claim(&mut self, path: &Path, by: NamedBy) -> Option<OutputFile> {
        match self.check(path, by) {
            Ok(file) => Some(file),
            Err(diagnostic) => {
                self.found.push(*diagnostic);
                None
            }
        }
    }

    /// The same of a file that is not to replace one, if `no_overwrite` says so.
    pub fn claim_unless_there(&mut self, path: &Path, by: NamedBy, no_overwrite: bool) -> Option<OutputFile> {
        if no_overwrite && self.is_there(path) {
            return None;
        }
        let file = self.claim(path, by)?;
        Some(if no_overwrite { file.never_replacing() } else { file })
    }

    /// Whether a file stands there already, which is wrong with one that is not to replace any.
    pub fn is_there(&mut self, path: &Path) -> bool {
        let is_there = fs::symlink_metadata(path).is_ok();
        if is_there {
            let message = format!("`{}` is there already, and --no-overwrite is given", path.display());
            self.refuse(Diagnostic::error("would-overwrite", message));
        }
        is_there
    }

    /// Whether the name of a file ends as it has to, in small letters or large ones; `help` is for who wrote another one.
    pub fn ends_in(&mut self, path: &Path, ending: &str, help: &str, by: NamedBy) -> bool {
        let ends = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
        if !ends {
            let message = format!("cannot write `{}`: the output's name ends in .{ending}", path.display());
            self.refuse(at(by, Diagnostic::error("output-not-exr", message).help(help)));
        }
        ends
    }

    /// Keeps away from a file that somebody else writes, whether or not that can be done: `writer` says who.
    pub fn leave_to(&mut self, writer: &str, path: &Path) {
        if let Ok(file) = OutputFile::locate(path)
            && self.same_as(&file).is_none()
        {
            self.outputs.push(Planned { path: path.to_owned(), writer: Some(writer.to_owned()) });
        }
    }

    /// The files that are to be written, so far.
    pub fn claimed(&self) -> impl Iterator<Item = &Path> {
        self.outputs.iter().filter(|output| output.writer.is_none()).map(|output| output.path.as_path())
    }

    /// Notes something else that is wrong with the outputs.
    pub fn refuse(&mut self, diagnostic: Diagnostic) {
        self.found.push(diagnostic);
    }

    /// The end of the plan.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn finish(self) -> Result<(), Vec<Diagnostic>> {
        if self.found.is_empty() { Ok(()) } else { Err(self.found) }
    }

    fn check(&mut self, path: &Path, by: NamedBy) -> Result<OutputFile, Box<Diagnostic>> {
        let shown = path.display();
        let refuse = |code, message: String| Box::new(at(by, Diagnostic::error(code, message)));
        if let Some(root) = self.sources.root() {
            let admitted = match by {
                NamedBy::CommandLine => root.admit_named(path),
                NamedBy::Scene(_) => root.admit(path),
            };
            admitted.map_err(|why| {
                let help = "-o names a file for the picture that may lie anywhere";
                let refused = *refuse("outside-root", format!("cannot write `{shown}`: {why}"));
                Box::new(if by == NamedBy::CommandLine { refused } else { refused.help(help) })
            })?;
        }
        let file = OutputFile::locate(path).map_err(|why| refuse("cannot-write", format!("cannot write `{shown}`: {why}")))?;
        if let Some(input) = self.sources.input(file.replaced_id().as_ref(), &file.real_path()) {
            let read = match input.span {
                Some(_) => format!("which the scene reads as `{}`", input.name.display()),
                None => format!("which is {}, `{}`", input.role, input.name.display()),
            };
            let refused = *refuse(IS_INPUT, format!("cannot write `{shown}`, {read}"));
            let refused = match (input.span, refused.primary.is_some()) {
                (Some(span), true) => refused.and(span, "read here"),
                (Some(span), false) => refused.at(span, "read here"),
                (None, _) => refused,
            };
            return Err(Box::new(refused.help("give the output another name; -o names the picture")));
        }
        if let Some(other) = self.same_as(&file) {
            let Planned { path: other, writer } = &self.outputs[other];
            let message = match writer {
                None => format!("cannot write both `{}` and `{shown}`: they are one file", other.display()),
                Some(writer) => {
                    format!("cannot write `{shown}`: it is one file with `{}`, which {writer} writes", other.display())
                }
            };
            return Err(Box::new(refuse(COINCIDE, message).help("give one of them another name")));
        }
        self.outputs.push(Planned { path: path.to_owned(), writer: None });
        Ok(file)
    }

    /// The output so far that is the same file; else remembers this one.
    fn same_as(&mut self, file: &OutputFile) -> Option<usize> {
        let index = self.outputs.len();
        let id = file.replaced_id();
        if let Some(other) = id.as_ref().and_then(|id| self.by_id.get(id)) {
            return Some(*other);
        }
        let key = (file.folder.clone(), file.name.to_string_lossy().to_lowercase());
        let others = self.by_name.entry(key).or_default();
        if let Some((_, other)) = others.iter().find(|(name, _)| *name == file.name) {
            return Some(*other);
        }
        if let Some((_, other)) = others.first() {
            let ignores = self.ignores_case.entry(file.folder.clone()).or_insert_with(|| ignores_case(&file.folder));
            if *ignores {
                return Some(*other);
            }
        }
        others.push((file.name.clone(), index));
        self.by_id.extend(id.map(|id| (id, index)));
        None
    }
}

fn at(by: NamedBy, diagnostic: Diagnostic) -> Diagnostic {
    match by {
        NamedBy::Scene(Some(span)) => diagnostic.at(span, ""),
        _ => diagnostic,
    }
}

/// Whether names in a folder that differ in case only are one file: asked of the entries that it has, and of its own name if it has none.
fn ignores_case(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let swapped = |path: &Path| -> Option<PathBuf> {
        let name = path.file_name()?.to_str()?;
        let swap = |c: char| if c.is_ascii_lowercase() { c.to_ascii_uppercase() } else { c.to_ascii_lowercase() };
        let other: String = name.chars().map(swap).collect();
        (other != name).then(|| path.with_file_name(other))
    };
    let id = |path: &Path| fs::symlink_metadata(path).ok().map(|found| FileId::of(path, &found));
    let asked = entries.chain([folder.to_owned()]).find_map(|path| Some((id(&path)?, id(&swapped(&path)?))));
    asked.is_some_and(|(one, other)| other == Some(one))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of two outputs in a folder whose file system ignores case, or does not.
    fn said(ignores: bool, names: [&str; 2]) -> Vec<String> {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().canonicalize().unwrap();
        let sources = SourceMap::new();
        let mut plan = Plan::new(&sources);
        plan.ignores_case.insert(folder.clone(), ignores);
        for name in names {
            plan.claim(&folder.join(name), NamedBy::CommandLine);
        }
        plan.finish().err().unwrap_or_default().into_iter().map(|d| d.message).collect()
    }

    #[test]
    fn case_tells_names_apart_where_the_file_system_does() {
        let names = ["Room.Ä.exr", "room.ä.EXR"];
        assert!(said(false, names).is_empty());
        let said = said(true, names).join("");
        assert!(names.iter().all(|name| said.contains(name)) && said.contains("one file"), "{said}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_file_system_is_asked_whether_it_ignores_case() {
        let dir = tempfile::tempdir().unwrap();
        assert!(!ignores_case(dir.path()));
        std::fs::write(dir.path().join("file"), "").unwrap();
        assert!(!ignores_case(dir.path()));
        // Two names that differ in case only, of one file, look like a file system that ignores it; the second thoughts are worth little.
        std::fs::hard_link(dir.path().join("file"), dir.path().join("FILE")).unwrap();
        assert!(ignores_case(dir.path()));
    }
}
