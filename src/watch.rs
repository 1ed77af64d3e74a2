//! Files that are watched: whether one of them has been saved since it was read.
//!
//! What counts is what the files are ([`Stamp`]), looked at now and then; the system's own word that something has changed in their folders
//! only makes that sooner. So nothing is missed where the system has no word to give: on network file systems, or with too many watches.

use crate::files::{Stamp, Stamps};
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks while nothing else is to be done.
const LOOK: Duration = Duration::from_millis(250);
/// Time between two questions whether to go on.
const ASK: Duration = Duration::from_millis(30);
/// For so long files stay as they are before they count as saved: programs write in pieces, and some remove a file and make it anew.
const QUIET: Duration = Duration::from_millis(60);
/// For so long a file that is gone is waited for, and files that do not stay as they are.
const PATIENCE: Duration = Duration::from_secs(1);

/// The files that are watched.
pub struct Watched {
    files: Stamps,
    folders: BTreeSet<PathBuf>,
    watcher: Option<RecommendedWatcher>,
    events: Receiver<()>,
}

impl Default for Watched {
    /// No files yet.
    fn default() -> Self {
        let (told, events) = mpsc::channel();
        let tell = move |event: notify::Result<notify::Event>| {
            // Reading is an event too.
            if event.is_ok_and(|event| !matches!(event.kind, EventKind::Access(_))) {
                let _ = told.send(());
            }
        };
        Self { files: Vec::new(), folders: BTreeSet::new(), watcher: notify::recommended_watcher(tell).ok(), events }
    }
}

impl Watched {
    /// Watches these files in place of those before, as they were when they were read.
    pub fn follow(&mut self, files: Stamps) {
        // A file may be replaced by another one of its name, so its folder is watched; that of a link, and that of the file itself.
        let folder = |path: &Path| path.parent().map(|f| if f.as_os_str().is_empty() { Path::new(".") } else { f }.to_owned());
        let real = files.iter().filter_map(|(path, _)| folder(&path.canonicalize().ok()?));
        let folders: BTreeSet<PathBuf> = files.iter().filter_map(|(path, _)| folder(path)).chain(real).collect();
        if let Some(watcher) = &mut self.watcher {
            for gone in self.folders.difference(&folders) {
                let _ = watcher.unwatch(gone);
            }
            for new in folders.difference(&self.folders) {
                // Else it is looked at all the same.
                let _ = watcher.watch(new, RecursiveMode::NonRecursive);
            }
        }
        (self.files, self.folders) = (files, folders);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The first file that is not what it was.
    pub fn changed(&self) -> Option<&Path> {
        self.files.iter().find(|(path, stamp)| Stamp::of(path) != *stamp).map(|(path, _)| path.as_path())
    }

    /// Sleeps for that time, or until the system says that something has changed; whether it does.
    fn sleep(&self, time: Duration) -> bool {
        let told = self.events.recv_timeout(time).is_ok();
        if !told && self.watcher.is_none() {
            // Without a watcher the other end is gone, and nothing was waited for.
            thread::sleep(time);
        }
        while self.events.try_recv().is_ok() {}
        told
    }

    /// Waits for a file that is not what it was.
    pub fn wait(&self) -> PathBuf {
        loop {
            if let Some(path) = self.look(LOOK, || true) {
                return path;
            }
        }
    }

    /// Waits for a file that is not what it was, as long as `goes_on` says so, which is asked often.
    pub fn wait_while(&self, goes_on: impl Fn() -> bool) -> Option<PathBuf> {
        self.look(ASK, goes_on)
    }

    /// The same, asking once each time.
    fn look(&self, each: Duration, goes_on: impl Fn() -> bool) -> Option<PathBuf> {
        let mut told = true;
        let mut looked = Instant::now();
        while goes_on() {
            // There may be many files.
            if told || looked.elapsed() >= LOOK {
                looked = Instant::now();
                if let Some(path) = self.changed() {
                    return Some(path.to_owned());
                }
            }
            told = self.sleep(each);
        }
        None
    }

    /// Waits until those who save files are done with it.
    pub fn settle(&self) {
        let start = Instant::now();
        let stamps = || -> Vec<Stamp> { self.files.iter().map(|(path, _)| Stamp::of(path)).collect() };
        let mut before = stamps();
        while start.elapsed() < PATIENCE {
            thread::sleep(QUIET);
            let now = stamps();
            let is_missing = now.iter().zip(&self.files).any(|(now, (_, then))| now.is_missing() && !then.is_missing());
            if now == before && !is_missing {
                return;
            }
            before = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn whatever_is_done_to_a_file_is_seen() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let [file, link, other] = ["a", "link", "other"].map(|name| dir.path().join(name));
        fs::write(&file, "one").expect("writable");
        let mut watched = Watched::default();
        watched.follow(vec![(file.clone(), Stamp::of(&file))]);
        let changes: [&dyn Fn() -> std::io::Result<()>; 4] = [
            &|| fs::write(&file, "two"),
            &|| fs::write(&other, "two").and_then(|()| fs::rename(&other, &file)),
            &|| fs::remove_file(&file),
            &|| fs::write(&file, "two"),
        ];
        for change in changes {
            // Clocks of file systems are coarse.
            thread::sleep(Duration::from_millis(20));
            change().expect("it can be done");
            assert_eq!(watched.wait(), file);
            watched.settle();
            watched.follow(vec![(file.clone(), Stamp::of(&file))]);
            assert_eq!(watched.changed(), None);
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&file, &link).expect("links can be made");
            watched.follow(vec![(link.clone(), Stamp::of(&link))]);
            thread::sleep(Duration::from_millis(20));
            fs::write(&file, "three").expect("writable");
            assert_eq!(watched.wait(), link);
        }
    }
}
