//! Files that the program writes: each appears whole or not at all, and takes the place of nothing that it should not.
//!
//! A file is written beside its place under a name of its own (`temporary`), synced, and moved there. Its place is where the links of its
//! name lead, so links stay, and it keeps the owner and the mode of the file that it replaces. Files that belong together are moved
//! together, and go elsewhere together if there is no room ([`OutputSet`]). [`Plan`] compares all that is to be written with all that is read.

mod plan;
mod set;
mod temporary;

pub use plan::{COINCIDE, IS_INPUT, NamedBy, Plan};
pub use set::{Kept, OutputSet, Rescue};
pub use temporary::{discard_all, ignore_file_size_signal};

use crate::files::{self, FileId};
use anyhow::{Context, Result};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};
use temporary::Temporary;

/// What an output is written through.
pub type Writer = BufWriter<File>;

/// An output file that comes into being only when it is whole.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// As it was named.
    path: PathBuf,
    /// The folder where it will stand, links followed.
    folder: PathBuf,
    /// Its name there.
    name: OsString,
    /// What stood there when it was located.
    replaced: Option<Metadata>,
    /// Whether it may take the place of another file.
    may_replace: bool,
}

impl OutputFile {
    /// Finds out, without touching anything, whether `path` can be written.
    ///
    /// # Errors
    /// Why it cannot, in words.
    pub fn locate(path: &Path) -> Result<Self, String> {
        if path.file_name().is_none() {
            return Err(if path.is_dir() { "it is a directory".into() } else { "it does not name a file".into() });
        }
        let real = files::resolve(path).map_err(|e| words(path, &e))?;
        let (Some(folder), Some(name)) = (real.parent(), real.file_name()) else { return Err("it is a directory".into()) };
        let replaced = fs::metadata(&real).ok();
        if let Some(found) = &replaced {
            if let Some(what) = files::special(found.file_type()) {
                return Err(what.into());
            }
            if found.permissions().readonly() || !may_write(&real)? {
                return Err("the file is read-only".into());
            }
            if is_kept_from_others(found, folder) {
                let folder = folder.display();
                return Err(format!("the file belongs to somebody else, and `{folder}` keeps it from being replaced"));
            }
        }
        if !may_write(folder)? {
            return Err(format!("the folder `{}` is read-only", folder.display()));
        }
        Ok(Self { path: path.to_owned(), folder: folder.to_owned(), name: name.to_owned(), replaced, may_replace: true })
    }

    /// Makes sure, before any work is done, that `path` can be written. Leaves nothing behind, except that it clears away what
    /// earlier runs left there that were killed.
    ///
    /// # Errors
    /// Says why it cannot.
    pub fn reserve(path: &Path) -> Result<Self> {
        let file = Self::locate(path).map_err(|why| anyhow::anyhow!("cannot write `{}`: {why}", path.display()))?;
        file.probe()?;
        Ok(file)
    }

    /// Makes sure that a file can be made where this one will stand, by making one and removing it.
    ///
    /// # Errors
    /// Says why not.
    pub fn probe(&self) -> Result<()> {
        temporary::clear_abandoned(&self.folder, &self.name);
        Temporary::new(&self.folder, &self.name, self.replaced.as_ref()).with_context(|| self.cannot_write())?;
        Ok(())
    }

    /// Refuses to replace a file: should there be one in the end, this one goes elsewhere.
    pub fn never_replacing(self) -> Self {
        Self { may_replace: false, ..self }
    }

    /// May replace a file after all, as one that the program has made itself.
    pub fn replacing(self) -> Self {
        Self { may_replace: true, ..self }
    }

    /// Where it will stand, as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where it will stand, links followed.
    pub fn real_path(&self) -> PathBuf {
        self.folder.join(&self.name)
    }

    /// What stood there when it was located.
    fn replaced_id(&self) -> Option<FileId> {
        self.replaced.as_ref().map(|found| FileId::of(&self.real_path(), found))
    }

    fn cannot_write(&self) -> String {
        format!("cannot write `{}`", self.path.display())
    }

    /// The same content under another, new name.
    fn moved_to(&self, folder: &Path, name: &OsStr) -> std::io::Result<Self> {
        let (path, folder) = (folder.join(name), folder.canonicalize()?);
        Ok(Self { path, folder, name: name.to_owned(), replaced: self.replaced.clone(), may_replace: false })
    }

    /// Writes the file and puts it in its place.
    ///
    /// # Errors
    /// If it cannot be written; what stood there before is then untouched.
    pub fn finish(self, write: impl FnOnce(&mut Writer) -> Result<()>) -> Result<()> {
        temporary::publish(vec![self.stage(write)?])
    }

    /// Writes the file beside its place.
    fn stage(&self, write: impl FnOnce(&mut Writer) -> Result<()>) -> Result<Staged> {
        let staged = || -> Result<Staged> {
            // What stands there now, or else what the file was to replace.
            let now = fs::metadata(self.real_path()).ok().filter(Metadata::is_file);
            let (file, temporary) = Temporary::new(&self.folder, &self.name, now.as_ref().or(self.replaced.as_ref()))?;
            let mut buffer = BufWriter::new(file);
            write(&mut buffer)?;
            let file = buffer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            temporary.complete(&file)?;
            Ok(Staged { file: self.clone(), _lock: file, temporary })
        };
        staged().with_context(|| self.cannot_write())
    }
}

/// A file that is written, synced, and not yet in its place.
struct Staged {
    file: OutputFile,
    /// Holds the lock that tells other processes that this one is alive.
    _lock: File,
    temporary: Temporary,
}

/// Whether the system lets a file or folder be written.
fn may_write(path: &Path) -> Result<bool, String> {
    #[cfg(unix)]
    match rustix::fs::access(path, rustix::fs::Access::WRITE_OK) {
        Ok(()) => {}
        Err(rustix::io::Errno::ACCESS | rustix::io::Errno::PERM | rustix::io::Errno::ROFS) => return Ok(false),
        Err(other) => return Err(other.to_string()),
    }
    let _ = path;
    Ok(true)
}

/// Whether a folder, as `/tmp` does, lets only their owners replace files, and this is none of ours.
#[cfg(unix)]
fn is_kept_from_others(file: &Metadata, folder: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let own = rustix::process::geteuid();
    fs::metadata(folder)
        .is_ok_and(|folder| folder.mode() & STICKY != 0 && !own.is_root() && ![file.uid(), folder.uid()].contains(&own.as_raw()))
}

#[cfg(not(unix))]
fn is_kept_from_others(_: &Metadata, _: &Path) -> bool {
    false
}

/// What is wrong with the folder of an output, in words.
fn words(path: &Path, error: &std::io::Error) -> String {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match error.kind() {
        ErrorKind::NotFound if !folder.exists() => format!("there is no folder `{}`", folder.display()),
        ErrorKind::NotADirectory => format!("`{}` is no folder", folder.display()),
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}
