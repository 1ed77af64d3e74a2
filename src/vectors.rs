//! Programs for processors of several levels: a download brings one for each, and the one that is started hands over to the best that the processor runs.
//!
//! The levels are those of the x86-64 psABI. `bin/bhs` is built for the lowest; the others lie in `lib/bhs`, as `bhs-x86-64-v3`. Inner loops are inlined
//! through all of a render, so that the program as a whole is what is built for a level. All of them compute the same bits: arithmetic of lanes is one
//! operation after the other ([`bhs_core::real::Real::times_plus`]). What is built for one processor alone (`./bhs`) has no others beside it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The variable of the environment that names a level, in place of the best.
pub const VARIABLE: &str = "BHS_VECTORS";

/// A level of processors.
struct Level {
    name: &'static str,
    /// The widest vectors.
    vectors: &'static str,
    /// Whether this program was built for all of its features.
    is_built_for: bool,
    /// The features that the processor does not have.
    lacks: fn() -> Vec<&'static str>,
}

/// A level by its name, its vectors and its features.
macro_rules! level {
    ($name:literal, $vectors:literal, $($feature:tt)*) => {
        Level {
            name: $name,
            vectors: $vectors,
            is_built_for: cfg!(all($(target_feature = $feature),*)),
            lacks: || {
                #[cfg(target_arch = "x86_64")]
                let lacking = [$(($feature, std::arch::is_x86_feature_detected!($feature))),*];
                #[cfg(not(target_arch = "x86_64"))]
                let lacking = [$(($feature, false)),*];
                lacking.into_iter().filter(|(_, is_there)| !is_there).map(|(name, _)| name).collect()
            },
        }
    };
}

/// From the lowest. A processor of a level is one of all below it.
const LEVELS: [Level; 3] = [
    level!("x86-64-v2", "sse4.2", "sse3" "ssse3" "sse4.1" "sse4.2" "popcnt"),
    level!("x86-64-v3", "avx2", "avx" "avx2" "fma" "f16c" "bmi1" "bmi2" "lzcnt" "movbe"),
    level!("x86-64-v4", "avx512", "avx512f" "avx512bw" "avx512cd" "avx512dq" "avx512vl"),
];

/// How many of [`LEVELS`] this program needs of its processor.
const NEEDED: usize = {
    let mut count = 0;
    while count < LEVELS.len() && LEVELS[count].is_built_for {
        count += 1;
    }
    count
};

/// The level that this program was built for: `x86-64-v3`, or the name of the architecture where it has no levels.
pub fn own() -> &'static str {
    match NEEDED {
        0 if cfg!(target_arch = "x86_64") => "x86-64",
        0 => std::env::consts::ARCH,
        n => LEVELS[n - 1].name,
    }
}

/// The widest vectors that this program was built for.
fn own_vectors() -> &'static str {
    match NEEDED {
        0 if cfg!(target_feature = "sse2") => "sse2",
        0 if cfg!(target_feature = "neon") => "neon",
        0 => "none",
        n => LEVELS[n - 1].vectors,
    }
}

/// Of what the code that runs was chosen, for [`told`].
static CHOSEN_AMONG: OnceLock<Vec<String>> = OnceLock::new();

/// One of `there`, from the lowest, for this processor: the one that `asked` names, else the best.
///
/// # Errors
/// What is wrong with `asked`, or that the processor runs none of them.
pub fn choose<'a>(asked: Option<&str>, there: &[&'a str]) -> Result<&'a str, String> {
    CHOSEN_AMONG.get_or_init(|| there.iter().map(|name| (*name).to_owned()).collect());
    let lacked = |name: &str| match LEVELS.iter().position(|level| level.name == name) {
        Some(last) => LEVELS[..=last].iter().flat_map(|level| (level.lacks)()).collect(),
        None => Vec::new(),
    };
    among(asked, there, &lacked)
}

/// As [`choose`], of a processor that lacks what `lacked` says for each level.
fn among<'a>(asked: Option<&str>, there: &[&'a str], lacked: &dyn Fn(&str) -> Vec<&'static str>) -> Result<&'a str, String> {
    let Some(asked) = asked else {
        let best = there.iter().rev().find(|name| lacked(name).is_empty());
        return best.copied().ok_or_else(|| {
            let least = there.first().copied().unwrap_or_default();
            format!("this processor lacks {}, which bhs needs: it is built for {least}", lacked(least).join(", "))
        });
    };
    let Some(found) = there.iter().find(|name| **name == asked) else {
        return Err(format!("{VARIABLE} is `{asked}`; this bhs has code for {}", there.join(", ")));
    };
    match lacked(found).as_slice() {
        [] => Ok(found),
        lacked => Err(format!("{VARIABLE} is `{asked}`, for which this processor lacks {}", lacked.join(", "))),
    }
}

/// What [`VARIABLE`] says, if anything.
pub fn asked() -> Option<String> {
    std::env::var_os(VARIABLE).filter(|value| !value.is_empty()).map(|value| value.to_string_lossy().into_owned())
}

/// The levels of which there are programs beside `program`, which is built for the first `needed` of [`LEVELS`], and their files, its own included; none beside
/// one that was built for one processor.
fn others(program: &Path, needed: usize) -> Vec<(&'static str, PathBuf)> {
    let Some(folder) = program.parent() else { return Vec::new() };
    let ending = std::env::consts::EXE_SUFFIX;
    // `bin` has the program that is started, `lib/bhs` those that it hands over to.
    let (lib, lowest, first) = if folder.ends_with("lib/bhs") {
        (folder.to_owned(), 1, folder.join(format!("../../bin/bhs{ending}")))
    } else {
        (folder.join("../lib/bhs"), needed, program.to_owned())
    };
    let Some(level) = lowest.checked_sub(1).map(|last| &LEVELS[last]) else { return Vec::new() };
    let first = (level.name, first);
    let rest = LEVELS.iter().skip(lowest).map(|level| (level.name, lib.join(format!("bhs-{}{ending}", level.name))));
    let found: Vec<_> = std::iter::once(first).chain(rest).filter(|(_, path)| path.is_file()).collect();
    if found.len() > 1 { found } else { Vec::new() }
}

