//! Hits on the dragon of `scenes/gold_dragon.bhs` against those of the closed form with very short chords. What they cost is for
//! `bhs bench` to say.

use anyhow::Result;
use bhs::bench::integrators::{Candidate, TOLERANCES, candidates};
use bhs::bench::rays::{arrivals, bounce_rays, camera_rays, diagonal, differences, truth};
use bhs::bench::table::Table;
use bhs::lang::Overrides;
use bhs::plot::{Chart, Series};

/// Rays of each kind.
pub const RAYS: usize = 40_000;

pub fn measure() -> Result<()> {
    let built = crate::scene("gold_dragon", &Overrides::default())?;
    let world = &built.scene.world;
    let diagonal = diagonal(world);
    let camera = camera_rays(&built, RAYS);
    let bounce = bounce_rays(&built, &camera);
    for (kind, rays) in [("camera", camera), ("bounce", bounce)] {
        let (true_ends, _) = arrivals(world, &truth(world), &rays);
        let mut table = Table::new(&[
            "integrator",
            "step or tolerance",
            "median",
            "99 %",
            "worst",
            "worst across the ray",
            "other triangle",
            "elsewhere",
            "queries a ray",
        ]);
        let mut lines: Vec<Series> = Vec::new();
        for Candidate { name, shown, setting, integrator } in candidates(diagonal) {
            let (ends, counters) = arrivals(world, &*integrator, &rays);
            let d = differences(world, &ends, &true_ends);
            let distance = d.distance;
            let [median, p99, worst] = distance.cells();
            let shares = [d.other_triangle, d.elsewhere].map(|s| format!("{:.3} %", 100.0 * s));
            let [other, elsewhere] = shares;
            let queries = format!("{:.1}", counters.queries as f64 / rays.len() as f64);
            let across = format!("{:.1e}", d.worst_across);
            table.row(&[name.to_owned(), shown, median, p99, worst, across, other, elsewhere, queries]);
            let Some(setting) = setting.filter(|_| name != "exact") else { continue };
            for (what, value) in [("median", distance.median), ("99 %", distance.p99), ("worst", distance.worst)] {
                let line = format!("{name}, {what}");
                match lines.iter_mut().find(|l| l.name == line) {
                    Some(l) => l.points.push([setting, value]),
                    None => lines.push(Series { name: line, points: vec![[setting, value]], dashed: false }),
                }
            }
        }
        lines.push(Series { name: "error = tolerance".into(), points: TOLERANCES.map(|t| [t, t]).to_vec(), dashed: true });
        crate::finish(&table, &format!("hits_{kind}"))?;
        let chart = Chart {
            title: format!("Hits of {kind} rays on the gold dragon"),
            x: "step (rad) or tolerance / diagonal".into(),
            y: "distance from the true hit / diagonal".into(),
            series: lines,
        };
        crate::write(&format!("hits_{kind}.svg"), &chart.to_svg())?;
    }
    Ok(())
}
