//! Where Intel's Open Image Denoise is found: the library is not part of the program, which builds and runs without it.
//!
//! In the folder that `BHS_OIDN_DIR` names, and nowhere else, if it is set; else where the set-up has put it (`setup/oidn.py`), or among the system's
//! libraries.

use super::oidn::Library;
use std::fmt;
use std::path::{Path, PathBuf};

/// The name of the library.
const NAME: &str = if cfg!(target_os = "macos") { "libOpenImageDenoise.2.dylib" } else { "libOpenImageDenoise.so.2" };

/// The variable of the environment that names its folder.
const VARIABLE: &str = "BHS_OIDN_DIR";

/// Where the set-up says which version it fetches.
const PINNED: &str = include_str!("../../setup/oidn.txt");

/// Folders where systems keep libraries that their loader does not look for.
const SYSTEM: &[&str] = if cfg!(target_os = "macos") { &["/opt/homebrew/lib", "/usr/local/lib"] } else { &[] };

/// The library cannot be used: why, and how to get it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Missing {
    /// What was wrong with each place where it was looked for.
    tried: Vec<(PathBuf, String)>,
    /// Whether [`VARIABLE`] named the place.
    is_named: bool,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Intel's Open Image Denoise, which takes the noise out of pictures, cannot be loaded")?;
        for (path, why) in &self.tried {
            write!(f, "\n  `{}`: {why}", path.display())?;
        }
        if self.is_named {
            return write!(
                f,
                "\n{VARIABLE} has to name the folder of {NAME}, version 2; without it bhs looks where its set-up puts it"
            );
        }
        write!(
            f,
            "\nto get it (57 MB, once), start bhs by the script of its folder: `./bhs denoise ...` or `./bhs render ... --denoise`; or\n  \
             Debian 13: apt install libopenimagedenoise-dev      Fedora: dnf install oidn-libs      Arch: pacman -S openimagedenoise\n  \
             macOS: brew install open-image-denoise      elsewhere: set {VARIABLE} to the folder of {NAME}"
        )
    }
}

/// Loads the library.
///
/// # Errors
/// That there is none, and how to get it.
pub fn load() -> Result<Library, Missing> {
    let named = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty());
    let is_named = named.is_some();
    let places = match named {
        Some(folder) => vec![PathBuf::from(folder).join(NAME)],
        None => places(),
    };
    let mut tried = Vec::new();
    for path in places {
        // A name alone is looked for by the loader.
        if path.components().count() > 1 && !path.exists() {
            tried.push((path, "there is no such file".to_owned()));
            continue;
        }
        match Library::open(&path) {
            Ok(library) => return Ok(library),
            Err(why) => tried.push((path, why)),
        }
    }
    Err(Missing { tried, is_named })
}

/// Where it may be, in the order in which it is looked for.
fn places() -> Vec<PathBuf> {
    let fetched = Path::new(".deps").join(format!("oidn-{}", pinned_version())).join("lib").join(NAME);
    // Of the folder in which bhs was built.
    let mut places = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(&fetched)];
    places.extend(SYSTEM.iter().map(|folder| Path::new(folder).join(NAME)).filter(|path| path.exists()));
    places.push(NAME.into());
    places
}

/// The version that the set-up fetches.
fn pinned_version() -> &'static str {
    PINNED.split_once("==").and_then(|(_, rest)| rest.split_whitespace().next()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_set_up_and_the_program_mean_the_same_place() {
        assert!(pinned_version().starts_with("2."), "{}", pinned_version());
        assert!(places()[0].ends_with(format!(".deps/oidn-{}/lib/{NAME}", pinned_version())), "{:?}", places());
        assert_eq!(places().last().map(PathBuf::as_path), Some(Path::new(NAME)));
        let script = include_str!("../../setup/oidn.py");
        assert!(script.contains(NAME) && script.contains(VARIABLE) && script.contains(r#"install_wheel("oidn""#));
    }

    #[test]
    fn who_has_no_library_is_told_how_to_get_it() {
        let missing = Missing { tried: vec![("x/y".into(), "there is no such file".into())], is_named: false };
        let said = missing.to_string();
        for word in ["`x/y`: there is no such file", "./bhs denoise", "57 MB", "apt install", VARIABLE] {
            assert!(said.contains(word), "{said}");
        }
        assert!(!Missing { is_named: true, ..missing }.to_string().contains("apt"));
    }
}
