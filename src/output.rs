//! Files that the program writes.

use anyhow::{Context, Result, bail};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// An output file that comes into being only when it is whole: until then everything goes to a file beside it.
pub struct OutputFile {
    path: PathBuf,
    partial: PathBuf,
}

impl OutputFile {
    /// Makes sure, before any work is done, that `path` can be written.
    ///
    /// # Errors
    /// Says why it cannot.
    pub fn reserve(path: &Path) -> Result<Self> {
        let shown = path.display();
        if path.is_dir() {
            bail!("cannot write `{shown}`: it is a directory");
        }
        let name = path.file_name().with_context(|| format!("cannot write `{shown}`: it does not name a file"))?;
        if std::fs::metadata(path).is_ok_and(|m| m.permissions().readonly()) {
            bail!("cannot write `{shown}`: the file is read-only");
        }
        let partial = path.with_file_name(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
        std::fs::File::create(&partial).with_context(|| format!("cannot write `{shown}`"))?;
        Ok(Self { path: path.to_owned(), partial })
    }

    /// Where it will stand.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file and puts it in its place.
    ///
    /// # Errors
    /// If it cannot be written; what stood there before is then untouched.
    pub fn finish(self, write: impl FnOnce(&mut BufWriter<std::fs::File>) -> Result<()>) -> Result<()> {
        let shown = self.path.display();
        let file = std::fs::File::create(&self.partial).with_context(|| format!("cannot write `{shown}`"))?;
        let mut buffer = BufWriter::new(file);
        write(&mut buffer).and_then(|()| Ok(buffer.flush()?)).with_context(|| format!("cannot write `{shown}`"))?;
        drop(buffer);
        std::fs::rename(&self.partial, &self.path).with_context(|| format!("cannot write `{shown}`"))
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        // After `finish` there is nothing left of it.
        let _ = std::fs::remove_file(&self.partial);
    }
}
