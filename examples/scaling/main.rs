//! Measures how bhs's time and memory grow with the work, and what a scene does not pay for. Prints Markdown tables, for
//! `docs/performance.md`.
//!
//!     cargo build --release --bin bhs --example flat_only && cargo run --release --example scaling            everything
//!     cargo run --release --example scaling triangles     cost of a ray against the number of triangles, 11k to 3.5 million
//!     cargo run --release --example scaling linear        time against pixels, samples and threads
//!     cargo run --release --example scaling load          time until a scene is ready, and memory
//!     cargo run --release --example scaling features      what each feature costs
//!     cargo run --release --example scaling flat          flat scenes with and without curved light in the program
//!
//! Needs the meshes of the scenes (`./bhs check scenes/gold_dragon.bhs` fetches them), `load` needs the program beside it, `flat` the
//! example `flat_only`. Each takes one to three minutes on two cores that have nothing else to do.

mod features;
mod flat;
mod linear;
mod load;
mod timer;
mod triangles;

use anyhow::{Context, Result, bail};
use bhs::bench::clock::median;
use bhs::bench::table::Table;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::Registry;
use std::path::{Path, PathBuf};

fn main() -> Result<()> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    if wanted == [flat::WORKER] {
        return timer::answer(&Registry::builtin());
    }
    let all = [
        ("triangles", triangles::measure as fn() -> Result<()>),
        ("linear", linear::measure),
        ("load", load::measure),
        ("features", features::measure),
        ("flat", flat::measure),
    ];
    if let Some(unknown) = wanted.iter().find(|w| all.iter().all(|(name, _)| name != w)) {
        bail!("`{unknown}` is not one of {}", all.map(|(name, _)| name).join(", "));
    }
    for (name, measure) in all {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            measure().with_context(|| format!("while measuring {name}"))?;
        }
    }
    Ok(())
}

/// Shows a table.
#[allow(clippy::print_stdout, reason = "what this program is for")]
fn show(title: &str, table: &Table) {
    println!("\n{title}\n\n{}", table.to_markdown());
}

/// The project's root folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text of one of the project's scenes, which reads its files from anywhere.
fn text(name: &str) -> Result<String> {
    let folder = root().join("scenes");
    let path = folder.join(format!("{name}.bhs"));
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let folder = folder.display();
    Ok(text.replace("Include \"", &format!("Include \"{folder}/")).replace("\"meshes/", &format!("\"{folder}/meshes/")))
}

/// A scene, built from its text.
fn build(text: &str, overrides: &Overrides) -> Result<BuiltScene> {
    let mut sources = SourceMap::new();
    match lang::load_text("scene.bhs", text, &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => Ok(built),
        Err(found) => bail!("{}", bhs::report::render(&found, &sources, false)),
    }
}

/// Another program of this build.
fn program(name: &str) -> Result<PathBuf> {
    let own = std::env::current_exe()?;
    let examples = own.parent().context("no folder")?;
    let found = [examples.join(name), examples.join("..").join(name)].into_iter().find(|p| p.exists());
    found.with_context(|| format!("`{name}` has not been built"))
}

/// Medians of what `measures` yield, each asked `rounds` times, in turn, so that what else the machine does falls on all alike.
fn medians<T>(rounds: usize, of: &mut [T], mut measure: impl FnMut(&mut T) -> Result<f64>) -> Result<Vec<f64>> {
    let mut found = vec![Vec::new(); of.len()];
    for _ in 0..rounds {
        for (one, found) in of.iter_mut().zip(&mut found) {
            found.push(measure(one)?);
        }
    }
    Ok(found.iter().map(|f| median(f)).collect())
}
