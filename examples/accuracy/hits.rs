//! Hits on the dragon of `scenes/gold_dragon.bhs` against those of the closed form with very short chords.

use crate::table::{Summary, Table};
use anyhow::Result;
use bhs::lang::{BuiltScene, Overrides};
use bhs::plot::{Chart, Series};
use bhs_core::integrator::{Arrival, Integrator, Ray};
use bhs_core::sampling::{SampleStream, cosine_hemisphere};
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use bhs_integrators::flight::Tolerance;
use bhs_integrators::{Adaptive, Exact, Rk4};
use glam::DVec2;

/// Rays of each kind.
const RAYS: usize = 40_000;

/// Tolerance of the truth, relative to the scene's diagonal.
const TRUTH: f64 = 1e-7;

/// Steps of `schwarzschild-rk4` (rad).
const STEPS: [f64; 6] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

/// Tolerances, relative to the scene's diagonal.
const TOLERANCES: [f64; 7] = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// A hit this far from the true one, relative to the scene's diagonal, is somewhere else.
const ELSEWHERE: f64 = 1e-2;

/// How long rays are followed at least to find out how long that takes (s): the clock ticks a hundred times a second.
const LEAST_SECONDS: f64 = 0.5;

/// More steps than any ray takes.
const MOST_STEPS: u64 = 1_000_000;

/// The scene's diagonal (scene units).
pub fn diagonal(world: &World) -> f64 {
    (world.bounds.max - world.bounds.min).length()
}

/// The truth: closed orbits, very short chords.
pub fn truth(world: &World) -> Exact {
    Exact::new(Tolerance::Absolute(TRUTH * diagonal(world)), MOST_STEPS)
}

/// Camera rays through random places of the picture.
fn camera_rays(built: &BuiltScene) -> Vec<Ray> {
    let [width, height] = built.film.resolution().map(f64::from);
    let ray = |i: usize| {
        let mut stream = SampleStream::new(&*built.sampler, [0, 0], i as u32);
        let at = stream.next_2d().as_dvec2() * DVec2::new(width, height);
        let seen = built.camera.ray(at, stream.next_2d());
        let direction = built.scene.camera.frame.chart_direction(seen.direction);
        Ray { origin: seen.origin, direction, footprint: built.scene.footprints.camera }
    };
    (0..RAYS).map(ray).collect()
}

/// Rays of the given kind that leave the surfaces which camera rays arrive at, as light leaves a white wall.
fn bounce_rays(built: &BuiltScene, from: &[Ray]) -> Vec<Ray> {
    let (scene, integrator) = (&built.scene, truth(&built.scene.world));
    let lambda = bhs_core::spectrum::SampledWavelengths::visible(0.5, 360.0, 830.0);
    let bounce = |(i, ray): (usize, &Ray)| {
        let Arrival::Surface(hit) = integrator.trace(&scene.world, ray, &mut TraceLog::default()) else { return None };
        let vertex = scene.vertex(hit, &lambda)?;
        let mut stream = SampleStream::new(&*built.sampler, [1, 0], i as u32);
        let wi = cosine_hemisphere(stream.next_2d());
        let wi = if vertex.wo.z < 0.0 { -wi } else { wi };
        vertex.is_consistent(wi).then(|| vertex.spawn(&scene.world, wi, scene.footprints.rough))
    };
    from.iter().enumerate().filter_map(bounce).collect()
}

/// Camera rays and bounce rays of a scene.
pub fn rays(built: &BuiltScene) -> [Vec<Ray>; 2] {
    let camera = camera_rays(built);
    let bounce = bounce_rays(built, &camera);
    [camera, bounce]
}

/// How the arrivals of rays differ from the true ones.
pub struct Differences {
    /// Distance from the true hit, of rays that hit the same triangle (scene units).
    pub distance: Summary,
    /// The largest distance between the found hit and the true ray there, of the same rays (scene units): what tolerances are about.
    pub worst_across: f64,
    /// Shares of all rays: that hit another triangle, that arrive elsewhere or not at all.
    pub other_triangle: f64,
    pub elsewhere: f64,
    /// Per ray.
    pub queries: f64,
    pub nanoseconds: f64,
}