/// Runs the program of the level that suits the processor in place of this one, if it is another: `Some` exit code where that takes a program of its own.
///
/// # Errors
/// The level that is asked for is not there, or not for this processor; or the program cannot be started.
pub fn hand_over(words: &[OsString]) -> Result<Option<u8>, String> {
    let asked = asked();
    let found = std::env::current_exe().map(|program| others(&program, NEEDED)).unwrap_or_default();
    let mut names: Vec<&str> = found.iter().map(|(name, _)| *name).collect();
    if !names.contains(&own()) {
        // Built for the processor at hand, or for one level alone.
        names = vec![own()];
    }
    let name = choose(asked.as_deref(), &names)?;
    match found.iter().find(|(level, _)| *level == name) {
        Some((_, path)) if name != own() => replace(path, words).map(Some),
        _ => Ok(None),
    }
}

#[cfg(unix)]
fn replace(path: &Path, words: &[OsString]) -> Result<u8, String> {
    use std::os::unix::process::CommandExt;
    let [name, rest @ ..] = words else { return Err("there is no command line".to_owned()) };
    let error = Command::new(path).arg0(name).args(rest).exec();
    Err(format!("cannot start `{}`: {error}", path.display()))
}

#[cfg(not(unix))]
fn replace(path: &Path, words: &[OsString]) -> Result<u8, String> {
    let status = Command::new(path).args(words.iter().skip(1)).status();
    let status = status.map_err(|error| format!("cannot start `{}`: {error}", path.display()))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(101))
}

/// Which vector code runs, and why: for `bhs --version --verbose`.
pub fn told() -> String {
    let why = match (asked(), CHOSEN_AMONG.get()) {
        (Some(_), _) => format!("{VARIABLE} asks for it"),
        (None, Some(names)) if names.len() > 1 => format!("the best for this processor of {}", names.join(", ")),
        _ => "all that this program was built for".to_owned(),
    };
    format!("{} ({}): {why}", own_vectors(), own())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [&str; 3] = ["x86-64-v2", "x86-64-v3", "x86-64-v4"];

    /// A processor of 2013, by what it lacks.
    fn haswell(name: &str) -> Vec<&'static str> {
        if name == "x86-64-v4" { vec!["avx512f", "avx512vl"] } else { Vec::new() }
    }

    #[test]
    fn the_best_that_the_processor_runs_is_taken_or_the_one_that_is_asked_for() {
        assert_eq!(among(None, &ALL, &haswell).unwrap(), "x86-64-v3");
        assert_eq!(among(None, &ALL, &|_| Vec::new()).unwrap(), "x86-64-v4");
        assert_eq!(among(None, &ALL[..1], &haswell).unwrap(), "x86-64-v2");
        assert_eq!(among(Some("x86-64-v2"), &ALL, &haswell).unwrap(), "x86-64-v2");
    }

    #[test]
    fn what_the_processor_lacks_is_named() {
        let error = among(Some("x86-64-v4"), &ALL, &haswell).unwrap_err();
        assert_eq!(error, "BHS_VECTORS is `x86-64-v4`, for which this processor lacks avx512f, avx512vl");
        let error = among(Some("avx2"), &ALL, &haswell).unwrap_err();
        assert_eq!(error, "BHS_VECTORS is `avx2`; this bhs has code for x86-64-v2, x86-64-v3, x86-64-v4");
        let error = among(None, &ALL, &|_| vec!["popcnt"]).unwrap_err();
        assert_eq!(error, "this processor lacks popcnt, which bhs needs: it is built for x86-64-v2");
    }

    #[test]
    fn this_processor_has_what_this_program_is_built_for() {
        for level in &LEVELS[..NEEDED] {
            assert_eq!((level.lacks)(), Vec::<&str>::new(), "{}", level.name);
        }
        assert_eq!(choose(None, &[own()]), Ok(own()));
    }

    #[test]
    fn a_folder_with_programs_of_several_levels_is_found_from_each_of_them() {
        let root = tempfile::tempdir().expect("a folder");
        let root = root.path();
        for folder in ["bin", "lib/bhs"] {
            std::fs::create_dir_all(root.join(folder)).expect("folders");
        }
        let ending = std::env::consts::EXE_SUFFIX;
        let [bin, high] = ["bin/bhs", "lib/bhs/bhs-x86-64-v4"].map(|name| root.join(format!("{name}{ending}")));
        std::fs::write(&bin, "").expect("a file");
        assert!(others(&bin, 1).is_empty());
        std::fs::write(&high, "").expect("a file");
        // A program for this very processor is not one of them, wherever it lies.
        assert!(others(&bin, 3).is_empty());
        for (program, needed) in [(&bin, 1), (&high, 3)] {
            let found = others(program, needed);
            let files: Vec<_> = found.iter().map(|(_, path)| path.canonicalize().expect("a file")).collect();
            assert_eq!(files, [&bin, &high].map(|path| path.canonicalize().expect("a file")));
            assert_eq!((found[0].0, found[1].0), ("x86-64-v2", "x86-64-v4"));
        }
    }
}
