//! `--root`: the folder that a scene may not leave.

use super::resolve;
use anyhow::{Context, Result, bail};
use std::path::{Component, Path, PathBuf};

/// A folder that confines what a scene reads and writes, after all links are followed.
///
/// Hard links cannot be told from files of the folder; who may make them there is not confined by this.
#[derive(Clone, Debug)]
pub struct Root {
    given: PathBuf,
    real: PathBuf,
}

impl Root {
    /// The folder `given`.
    ///
    /// # Errors
    /// If there is no such folder.
    pub fn new(given: &Path) -> Result<Self> {
        let real = given.canonicalize().with_context(|| format!("cannot use `{}` as the root", given.display()))?;
        if !real.is_dir() {
            bail!("cannot use `{}` as the root: it is not a folder", given.display());
        }
        Ok(Self { given: given.to_owned(), real })
    }

    /// Makes sure that a file which a scene names lies in the folder, whether or not it is there.
    ///
    /// # Errors
    /// That it does not, in words.
    pub fn admit(&self, path: &Path) -> Result<(), String> {
        match self.holds(path) {
            true => Ok(()),
            false => Err(format!("it lies outside of `{}`, the folder of --root", self.given.display())),
        }
    }

    /// Makes sure of a file that the command line names: it may lie anywhere, but no link may lead to it out of the folder.
    ///
    /// # Errors
    /// That one does, in words.
    pub fn admit_named(&self, path: &Path) -> Result<(), String> {
        let written = std::path::absolute(path).map(|p| without_dots(&p)).unwrap_or_else(|_| path.to_owned());
        let root = std::path::absolute(&self.given).map(|p| without_dots(&p)).unwrap_or_else(|_| self.given.clone());
        if written.starts_with(root) || written.starts_with(&self.real) { self.admit(path) } else { Ok(()) }
    }

    fn holds(&self, path: &Path) -> bool {
        if let Ok(real) = resolve(path) {
            return real.starts_with(&self.real);
        }
        // It cannot be there. What is said about it depends on the last folder of its path that is.
        let real = path.ancestors().skip(1).find_map(|folder| {
            if folder.as_os_str().is_empty() { Path::new(".").canonicalize().ok() } else { folder.canonicalize().ok() }
        });
        real.is_some_and(|real| real.starts_with(&self.real))
    }
}

/// A path without `.` and `..`, links not followed.
fn without_dots(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_and_dots_do_not_lead_out() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir_all(at("root/sub")).unwrap();
        std::fs::create_dir(at("rootbeer")).unwrap();
        std::fs::write(at("secret"), "").unwrap();
        std::fs::write(at("root/file"), "").unwrap();
        symlink("../secret", at("root/link")).unwrap();
        symlink("../missing", at("root/dangling")).unwrap();
        symlink("..", at("root/up")).unwrap();
        symlink("sub/../file", at("root/fine")).unwrap();
        let root = Root::new(&at("root")).unwrap();
        for inside in ["root/file", "root/sub/../file", "root/fine", "root/new", "root/none/new", "root/up/root/file"] {
            assert_eq!(root.admit(&at(inside)), Ok(()), "{inside}");
        }
        for outside in ["secret", "root/../secret", "root/link", "root/dangling", "root/up/secret", "rootbeer/x", "none/x"] {
            assert!(root.admit(&at(outside)).is_err_and(|e| e.contains("--root")), "{outside}");
        }
        assert!(root.admit_named(&at("other.exr")).is_ok() && root.admit_named(&at("root/x.exr")).is_ok());
        assert!(root.admit_named(&at("root/link")).is_err() && root.admit_named(&at("root/up/x.exr")).is_err());
        assert!(Root::new(&at("secret")).is_err() && Root::new(&at("none")).is_err());
    }
}
