//! The files that a scene is made of, and where each of them was included.

use crate::files::{self, FileId, Root, Stamp, Stamps};
use crate::lang::gltf_scene;
use crate::lang::lines::Lines;
use crate::lang::source::dialect::is_pbrt_file;
use crate::lang::source::made::Shared;
use crate::loading::Loading;
use bhs_core::diagnostics::{Diagnostic, Span};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

mod aside;
mod dialect;
mod made;

pub(super) use aside::Side;
pub use made::FileCache;

/// Includes within includes that are allowed.
pub const MAX_INCLUDE_DEPTH: usize = 64;

/// One text.
#[derive(Clone, Debug)]
pub struct Source {
    /// What messages call it: the path as the user would write it.
    pub name: String,
    /// The text, without a byte order mark.
    pub text: Arc<str>,
    /// Where another file includes it.
    pub included_at: Option<Span>,
    /// The folder that relative paths in it start from.
    folder: PathBuf,
    /// The file itself, to notice a file that includes itself.
    identity: Option<PathBuf>,
    /// Whether it is read with pbrt-v4's meaning.
    pub is_pbrt: bool,
    /// Whether it has been made of a glTF file, in whose coordinates files that are added stand.
    pub is_model: bool,
    /// Its lines, found when the first place in it is asked for.
    lines: OnceLock<Lines>,
}

/// All texts of a scene; [`Span::file`] is an index in here.
#[derive(Debug, Default)]
pub struct SourceMap {
    sources: Vec<Source>,
    root: Option<Root>,
    inputs: Mutex<Inputs>,
    /// The hash of what has been read, in the order of reading.
    hasher: Mutex<blake3::Hasher>,
    /// All files that there are, in place of those of the system.
    memory: Option<BTreeMap<PathBuf, Arc<[u8]>>>,
    /// What has been made of files, if it is kept.
    cache: Option<Arc<FileCache>>,
    /// What several parts of the scene take out of the same files.
    shared: Shared,
    /// Whether the scene is pbrt-v4's, whatever its file is called.
    pbrt: bool,
    /// Files that are read at the end of the scene.
    additions: Vec<PathBuf>,
    /// How far it has come.
    loading: Arc<Loading>,
    /// What is to be said of a scene that has been made of a model.
    notes: Vec<Diagnostic>,
}

/// A file that the scene reads.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFile {
    /// Its name as it is given.
    pub name: PathBuf,
    /// Where the scene names it first; `None` for what the command line names.
    pub span: Option<Span>,
    /// What it is, in words.
    pub role: &'static str,
}

/// All files that the scene has read, found by what they are and by their real paths: a file may have been replaced since.
#[derive(Debug, Default)]
struct Inputs {
    by_id: HashMap<FileId, InputFile>,
    by_path: HashMap<PathBuf, InputFile>,
    /// Each of them, those that could not be read too, as it was just before it was read first.
    stamps: Stamps,
    /// Their paths.
    stamped: HashSet<PathBuf>,
}

impl SourceMap {
    /// No texts yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// No texts yet; whatever the scene names is to lie in a folder.
    pub fn confined_to(root: Option<Root>) -> Self {
        Self { root, ..Self::default() }
    }

    /// No texts yet, and no files but the given ones: what a scene reads does not come from the system.
    pub fn in_memory(memory: BTreeMap<PathBuf, Arc<[u8]>>) -> Self {
        Self { memory: Some(memory), ..Self::default() }
    }

    /// Keeps what is made of files in `cache`, and takes it from there.
    #[must_use]
    pub fn keeping(self, cache: &Arc<FileCache>) -> Self {
        Self { cache: Some(Arc::clone(cache)), ..self }
    }

    /// The folder that confines the scene, if one does.
    pub fn root(&self) -> Option<&Root> {
        self.root.as_ref()
    }

    /// The file of the scene, or what it reads, that a file is: its identity if it is there, and its real path.
    pub fn input(&self, id: Option<&FileId>, real: &Path) -> Option<InputFile> {
        let inputs = self.inputs.lock().unwrap_or_else(PoisonError::into_inner);
        id.and_then(|id| inputs.by_id.get(id)).or_else(|| inputs.by_path.get(real)).cloned()
    }

    /// Notes that a file that the command line names, which is there, is read too: `role` says what it is.
    pub fn add_input(&mut self, path: &Path, role: &'static str) {
        let input = InputFile { name: path.to_owned(), span: None, role };
        self.note_stamp(path);
        let inputs = self.inputs.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Ok(found) = path.metadata() {
            inputs.by_id.entry(FileId::of(path, &found)).or_insert_with(|| input.clone());
        }
        if let Ok(real) = path.canonicalize() {
            inputs.by_path.entry(real).or_insert(input);
        }
    }

