//! Integrators on a scene's own rays: time, steps and queries a ray against the error of its end.

use super::clock::{median, processor_seconds};
use super::rays::{MOST_STEPS, arrivals, bounce_rays, camera_rays, diagonal, differences, truth};
use super::table::Table;
use super::{Measured, Summary, Tradeoff, equal_error, pareto_front, series};
use crate::lang::BuiltScene;
use crate::plot::Chart;
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::spacetime::Class;
use bhs_engine::integrator::Integrator;
use bhs_engine::transport::BATCH;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::{Adaptive, Exact, MicroSteps, Rk4, Straight};

/// Steps of `rk4` (rad).
pub const STEPS: [f64; 6] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

/// Steps of the baseline (rad): it takes shorter ones for the same error.
pub const MICRO_STEPS: [f64; 7] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005];

/// What tables and charts call the baseline, the method of Aikawa, Zhou and Wang 2019: `rk4` with hits on chords.
pub const BASELINE: &str = "micro-steps (paper)";

/// Tolerances, relative to the scene's diagonal.
pub const TOLERANCES: [f64; 7] = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// How long a candidate's rays are followed at least in a round (s).
const LEAST_SECONDS: f64 = 0.05;

/// An integrator to measure.
pub struct Candidate {
    /// Its name.
    pub name: &'static str,
    /// Step or tolerance, as shown.
    pub shown: String,
    /// The same as a number; `None` for what scenes get that do not ask for anything.
    pub setting: Option<f64>,
    /// The integrator.
    pub integrator: Box<dyn Integrator>,
}

/// All curved integrators with all settings, in a scene of the given diagonal; the baseline first.
pub fn candidates(diagonal: f64) -> Vec<Candidate> {
    let by_step = |name, step, integrator: Box<dyn Integrator>| Candidate {
        name,
        shown: format!("{step} rad"),
        setting: Some(step),
        integrator,
    };
    let baseline = MICRO_STEPS.map(|step| by_step(BASELINE, step, Box::new(MicroSteps::new(step, MOST_STEPS))));
    let rk4 = STEPS.map(|step| by_step("rk4", step, Box::new(Rk4::new(step, MOST_STEPS))));
    let tolerances = || TOLERANCES.map(Some).into_iter().chain([None]);
    let by_tolerance = |name, make: fn(Tolerance) -> Box<dyn Integrator>| {
        tolerances().map(move |setting| Candidate {
            name,
            shown: setting.map_or("default".into(), |t| format!("{t:.0e} diagonal")),
            setting,
            integrator: make(setting.map_or(Tolerance::DEFAULT, |t| Tolerance::Absolute(t * diagonal))),
        })
    };
    let adaptive = by_tolerance("adaptive", |t| Box::new(Adaptive::new(t, MOST_STEPS)));
    let exact = by_tolerance("exact", |t| Box::new(Exact::new(t, MOST_STEPS)));
    baseline.into_iter().chain(rk4).chain(adaptive).chain(exact).collect()
}

/// Nanoseconds of processor time that one of `rays` takes. They are followed in batches, as light transport does.
pub fn nanoseconds(world: &World, integrator: &dyn Integrator, rays: &[Ray]) -> f64 {
    let start = processor_seconds();
    let mut passes = 0.0;
    let mut ends = [RayEnd::NONE; BATCH];
    loop {
        for rays in rays.chunks(BATCH) {
            integrator.trace_all(world, rays, &mut ends[..rays.len()]);
            std::hint::black_box(&ends);
        }
        passes += 1.0;
        let seconds = processor_seconds() - start;
        if seconds >= LEAST_SECONDS {
            return seconds * 1e9 / (passes * rays.len() as f64);
        }
    }
}

/// Measures every candidate `rounds` times, in turn, on `count` camera rays and on the rays that bounce off what they meet. A scene without a hole has
/// nothing to choose between: an empty list.
pub fn measure(built: &BuiltScene, count: usize, rounds: u32) -> Vec<Measured> {
    if !matches!(built.scene.world.spacetime().class(), Class::Spherical(hole) if hole.charge_squared == 0.0) {
        return Vec::new();
    }
    let camera = camera_rays(built, count);
    let bounce = bounce_rays(built, &camera);
    [("camera_rays", camera), ("bounce_rays", bounce)]
        .into_iter()
        .filter(|(_, rays)| !rays.is_empty())
        .map(|(name, rays)| measure_rays(&built.scene.world, name, &rays, rounds))
        .collect()
}

fn measure_rays(world: &World, name: &'static str, rays: &[Ray], rounds: u32) -> Measured {
    let columns = [
        "integrator",
        "setting",
        "steps",
        "queries",
        "ns",
        "straight rays",
        "median",
        "p99",
        "worst",
        "other triangle %",
        "Pareto",
    ];
    let mut table = Table::new(&columns);
    let (true_ends, _) = arrivals(world, &truth(world), rays);
    let candidates = candidates(diagonal(world));

    // In turn, so that what else the machine does falls on all alike.
    let mut straight = Vec::new();
    let mut times = vec![Vec::new(); candidates.len()];
    for _ in 0..rounds {
        straight.push(nanoseconds(world, &Straight, rays));
        for (c, times) in candidates.iter().zip(&mut times) {
            times.push(nanoseconds(world, &*c.integrator, rays));
        }
    }
    let straight = median(&straight);

    let n = rays.len() as f64;
    let mut points = Vec::new();
    let mut rows = Vec::new();
    for (c, times) in candidates.iter().zip(&times) {
        let (ends, counters) = arrivals(world, &*c.integrator, rays);
        let d = differences(world, &ends, &true_ends);
        let ns = median(times);
        let [median, p99, worst] = d.distance.cells();
        rows.push(vec![
            c.name.to_owned(),
            c.shown.clone(),
            format!("{:.1}", counters.steps as f64 / n),
            format!("{:.2}", counters.queries as f64 / n),
            format!("{ns:.0}"),
            format!("{:.2}", ns / straight),
            median,
            p99,
            worst,
            format!("{:.3}", 100.0 * d.other_triangle),
        ]);
        points.push(Tradeoff { line: c.name.to_owned(), cost: ns, error: d.distance.p99 });
    }
    let set = |i: &usize| candidates[*i].setting.is_some();
    let summary: Vec<Tradeoff> = (0..points.len()).filter(set).map(|i| points[i].clone()).collect();
    let summary = Summary { title: "at equal error".into(), table: equal_error::table(&summary, straight) };
    // The exact integrator's orbits have no error: its chords decide which triangle is met, which the chart does not show.
    for (p, c) in points.iter_mut().zip(&candidates) {
        if c.name == "exact" || c.setting.is_none() {
            p.error = f64::NAN;
        }
    }
    for (mut row, best) in rows.into_iter().zip(pareto_front(&points)) {
        row.push(if best { "*" } else { "" }.to_owned());
        table.row(&row);
    }
    table.row(&["straight".to_owned(), String::new(), String::new(), "1.00".into(), format!("{straight:.0}"), "1.00".into()]);
    let points: Vec<Tradeoff> = points.into_iter().filter(|p| p.error.is_finite()).collect();
    let chart = Chart {
        title: format!("{}: error against time", name.replace('_', " ")),
        x: "processor time of a ray (ns)".into(),
        y: "p99 of the distance from the true hit / diagonal".into(),
        series: series(&points),
    };
    Measured { name, table, chart, summary: Some(summary) }
}
