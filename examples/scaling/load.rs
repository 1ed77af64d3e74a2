//! How long it takes until a scene is ready, and how much memory a large picture of it takes.

use crate::{build, medians, program, root, show, text};
use anyhow::{Context, Result, anyhow, ensure};
use bhs::bench::table::Table;
use bhs::lang::Overrides;
use std::process::Command;
use std::time::Instant;

const ROUNDS: usize = 7;

pub fn measure() -> Result<()> {
    let mesh = root().join("scenes/meshes/dragon_vrip.ply.gz");
    let packed = std::fs::read(&mesh).with_context(|| format!("cannot read {}", mesh.display()))?;
    let scene = text("gold_dragon")?;
    let flat: String = scene.lines().filter(|l| !l.starts_with("BlackHole")).map(|l| format!("{l}\n")).collect();
    let mut tasks = ["parse `dragon_vrip.ply.gz`", "`gold_dragon` ready to render", "the same without the hole"].to_vec();
    let seconds = medians(ROUNDS, &mut tasks, |task| {
        let start = Instant::now();
        if task.starts_with("parse") {
            let read = bhs_shapes::ply::read(&packed).map_err(|why| anyhow!(why))?;
            std::hint::black_box(read.mesh.triangles.len());
        } else {
            let text = if task.ends_with("hole") { &flat } else { &scene };
            std::hint::black_box(build(text, &Overrides::default())?.load.triangles);
        }
        Ok(start.elapsed().as_secs_f64())
    })?;
    let mut table = Table::new(&["", "value"]);
    for (task, seconds) in tasks.iter().zip(seconds) {
        table.row(&[(*task).to_owned(), format!("{seconds:.3} s")]);
    }
    // Memory is that of a process of its own.
    let folder = std::env::temp_dir().join(format!("bhs-scaling-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let stats = folder.join("stats.json");
    for name in ["gold_dragon", "cornell_box"] {
        let mut command = Command::new(program("bhs")?);
        command.arg("render").arg(root().join(format!("scenes/{name}.bhs")));
        command.args(["--resolution", "1024x1024", "--spp", "1", "--quiet"]);
        command.arg("-o").arg(folder.join("picture.exr")).arg("--stats").arg(&stats);
        ensure!(command.status()?.success(), "{command:?} failed");
        let found: serde_json::Value = serde_json::from_slice(&std::fs::read(&stats)?)?;
        let peak = found["peak_memory_bytes"].as_f64().unwrap_or(f64::NAN);
        table.row(&[format!("peak memory of `{name}` at 1024 x 1024"), format!("{:.0} MB", peak / 1e6)]);
    }
    std::fs::remove_dir_all(&folder)?;
    show("Loading (seconds on the wall's clock) and memory", &table);
    Ok(())
}
