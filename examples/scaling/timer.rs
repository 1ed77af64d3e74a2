//! A process that renders `cornell_box` whenever it is asked to, and says what that took.

use anyhow::{Result, bail};
use bhs::bench::clock::processor_seconds;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use std::io::{BufRead, Write};
use std::path::Path;

/// For each line of standard input, renders once and answers with the seconds of processor time.
pub fn answer(registry: &Registry) -> Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell_box.bhs");
    let overrides = Overrides { resolution: Some([128, 128]), spp: Some(16), ..Default::default() };
    let mut sources = SourceMap::new();
    let built = match lang::load(&path, registry, &overrides, &mut sources) {
        Ok(built) => built,
        Err(found) => bail!("{}", bhs::report::render(&found, &sources, false)),
    };
    bhs::render::render_quietly(&built);
    for line in std::io::stdin().lock().lines() {
        line?;
        let start = processor_seconds();
        std::hint::black_box(bhs::render::render_quietly(&built));
        let mut out = std::io::stdout().lock();
        writeln!(out, "{}", processor_seconds() - start)?;
        out.flush()?;
    }
    Ok(())
}
