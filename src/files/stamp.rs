//! Whether a file is what it was.

use super::FileId;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Files as they were at some time.
pub type Stamps = Vec<(PathBuf, Stamp)>;

/// What tells a file that has been saved from what it was before, without its content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stamp(Option<(FileId, u64, Option<SystemTime>, [i64; 2])>);

impl Stamp {
    /// Of what is there now.
    pub fn of(path: &Path) -> Self {
        let found = fs::metadata(path).ok();
        Self(found.map(|found| {
            // A modification time can be set to anything, this one cannot.
            #[cfg(unix)]
            let changed = [std::os::unix::fs::MetadataExt::ctime(&found), std::os::unix::fs::MetadataExt::ctime_nsec(&found)];
            #[cfg(not(unix))]
            let changed = [0; 2];
            (FileId::of(path, &found), found.len(), found.modified().ok(), changed)
        }))
    }

    /// Whether nothing was there.
    pub fn is_missing(&self) -> bool {
        self.0.is_none()
    }
}