/// Follows `rays` and compares their arrivals with the true ones.
pub fn differences(world: &World, integrator: &dyn Integrator, rays: &[Ray], truth: &[Arrival]) -> Differences {
    let mut log = TraceLog::default();
    let start = crate::processor_seconds();
    let found: Vec<Arrival> = rays.iter().map(|ray| integrator.trace(world, ray, &mut log)).collect();
    let mut passes = 1.0;
    while crate::processor_seconds() - start < LEAST_SECONDS {
        rays.iter().for_each(|ray| {
            std::hint::black_box(integrator.trace(world, ray, &mut TraceLog::default()));
        });
        passes += 1.0;
    }
    let seconds = (crate::processor_seconds() - start) / passes;
    let far = ELSEWHERE * diagonal(world);
    let (mut same, mut worst_across, mut other, mut elsewhere) = (Vec::new(), 0.0f64, 0, 0);
    for (t, f) in truth.iter().zip(&found) {
        match (t, f) {
            (Arrival::Surface(t), Arrival::Surface(f)) => {
                let distance = (t.point - f.point).length();
                if (t.geometry, t.primitive) == (f.geometry, f.primitive) {
                    same.push(distance);
                    worst_across = worst_across.max((t.point - f.point).cross(t.direction).length());
                } else {
                    other += 1;
                    elsewhere += u32::from(distance > far);
                }
            }
            (Arrival::Sky(_), Arrival::Sky(_)) | (Arrival::Hole, Arrival::Hole) => {}
            _ => {
                other += 1;
                elsewhere += 1;
            }
        }
    }
    let n = rays.len() as f64;
    Differences {
        distance: Summary::of(same),
        worst_across,
        other_triangle: f64::from(other) / n,
        elsewhere: f64::from(elsewhere) / n,
        queries: log.counters.queries as f64 / n,
        nanoseconds: seconds * 1e9 / n,
    }
}

/// Where rays truly arrive.
pub fn arrivals(world: &World, rays: &[Ray]) -> Vec<Arrival> {
    let integrator = truth(world);
    rays.iter().map(|ray| integrator.trace(world, ray, &mut TraceLog::default())).collect()
}

/// An integrator to measure.
struct Candidate {
    name: &'static str,
    /// Step or tolerance, as shown.
    shown: String,
    /// The same as a number; `None` for what scenes get that do not ask for anything.
    setting: Option<f64>,
    integrator: Box<dyn Integrator>,
}

fn candidates(diagonal: f64) -> Vec<Candidate> {
    let rk4 = STEPS.map(|step| Candidate {
        name: "rk4",
        shown: format!("{step} rad"),
        setting: Some(step),
        integrator: Box::new(Rk4::new(step, MOST_STEPS)),
    });
    let tolerances = || TOLERANCES.map(Some).into_iter().chain([None]);
    let by_tolerance = |name, make: fn(Tolerance) -> Box<dyn Integrator>| {
        tolerances().map(move |setting| Candidate {
            name,
            shown: setting.map_or("default".into(), |t| format!("{t:.0e}")),
            setting,
            integrator: make(setting.map_or(Tolerance::DEFAULT, |t| Tolerance::Absolute(t * diagonal))),
        })
    };
    let adaptive = by_tolerance("adaptive", |t| Box::new(Adaptive::new(t, MOST_STEPS)));
    let exact = by_tolerance("exact", |t| Box::new(Exact::new(t, MOST_STEPS)));
    rk4.into_iter().chain(adaptive).chain(exact).collect()
}

pub fn measure() -> Result<()> {
    let built = crate::scene("gold_dragon", &Overrides::default())?;
    let world = &built.scene.world;
    let diagonal = diagonal(world);
    for (kind, rays) in ["camera", "bounce"].into_iter().zip(rays(&built)) {
        let truth = arrivals(world, &rays);
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
            "ns a ray",
        ]);
        let mut lines: Vec<Series> = Vec::new();
        for Candidate { name, shown, setting, integrator } in candidates(diagonal) {
            let d = differences(world, &*integrator, &rays, &truth);
            let relative = |e: f64| e / diagonal;
            let distance =
                Summary { median: relative(d.distance.median), p99: relative(d.distance.p99), worst: relative(d.distance.worst) };
            let [median, p99, worst] = distance.cells();
            let shares = [d.other_triangle, d.elsewhere].map(|s| format!("{:.3} %", 100.0 * s));
            let [other, elsewhere] = shares;
            let (queries, time) = (format!("{:.1}", d.queries), format!("{:.0}", d.nanoseconds));
            let across = format!("{:.1e}", relative(d.worst_across));
            table.row(&[name.to_owned(), shown, median, p99, worst, across, other, elsewhere, queries, time]);
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
        table.finish(&format!("hits_{kind}"))?;
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
