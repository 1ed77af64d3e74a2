//! The files that a scene is made of, and where each of them was included.

use bhs_core::diagnostics::{Diagnostic, Span, did_you_mean};
use bhs_core::params::Files;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
}

/// All texts of a scene; [`Span::file`] is an index in here.
#[derive(Debug, Default)]
pub struct SourceMap {
    sources: Vec<Source>,
}

impl SourceMap {
    /// No texts yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Opens the scene `path`; `-` is standard input, whose relative paths start from the current folder.
    ///
    /// # Errors
    /// That it cannot be read. (In a box: a diagnostic is large.)
    pub fn open(&mut self, path: &str) -> Result<u16, Box<Diagnostic>> {
        let cannot = |why: String| Box::new(Diagnostic::error("cannot-read", format!("cannot read the scene `{path}`: {why}")));
        if path == "-" {
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| cannot(e.to_string()))?;
            return self.push("<stdin>", bytes, PathBuf::new(), None, None);
        }
        let bytes = read_file(Path::new(path)).map_err(cannot)?;
        self.push_file(Path::new(path), bytes, None)
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
        let bytes = match read_file(&full) {
            Ok(bytes) => bytes,
            Err(why) => return Err(error("cannot-read", format!("cannot read `{path}`: {why}"), "")),
        };

        // Follow the chain of includes up to the scene.
        let identity = full.canonicalize().ok();
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
        self.push_file(&full, bytes, Some(span))
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
        let before = floor_char(&source.text, offset as usize);
        let line_start = source.text[..before].rfind('\n').map_or(0, |i| i + 1);
        let line = source.text.as_bytes()[..line_start].iter().filter(|b| **b == b'\n').count() + 1;
        (line, source.text[line_start..before].chars().count() + 1)
    }

    /// The file that the text at `span` calls `path`.
    fn locate(&self, path: &str, span: Span) -> PathBuf {
        match self.get(span.file) {
            Some(source) => source.folder.join(path),
            None => PathBuf::from(path),
        }
    }

    fn push_file(&mut self, path: &Path, bytes: Vec<u8>, included_at: Option<Span>) -> Result<u16, Box<Diagnostic>> {
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self.push(&path.to_string_lossy(), bytes, folder, included_at, path.canonicalize().ok())
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
        self.sources.push(Source { name: name.to_owned(), text, included_at, folder, identity });
        Ok(file)
    }
}

impl Files for SourceMap {
    fn read(&self, path: &str, span: Span) -> Result<Vec<u8>, String> {
        read_file(&self.locate(path, span))
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

/// The content of a file, or what is wrong with it.
fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    use std::io::ErrorKind;
    let metadata = fs::metadata(path).map_err(|e| match e.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => not_found(path),
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => e.to_string(),
    })?;
    if metadata.is_dir() {
        return Err("it is a directory".into());
    }
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_char_device(&metadata.file_type()) {
        return Err("it is a device, not a file".into());
    }
    fs::read(path).map_err(|e| match e.kind() {
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => e.to_string(),
    })
}

/// Words for a file that is not there: the folder, and the name that was probably meant.
fn not_found(path: &Path) -> String {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return format!("there is no folder `{}`", folder.display());
    }
    let names: Vec<String> = fs::read_dir(folder)
        .map(|entries| entries.take(1000).filter_map(|e| e.ok()?.file_name().into_string().ok()).collect())
        .unwrap_or_default();
    let wanted = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let mut words = "there is no such file".to_owned();
    if folder != Path::new(".") {
        words += &format!(" in `{}`", folder.display());
    }
    if let Some(near) = did_you_mean(&wanted, names.iter().map(String::as_str)) {
        words += &format!("; did you mean `{near}`?");
    }
    words
}
