//! Files under way, beside their place: made anew under random names, locked while their process lives, cleared when it does not.

use super::Staged;
use crate::lang::source::floor_char;
use crate::say;
use anyhow::{Context, Result, bail};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How names of files under way end.
const SUFFIX: &str = ".part";
/// Random characters in them.
const RANDOM: usize = 12;
/// Bytes of the name of the file that they keep: also very long names leave room for the rest, on file systems with short names too.
const KEPT: usize = 100;

/// All files under way. The program's only global state, for a second signal may end it at any moment, and leaves no litter.
/// Whoever makes or moves such a file holds the lock.
static UNDER_WAY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn under_way() -> MutexGuard<'static, Vec<PathBuf>> {
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all files under way, and lets none be made or moved any more: for the moment before the process ends. Files that are being
/// moved to their places together are all moved first.
pub fn discard_all() {
    let all = under_way();
    for path in all.iter() {
        let _ = fs::remove_file(path);
    }
    // Never unlocked.
    std::mem::forget(all);
}

/// Turns the signal that a file has become larger than the process may make it, which would end the process, into an error of writing.
pub fn ignore_file_size_signal() {
    #[cfg(unix)]
    {
        let noted = std::sync::Arc::default();
        if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, noted) {
            say!("warning: a limit on the size of files would end the program: {error}");
        }
    }
}

/// A file under way. Removed when dropped, unless it has been moved to its place.
pub struct Temporary {
    path: PathBuf,
    replaced: Option<Metadata>,
}

impl Temporary {
    /// Makes an empty file in `folder` for a file called `name`, which is to replace the given one.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn new(folder: &Path, name: &OsStr, replaced: Option<&Metadata>) -> io::Result<(File, Self)> {
        let prefix = prefix(name);
        // Locked by somebody else: taken for abandoned, in the moment between being made and being locked.
        for _ in 0..100 {
            let made = tempfile::Builder::new().prefix(&prefix).suffix(SUFFIX).rand_bytes(RANDOM).make_in(folder, |path| {
                let mut all = under_way();
                let file = create(path, replaced.is_some())?;
                all.push(path.to_owned());
                Ok(file)
            })?;
            let (file, path) = made.into_parts();
            let own = Self { path: path.keep()?, replaced: replaced.cloned() };
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => continue,
                // No locks on this file system: then nobody can clear it either.
                Err(TryLockError::Error(_)) => return Ok((file, own)),
                Ok(()) if is_linked(&file)? => return Ok((file, own)),
                Ok(()) => {}
            }
        }
        Err(io::Error::other("its temporary file disappears again and again"))
    }

    /// Gives the written file the owner and mode of the one that it replaces, and sees that it is on the disk.
    ///
    /// # Errors
    /// If it is not.
    pub fn complete(&self, file: &File) -> io::Result<()> {
        if let Some(replaced) = &self.replaced {
            #[cfg(unix)]
            {
                use std::os::unix::fs::MetadataExt;
                let own = file.metadata()?;
                if (own.uid(), own.gid()) != (replaced.uid(), replaced.gid()) {
                    // Only some may give files away.
                    let _ = std::os::unix::fs::fchown(file, Some(replaced.uid()), Some(replaced.gid()));
                }
            }
            file.set_permissions(replaced.permissions())?;
        }
        file.sync_all()
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut all = under_way();
        // Not there any more if it has been moved.
        let _ = fs::remove_file(&self.path);
        all.retain(|path| *path != self.path);
    }
}

/// Moves files to their places, one right after the other.
///
/// # Errors
/// If one cannot be moved: the later ones are not either.
pub(super) fn publish(mut all: Vec<Staged>) -> Result<()> {
    // Those first that take the place of others: that is what the system may refuse.
    all.sort_by_key(|staged| staged.file.replaced.is_none());
    for staged in &all {
        if staged.file.real_path().is_dir() {
            bail!("{}: there is a directory of that name now", staged.file.cannot_write());
        }
    }
    {
        let _uninterrupted = under_way();
        for staged in &all {
            let (from, to) = (&staged.temporary.path, staged.file.real_path());
            if staged.file.may_replace { fs::rename(from, to) } else { move_to_free_name(from, &to) }
                .with_context(|| staged.file.cannot_write())?;
        }
    }
    let mut folders: Vec<PathBuf> = all.iter().map(|staged| staged.file.folder.clone()).collect();
    folders.dedup();
    for folder in folders {
        sync_folder(&folder);
    }
    Ok(())
}

/// Moves a file to a name that no file has yet.
fn move_to_free_name(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(e),
        // File systems without hard links.
        Err(_) if fs::symlink_metadata(to).is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(from, to),
        Ok(()) => fs::remove_file(from),
    }
}

/// Sees that a move is on the disk. Not all file systems can tell; the file is in its place anyway.
fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    if let Ok(opened) = File::open(folder) {
        let _ = opened.sync_all();
    }
    let _ = folder;
}

fn create(path: &Path, private: bool) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    // What replaces a file gets that one's mode at its end; until then nobody else may read it.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, if private { 0o600 } else { 0o666 });
    let _ = private;
    options.open(path)
}

/// Whether a file has a name still.
fn is_linked(file: &File) -> io::Result<bool> {
    #[cfg(unix)]
    return Ok(std::os::unix::fs::MetadataExt::nlink(&file.metadata()?) > 0);
    #[cfg(not(unix))]
    return Ok(file.metadata().is_ok());
}

/// How the names of files under way begin that are to become `name`.
fn prefix(name: &OsStr) -> OsString {
    let bytes = name.as_encoded_bytes();
    let kept = match name.to_str() {
        Some(text) => OsString::from(&text[..floor_char(text, KEPT)]),
        None if bytes.len() <= KEPT => name.to_owned(),
        None => OsString::from(name.to_string_lossy().chars().take(KEPT / 3).collect::<String>()),
    };
    let mut prefix = OsString::from(".");
    prefix.push(kept);
    prefix.push(".");
    prefix
}

/// Removes the files under way of processes that have died, as far as they were to become `name` in `folder`.
///
/// A process holds a lock on each file that it is writing, which ends with it; it does not matter whether its number is that of another
/// process, here or in another container.
pub fn clear_abandoned(folder: &Path, name: &OsStr) {
    let prefix = prefix(name);
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let found = entry.file_name();
        let random =
            found.as_encoded_bytes().strip_prefix(prefix.as_encoded_bytes()).and_then(|r| r.strip_suffix(SUFFIX.as_bytes()));
        if random.is_some_and(|r| r.len() == RANDOM && r.iter().all(u8::is_ascii_alphanumeric)) {
            remove_if_unlocked(&entry.path());
        }
    }
}

/// Removes a file that no process has locked.
fn remove_if_unlocked(path: &Path) {
    if !fs::symlink_metadata(path).is_ok_and(|m| m.is_file()) {
        return;
    }
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        (rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK).bits() as i32,
    );
    if let Ok(file) = options.open(path)
        && file.try_lock().is_ok()
    {
        let _ = fs::remove_file(path);
    }
}
