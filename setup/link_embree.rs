//! Build script of every package with executables that link Embree: tells Cargo where the library is.
//!
//! `setup/setup.py` writes the folder into `.cargo/config.toml` as `BHS_EMBREE_DIR`. Where the linker and the loader find
//! Embree by themselves there is no such variable, and nothing to say here.
//!
//! Linking: the search path printed here reaches every package that depends on this one.
//! Running under Cargo: `cargo run`, `cargo test`, `cargo bench` and documentation tests put search paths that lie inside the
//! target folder on the loader's path, in every package; hence the links in `OUT_DIR`.
//! Running without Cargo: the rpath, in this package's own executables. `BHS_RPATH` names other folders in its place, from the executable's own
//! (`$ORIGIN`, on macOS `@loader_path`): programs for other machines, which bring Embree along (`setup/release.py`).
//! Windows knows no such paths: there the DLL files have to lie beside the executable or in `PATH`.
//! Flags in `.cargo/config.toml` would do all this too, but are lost whenever someone sets `RUSTFLAGS`.

#![allow(clippy::print_stdout, clippy::print_stderr)] // a build script talks to Cargo this way

mod commit;

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-env-changed=BHS_EMBREE_DIR");
    println!("cargo::rerun-if-env-changed=BHS_RPATH");
    println!("cargo::rerun-if-env-changed=BINDGEN_EXTRA_CLANG_ARGS");
    if env::var_os("CARGO_FEATURE_EMBREE").is_some() && env::var_os("BINDGEN_EXTRA_CLANG_ARGS").is_none() {
        println!("cargo::warning=this checkout is not set up for building; run ./bhs in it once");
    }
    if env::var("CARGO_PKG_NAME").is_ok_and(|name| name == "bhs") {
        commit::tell(Path::new(&env::var_os("CARGO_MANIFEST_DIR").expect("Cargo sets CARGO_MANIFEST_DIR")));
    }
    let Some(embree) = env::var_os("BHS_EMBREE_DIR").map(PathBuf::from) else { return Ok(()) };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("Cargo sets OUT_DIR"));

    for entry in fs::read_dir(&embree).inspect_err(|_| eprintln!("BHS_EMBREE_DIR is {}", embree.display()))? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        let text = text.strip_prefix("lib").unwrap_or(&text);
        if text.starts_with("embree4") || text.starts_with("tbb") {
            let link = out.join(&name);
            if link.is_symlink() || link.exists() {
                fs::remove_file(&link)?;
            }
            refer(&embree.join(&name), &link)?;
        }
    }

    println!("cargo::rustc-link-search=native={}", out.display());
    if env::var("CARGO_CFG_WINDOWS").is_err() {
        let folders = env::var("BHS_RPATH").unwrap_or_else(|_| embree.display().to_string());
        // What is searched is one flag each: macOS has no list of them.
        for folder in folders.split(':') {
            println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
        }
    }
    Ok(())
}

/// Makes `link` another name of `file`.
#[cfg(unix)]
fn refer(file: &Path, link: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(file, link)
}

/// Makes `link` a copy of `file`: symbolic links are not for everybody here.
#[cfg(not(unix))]
fn refer(file: &Path, link: &Path) -> io::Result<()> {
    fs::copy(file, link).map(|_| ())
}
