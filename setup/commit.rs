//! Tells the program which commit it is built from, and when that was made: `bhs --version --verbose`.
//!
//! The date is the commit's, not that of the build: the same sources make the same program.

use std::path::Path;
use std::process::Command;

/// Sets `BHS_COMMIT` and `BHS_COMMIT_DATE` for the compiler; nothing where the folder `root` is no repository of git by itself.
pub fn tell(root: &Path) {
    let git = |args: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(args).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // An archive that was unpacked within another repository is not at its top.
    if git(&["rev-parse", "--show-prefix"]).as_deref() != Some("") {
        return;
    }
    if let Some((commit, date)) = git(&["log", "-1", "--format=%H %cI"]).as_deref().and_then(|line| line.split_once(' ')) {
        println!("cargo::rustc-env=BHS_COMMIT={commit}");
        println!("cargo::rustc-env=BHS_COMMIT_DATE={date}");
    }
    // What changes when another commit is checked out or made: the log of that, or without one all branches.
    let place = |name: &str| git(&["rev-parse", "--git-path", name]).map(|path| root.join(path)).filter(|path| path.exists());
    let log = place("logs/HEAD");
    let branches = ["HEAD", "refs/heads", "packed-refs"].into_iter().filter(|_| log.is_none()).filter_map(place);
    for path in log.iter().cloned().chain(branches) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
}