    /// Opens the scene `path`; `-` is standard input, whose relative paths start from the current folder.
    ///
    /// # Errors
    /// That it cannot be read. (In a box: a diagnostic is large.)
    pub fn open(&mut self, path: impl AsRef<Path>) -> Result<u16, Box<Diagnostic>> {
        let path = path.as_ref();
        let cannot = |why: String| {
            let message = format!("cannot read the scene `{}`: {why}", path.display());
            Box::new(Diagnostic::error("cannot-read", message).maybe_help(files::pipe_help(path).map(str::to_owned)))
        };
        if path == Path::new("-") {
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| cannot(e.to_string()))?;
            let file = self.push("<stdin>", bytes, PathBuf::new(), None, None)?;
            self.mark(file, self.pbrt);
            return Ok(file);
        }
        let bytes = self.content(path, path, None).map_err(cannot)?;
        if gltf_scene::is_gltf_file(path) {
            return self.push_model(path, &bytes).map_err(cannot);
        }
        let file = self.push_file(path, bytes, None)?;
        self.mark(file, self.pbrt || is_pbrt_file(path));
        Ok(file)
    }

    /// Adds a text that is no file, such as an example of the language reference or the command line.
    pub fn add(&mut self, name: &str, text: &str) -> u16 {
        // A text that has been in memory as a `str` cannot fail to be one.
        self.push(name, text.as_bytes().to_vec(), PathBuf::new(), None, None).unwrap_or_default()
    }

    /// Opens the file that the text at `span` includes as `path`.
    ///
    /// # Errors
    /// That it cannot be read, that it includes itself, or that includes are nested too deeply.
    pub fn include(&mut self, path: &str, span: Span) -> Result<u16, Box<Diagnostic>> {
        let full = self.locate(path, span);
        let error = |code, message: String, label: &str| Box::new(Diagnostic::error(code, message).at(span, label));
        let bytes = match self.content(&full, Path::new(path), Some(span)) {
            Ok(bytes) => bytes,
            Err(why) => return Err(error("cannot-read", format!("cannot read `{path}`: {why}"), "")),
        };

        // Follow the chain of includes up to the scene.
        let identity = self.real_path(&full);
        let mut depth = 0;
        let mut at = Some(span);
        while let Some(here) = at {
            let source = &self.sources[usize::from(here.file)];
            if identity.is_some() && source.identity == identity {
                let mut cycle = error("include-cycle", format!("`{path}` includes itself"), "this file is being read already");
                if here != span {
                    cycle.labels.push(bhs_core::diagnostics::Label { span: here, text: "by way of this".into() });
                }
                return Err(cycle);
            }
            depth += 1;
            at = source.included_at;
        }
        if depth > MAX_INCLUDE_DEPTH {
            let message = format!("files are included more than {MAX_INCLUDE_DEPTH} deep");
            return Err(error("include-depth", message, "this one goes too far"));
        }
        let (is_pbrt, folder) = self.meaning_within(&full, span);
        let file = self.push_file(&full, bytes, Some(span))?;
        self.mark(file, is_pbrt);
        if let (true, Some(folder), Some(source)) = (is_pbrt, folder, self.sources.get_mut(usize::from(file))) {
            source.folder = folder;
        }
        Ok(file)
    }

    /// Adds the texts so far to the hash of the scene. Those of the command line come later: they are no part of it.
    pub(crate) fn hash_texts(&self) {
        self.sources.iter().for_each(|source| self.hash_content(source.text.as_bytes()));
    }

    /// Adds the numbers to the hash that the scene is given from outside. Without any it stays as it is.
    pub(crate) fn hash_variables(&self, given: &[(String, f64)]) {
        for (name, value) in given {
            self.hash_content(name.as_bytes());
            self.hash_content(&value.to_le_bytes());
        }
    }

    /// A hash of the scene: of its texts, and then of the content of all other files that it has read, in the order of reading, as
    /// hexadecimal digits (BLAKE3, 256 bits). Their names are no part of it.
    pub(crate) fn scene_hash(&self) -> String {
        self.hasher.lock().unwrap_or_else(PoisonError::into_inner).finalize().to_hex().to_string()
    }

    /// Adds the content of a file to the hash. Its length comes first: what two files hold cannot be shared out otherwise.
    pub(super) fn hash_content(&self, content: &[u8]) {
        let mut hasher = self.hasher.lock().unwrap_or_else(PoisonError::into_inner);
        hasher.update(&(content.len() as u64).to_le_bytes()).update(content);
    }

    /// The text number `file`.
    pub fn get(&self, file: u16) -> Option<&Source> {
        self.sources.get(usize::from(file))
    }

    /// All texts in the order in which they were opened.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.sources.iter()
    }

    /// Line and column (in characters), both from 1, of a byte of a file.
    pub fn line_column(&self, file: u16, offset: u32) -> (usize, usize) {
        let Some(source) = self.get(file) else { return (1, 1) };
        let lines = source.lines.get_or_init(|| Lines::new(&source.text));
        lines.place(&source.text, floor_char(&source.text, offset as usize))
    }

    /// The content of the file `path`, which `name` names at `span`, or what is wrong with it.
    fn content(&self, path: &Path, name: &Path, span: Option<Span>) -> Result<Vec<u8>, String> {
        if let Some(files) = &self.memory {
            return files.get(path).map(|bytes| bytes.to_vec()).ok_or_else(|| "there is no such file".into());
        }
        if let Some(root) = &self.root {
            root.admit(path)?;
        }
        self.note_stamp(path);
        let (content, id) = files::read(path)?;
        self.loading.read(content.len());
        let real = self.real_path(path);
        let mut inputs = self.inputs.lock().unwrap_or_else(PoisonError::into_inner);
        let input = || InputFile { name: name.to_owned(), span, role: "the scene" };
        // Whoever reads it first, it is where the scene names it first that is told.
        let earlier = |known: &mut InputFile| {
            if aside::comes_before(span, known.span) {
                *known = input();
            }
        };
        inputs.by_id.entry(id).and_modify(earlier).or_insert_with(input);
        if let Some(real) = real {
            inputs.by_path.entry(real).and_modify(earlier).or_insert_with(input);
        }
        Ok(content)
    }

    /// Whether the file is there that the text at `span` calls `path`, and may be read. It is watched for either way.
    pub(crate) fn is_there(&self, path: &str, span: Span) -> bool {
        let full = self.locate(path, span);
        if let Some(files) = &self.memory {
            return files.contains_key(&full);
        }
        if self.root.as_ref().is_some_and(|root| root.admit(&full).is_err()) {
            return false;
        }
        self.note_stamp(&full);
        full.is_file()
    }

    /// Notes what a file is, before it is read.
    fn note_stamp(&self, path: &Path) {
        let mut inputs = self.inputs.lock().unwrap_or_else(PoisonError::into_inner);
        if inputs.stamped.insert(path.to_owned()) {
            inputs.stamps.push((path.to_owned(), Stamp::of(path)));
        }
    }

    /// All files that the scene has read or tried to read, as they were before.
    pub fn stamps(&self) -> Stamps {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner).stamps.clone()
    }

    /// What tells a file from all others, if it is there.
    fn real_path(&self, path: &Path) -> Option<PathBuf> {
        match &self.memory {
            Some(files) => files.contains_key(path).then(|| path.to_owned()),
            None => path.canonicalize().ok(),
        }
    }

    /// The folder where relative paths in the text at `span` start.
    pub(crate) fn folder(&self, span: Span) -> PathBuf {
        self.get(span.file).map(|s| s.folder.clone()).unwrap_or_default()
    }

    /// The file that the text at `span` calls `path`.
    pub(crate) fn locate(&self, path: &str, span: Span) -> PathBuf {
        match self.get(span.file) {
            Some(source) => source.folder.join(path),
            None => PathBuf::from(path),
        }
    }

    fn push_file(&mut self, path: &Path, bytes: Vec<u8>, included_at: Option<Span>) -> Result<u16, Box<Diagnostic>> {
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self.push(&path.to_string_lossy(), bytes, folder, included_at, self.real_path(path))
    }

    fn push(
        &mut self,
        name: &str,
        bytes: Vec<u8>,
        folder: PathBuf,
        included_at: Option<Span>,
        identity: Option<PathBuf>,
    ) -> Result<u16, Box<Diagnostic>> {
        let refuse = |code, message: String, help: &str| {
            let d = Diagnostic::error(code, message).help(help);
            Box::new(match included_at {
                Some(span) => d.at(span, "included here"),
                None => d,
            })
        };
        let Ok(file) = u16::try_from(self.sources.len()) else {
            return Err(refuse("too-many-files", format!("more than {} files are included", u16::MAX), "join some of them"));
        };
        if u32::try_from(bytes.len()).is_err() {
            return Err(refuse("file-too-large", format!("`{name}` is larger than 4 GiB"), "put its meshes into PLY files"));
        }
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(e) => {
                let (at, bytes) = (e.utf8_error().valid_up_to(), e.as_bytes());
                let line = bytes[..at].iter().filter(|b| **b == b'\n').count() + 1;
                let message = format!("`{name}` is not UTF-8 text: line {line} holds the byte 0x{:02x}", bytes[at]);
                return Err(refuse(
                    "not-utf8",
                    message,
                    "save it as UTF-8; meshes and images are named in a scene, not included",
                ));
            }
        };
        let text: Arc<str> = text.strip_prefix('\u{feff}').unwrap_or(&text).into();
        let name = name.to_owned();
        self.sources.push(Source {
            name,
            text,
            included_at,
            folder,
            identity,
            is_pbrt: false,
            is_model: false,
            lines: OnceLock::new(),
        });
        Ok(file)
    }
}

/// The nearest start of a character at or before `offset`.
pub(crate) fn floor_char(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}
