//! Measures how accurate the curved integrators are, and writes tables (CSV) and charts (SVG) to `docs/accuracy/`;
//! `docs/accuracy.md` explains them.
//!
//!     cargo run --release --example accuracy                 everything, about a quarter of an hour on two cores
//!     cargo run --release --example accuracy orbits          orbits against the 30-digit reference, seconds
//!     cargo run --release --example accuracy hits            hits on the dragon, a minute
//!     cargo run --release --example accuracy footprints      pictures with footprints of several sizes, the rest
//!
//! Needs the meshes of the scenes: `./bhs check scenes/gold_dragon.bhs` fetches them.

mod footprints;
mod hits;
mod orbits;

use anyhow::{Context, Result, bail};
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::Registry;
use std::path::{Path, PathBuf};

fn main() -> Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let all = [("orbits", orbits::measure as fn() -> Result<()>), ("hits", hits::measure), ("footprints", footprints::measure)];
    if let Some(unknown) = wanted.iter().find(|w| all.iter().all(|(name, _)| name != w)) {
        bail!("`{unknown}` is not one of orbits, hits, footprints");
    }
    for (name, measure) in all {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            measure().with_context(|| format!("while measuring {name}"))?;
        }
    }
    Ok(())
}

/// Writes a file of `docs/accuracy/`.
#[allow(clippy::print_stderr, reason = "what a measurement tells")]
fn write(name: &str, text: &str) -> Result<()> {
    let path = root().join("docs/accuracy").join(name);
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    eprintln!("{}", path.display());
    Ok(())
}

/// Shows a table and writes it to `docs/accuracy/NAME.csv`.
#[allow(clippy::print_stderr, reason = "what a measurement tells")]
fn finish(table: &bhs::bench::table::Table, name: &str) -> Result<()> {
    eprintln!("\n{}", table.to_markdown());
    write(&format!("{name}.csv"), &table.to_csv())
}

/// The project's root folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One of the project's scenes, built.
fn scene(name: &str, overrides: &Overrides) -> Result<BuiltScene> {
    let path: PathBuf = root().join("scenes").join(format!("{name}.bhs"));
    let mut sources = SourceMap::new();
    match lang::load(&path, &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => Ok(built),
        Err(found) => bail!("{}", bhs::report::render(&found, &sources, false)),
    }
}
