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
mod table;

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
fn write(name: &str, text: &str) -> Result<()> {
    let path = root().join("docs/accuracy").join(name);
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    eprintln!("{}", path.display());
    Ok(())
}

/// The project's root folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One of the project's scenes, built.
fn scene(name: &str, overrides: &Overrides) -> Result<BuiltScene> {
    let path: PathBuf = root().join("scenes").join(format!("{name}.bhs"));
    let mut sources = SourceMap::new();
    match lang::load(&path.to_string_lossy(), &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => Ok(built),
        Err(found) => bail!("{}", bhs::report::render(&found, &sources, false)),
    }
}

/// Processor time that this program has taken so far on all its threads (s), which other programs disturb less than the clock on the
/// wall; where the system does not tell, the time since the first call.
fn processor_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    let elapsed = START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64();
    // proc_pid_stat(5): fields 14 and 15, in hundredths of a second; names in field 2 may hold spaces.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = stat.rsplit_once(')').map(|(_, rest)| rest.split_whitespace().skip(11).take(2).map(str::parse::<f64>));
    match ticks.and_then(|t| t.collect::<Result<Vec<f64>, _>>().ok()) {
        Some(times) if times.len() == 2 => 0.01 * (times[0] + times[1]),
        _ => elapsed,
    }
}
