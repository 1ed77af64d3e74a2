//! Files that the program reads: only regular ones, and with `--root` only those below a folder.
//!
//! Pipes and devices are refused, not read: a named pipe without a writer would stop the program for good, and a device may have no end.

mod root;
mod stamp;

pub use root::Root;
pub use stamp::{Stamp, Stamps};

use bhs_core::diagnostics::did_you_mean;
use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// What a file is, by whatever name it is reached: links to one file, and other spellings of its name, have one identity.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FileId(#[cfg(unix)] [u64; 2], #[cfg(not(unix))] PathBuf);

impl FileId {
    /// The identity of a file or folder that is there.
    #[cfg(unix)]
    pub fn of(_: &Path, metadata: &Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self([metadata.dev(), metadata.ino()])
    }

    /// The identity of a file or folder that is there. Hard links count as files of their own.
    #[cfg(not(unix))]
    pub fn of(path: &Path, _: &Metadata) -> Self {
        Self(path.canonicalize().unwrap_or_else(|_| path.to_owned()))
    }
}

/// What a path leads to that is no regular file, in words; `None` for a regular file.
pub fn special(kind: FileType) -> Option<&'static str> {
    if kind.is_file() {
        return None;
    }
    if kind.is_dir() {
        return Some("it is a directory");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("it is a pipe, not a file");
        }
        if kind.is_socket() {
            return Some("it is a socket, not a file");
        }
    }
    Some("it is a device, not a file")
}

/// Opens a regular file for reading.
///
/// # Errors
/// What is wrong with it, in words.
pub fn open(path: &Path) -> Result<(File, Metadata), String> {
    // Looked at before it is opened, for opening some devices does something.
    let found = fs::metadata(path).map_err(|e| words(path, &e))?;
    if let Some(what) = special(found.file_type()) {
        return Err(what.into());
    }
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        // Does not wait for a writer, should the path have become a pipe since.
        options.custom_flags((rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY).bits() as i32);
    }
    let file = options.open(path).map_err(|e| words(path, &e))?;
    let metadata = file.metadata().map_err(|e| e.to_string())?;
    match special(metadata.file_type()) {
        Some(what) => Err(what.into()),
        None => Ok((file, metadata)),
    }
}

/// The content of a regular file, and which file it is.
///
/// # Errors
/// What is wrong with it, in words.
pub fn read(path: &Path) -> Result<(Vec<u8>, FileId), String> {
    let (mut file, metadata) = open(path)?;
    let mut content = Vec::new();
    let expected = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
    content.try_reserve_exact(expected).map_err(|_| format!("its {expected} bytes do not fit into memory"))?;
    file.read_to_end(&mut content).map_err(|e| e.to_string())?;
    Ok((content, FileId::of(path, &metadata)))
}

/// What `-` is good for, to be said of a pipe that is refused.
pub fn pipe_help(path: &Path) -> Option<&'static str> {
    let is_pipe = fs::metadata(path).is_ok_and(|m| special(m.file_type()) == Some("it is a pipe, not a file"));
    is_pipe.then_some("write `-` and pipe it into standard input")
}

fn words(path: &Path, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => not_found(path),
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
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

/// Links that are followed one after the other, as the system does.
const MAX_LINKS: u32 = 40;

/// The real path of a file that is there or could be made: links followed, `.` and `..` gone. Its folder is there.
///
/// # Errors
/// If there is no such folder, or the system does not let it be seen.
pub fn resolve(path: &Path) -> std::io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        match path.canonicalize() {
            Err(e) if e.kind() == ErrorKind::NotFound => {}
            other => return other,
        }
        let name = path.file_name().ok_or(ErrorKind::NotFound)?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).canonicalize()?;
        // A link to what is not there yet: that is what would be made.
        match fs::read_link(folder.join(name)) {
            Ok(target) => path = folder.join(target),
            Err(_) => return Ok(folder.join(name)),
        }
    }
    Err(std::io::Error::other("too many links"))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn only_regular_files_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("file"), "text").unwrap();
        fs::hard_link(at("file"), at("hard")).unwrap();
        symlink("file", at("link")).unwrap();
        let (content, id) = read(&at("file")).unwrap();
        assert_eq!(content, b"text");
        let own_name = dir.path().file_name().unwrap().to_str().unwrap();
        for same in ["hard", "link", &format!("./../{own_name}/link")] {
            assert_eq!(read(&at(same)).unwrap().1, id, "{same}");
        }
        let status = std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap();
        assert!(status.success());
        let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        for (name, what) in [("pipe", "a pipe"), ("socket", "a socket"), (".", "a directory"), ("/dev/zero", "a device")] {
            assert!(read(&at(name)).is_err_and(|e| e.contains(what)), "{name}");
        }
        assert!(pipe_help(&at("pipe")).is_some() && pipe_help(&at("file")).is_none());
        assert!(read(&at("fil")).is_err_and(|e| e.contains("did you mean `file`")));
    }

    #[test]
    fn names_that_are_not_there_yet_resolve_to_where_they_would_be() {
        let dir = tempfile::tempdir().unwrap();
        let real = dir.path().canonicalize().unwrap();
        fs::create_dir(real.join("inner")).unwrap();
        symlink("inner/new", real.join("link")).unwrap();
        symlink("link", real.join("again")).unwrap();
        symlink("loop", real.join("loop")).unwrap();
        for name in ["inner/new", "inner/../inner/./new", "link", "again"] {
            assert_eq!(resolve(&real.join(name)).unwrap(), real.join("inner/new"), "{name}");
        }
        assert!(resolve(&real.join("nowhere/new")).is_err());
        assert!(resolve(&real.join("loop")).is_err());
    }
}
