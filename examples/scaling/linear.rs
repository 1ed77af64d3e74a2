//! Time against pixels, samples and threads.

use crate::{build, medians, show, text};
use anyhow::{Context, Result};
use bhs::bench::table::Table;
use bhs::lang::Overrides;
use bhs::render::render_quietly;
use std::time::Instant;

const ROUNDS: usize = 5;

/// One way to render.
struct Case {
    size: [u32; 2],
    samples: u32,
    threads: usize,
}

pub fn measure() -> Result<()> {
    let scene = text("cornell_hole")?;
    let processors = std::thread::available_parallelism()?.get();
    let (base, samples) = ([160, 120], 8);
    let scaled = |by: u32| base.map(|n| n * by);
    let by = |size: [u32; 2], samples, threads| Case { size, samples, threads };
    let groups: [(&str, Vec<Case>); 3] = [
        ("pixels", [1, 2, 4].map(|n| by(scaled(n), samples, processors)).into()),
        ("samples", [1, 2, 4, 8].map(|n| by(base, samples * n, processors)).into()),
        ("threads", (1..=processors).map(|n| by(scaled(2), samples, n)).collect()),
    ];
    for (what, cases) in groups {
        let mut ready = Vec::new();
        for case in cases {
            let overrides = Overrides { resolution: Some(case.size), spp: Some(case.samples), ..Default::default() };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(case.threads).build().context("cannot start the threads")?;
            ready.push((build(&scene, &overrides)?, pool, case));
        }
        let seconds = medians(ROUNDS, &mut ready, |(built, pool, _)| {
            let start = Instant::now();
            std::hint::black_box(pool.install(|| render_quietly(built)));
            Ok(start.elapsed().as_secs_f64())
        })?;
        let mut table = Table::new(&["pixels", "samples", "threads", "seconds", "ns a sample and thread", "over the first row"]);
        let cost = |i: usize| {
            let case = &ready[i].2;
            let paths = f64::from(case.size[0]) * f64::from(case.size[1]) * f64::from(case.samples);
            1e9 * seconds[i] * case.threads as f64 / paths
        };
        for (i, (_, _, case)) in ready.iter().enumerate() {
            table.row(&[
                format!("{} x {}", case.size[0], case.size[1]),
                case.samples.to_string(),
                case.threads.to_string(),
                format!("{:.2}", seconds[i]),
                format!("{:.0}", cost(i)),
                format!("{:.3}", cost(i) / cost(0)),
            ]);
        }
        show(&format!("`cornell_hole` against {what}: linear where the last column is 1"), &table);
    }
    Ok(())
}
