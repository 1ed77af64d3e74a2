//! Light transports on a scene: seconds against noise.

use super::clock::{median, processor_seconds};
use super::equal_error::cost_at;
use super::rays::MOST_STEPS;
use super::table::Table;
use super::{Measured, Summary, Tradeoff, pareto_front, series};
use crate::compare::compare;
use crate::image::Picture;
use crate::lang::{self, BuiltScene, Overrides};
use crate::memory::OutOfMemory;
use crate::plot::Chart;
use crate::render::try_render_quietly;
use anyhow::{Context, Result};
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::sampling::NoiseOver;
use bhs_engine::connections::Connections;
use bhs_engine::integrator::Integrator;
use bhs_engine::way::Watch;
use bhs_engine::world::World;
use bhs_integrators::{MicroSteps, Straight};

/// How the baseline follows rays: fixed micro-steps (Aikawa, Zhou and Wang 2019).
const BASELINE: &str = "rk4";

/// The angle of its steps (rad): the default of `rk4`.
const BASELINE_STEP: f64 = 0.1;

/// Samples a pixel that every method is measured with.
const SAMPLES: [u32; 3] = [4, 16, 64];

/// Samples of the reference over the most samples that are measured.
const REFERENCE: u32 = 16;

/// An integrator that does not say which rays join two points, so that lights are found by BSDF sampling alone.
struct Unconnected(Box<dyn Integrator>);

impl Integrator for Unconnected {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.0.trace_all(world, rays, ends);
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        self.0.watched(world, ray, watch)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        None
    }
}

/// A way to render the scene.
struct Method {
    name: &'static str,
    transport: &'static str,
    integrator: Option<&'static str>,
    connected: bool,
    /// Switches of the light transport.
    switches: &'static [(&'static str, bool)],
    /// Whether pixels get as many samples each, or as many as the same noise takes.
    adaptive: bool,
}

impl Method {
    const fn new(name: &'static str, transport: &'static str) -> Self {
        Self { name, transport, integrator: None, connected: true, switches: &[], adaptive: false }
    }
}

/// The method that references are made with, and whose error says what others are to reach.
const BEST: usize = 3;

/// The seed's method first: what everything else is measured against. The others are `path` as scenes have it, without one thing or with one more.
const METHODS: [Method; 7] = [
    Method { integrator: Some(BASELINE), ..Method::new("hemisphere, micro-steps (paper)", "hemisphere") },
    Method::new("hemisphere", "hemisphere"),
    Method { connected: false, ..Method::new("path, no light sampling", "path") },
    Method::new("path", "path"),
    Method { switches: &[("caustics", false)], ..Method::new("path, no caustics", "path") },
    Method { switches: &[("guiding", true)], ..Method::new("path, guiding", "path") },
    Method { adaptive: true, ..Method::new("path, adaptive", "path") },
];

/// When a picture is done.
#[derive(Clone, Copy)]
enum Amount {
    /// With so many samples of each pixel.
    Samples(u32),
    /// With so little noise, over the whole picture.
    Noise(f64),
}

fn picture(built: &BuiltScene) -> Result<(Picture, f64), OutOfMemory> {
    let start = processor_seconds();
    let rendered = try_render_quietly(built)?;
    Ok((rendered.frame.picture(), processor_seconds() - start))
}

/// The scene, and what takes turns in it.
struct Studio<F> {
    built: BuiltScene,
    make: F,
    /// Whether its integrator bends light.
    curved: bool,
}

impl<F: Fn(&Overrides) -> Result<lang::Method>> Studio<F> {
    fn overrides(&self, method: &Method) -> Overrides {
        Overrides {
            transport: Some(method.transport.to_owned()),
            integrator: method.integrator.filter(|_| self.curved).map(str::to_owned),
            switches: method.switches.to_vec(),
            ..Default::default()
        }
    }

    /// Makes what `method` needs.
    fn ready(&self, method: &Method) -> Result<lang::Method> {
        let made = (self.make)(&self.overrides(method));
        let mut made = made.with_context(|| format!("the scene cannot be rendered with `{}`", method.name))?;
        if self.curved && method.integrator.is_some() {
            made.integrator = Box::new(MicroSteps::new(BASELINE_STEP, MOST_STEPS));
        } else if !self.curved {
            made.integrator = Box::new(Straight);
        }
        if !method.connected {
            made.integrator = Box::new(Unconnected(made.integrator));
        }
        Ok(made)
    }

    /// The picture by `ready`, which is put back, and its seconds.
    fn picture(&mut self, ready: &mut lang::Method, amount: Amount, seed: u64) -> Result<(Picture, f64)> {
        let (spp, noise) = match amount {
            Amount::Samples(samples) => (Some(samples), None),
            Amount::Noise(noise) => (None, Some(noise)),
        };
        let numbers = (self.make)(&Overrides {
            spp,
            noise,
            noise_over: noise.map(|_| NoiseOver::Picture),
            seed: Some(seed),
            ..Default::default()
        })?;
        self.built.sampler = numbers.sampler;
        self.swap(ready);
        let done = picture(&self.built);
        self.swap(ready);
        Ok(done?)
    }

    fn swap(&mut self, ready: &mut lang::Method) {
        std::mem::swap(&mut self.built.scene.integrator, &mut ready.integrator);
        std::mem::swap(&mut self.built.transport, &mut ready.transport);
    }
}

/// Measures every method `rounds` times, with other seeds, in the scene `built`. `make` makes the scene's methods with changes.
///
/// # Errors
/// If the scene cannot be rendered with another transport.
pub fn measure(built: BuiltScene, make: impl Fn(&Overrides) -> Result<lang::Method>, rounds: u32) -> Result<Measured> {
    let curved = built.scene.world.bends();
    let mut studio = Studio { built, make, curved };
    let mut ready = METHODS.iter().map(|m| studio.ready(m)).collect::<Result<Vec<_>>>()?;
    let most = Amount::Samples(SAMPLES[SAMPLES.len() - 1] * REFERENCE);
    let (reference, _) = studio.picture(&mut ready[BEST], most, 1_000_003)?;

    let mut points = Vec::new();
    let mut rows = Vec::new();
    for samples in SAMPLES {
        let mut found = vec![(Vec::new(), Vec::new()); METHODS.len()];
        // The noise that so many samples of each pixel leave is what the adaptive method is to reach.
        let (first, _) = studio.picture(&mut ready[BEST], Amount::Samples(samples), 1_000_005)?;
        let noise = compare(&first, &reference)?.relative_mse.sqrt().clamp(1e-4, 1.0);
        for seed in 0..u64::from(rounds) {
            for ((ready, method), (seconds, errors)) in ready.iter_mut().zip(&METHODS).zip(&mut found) {
                let amount = if method.adaptive { Amount::Noise(noise) } else { Amount::Samples(samples) };
                let (picture, time) = studio.picture(ready, amount, seed)?;
                seconds.push(time);
                errors.push(compare(&picture, &reference)?.relative_mse);
            }
        }
        for (method, (seconds, errors)) in METHODS.iter().zip(&found) {
            let (seconds, error) = (median(seconds), median(errors));
            points.push(Tradeoff { line: method.name.to_owned(), cost: seconds, error });
            // Error times seconds: what noise costs, much the same for any number of samples.
            rows.push((method.name, samples, seconds, error, seconds * error));
        }
    }
    let columns =
        ["method", "samples of `path`", "seconds", "relative MSE", "relative MSE x seconds", "times the baseline", "Pareto"];
    let mut table = Table::new(&columns);
    for ((name, samples, seconds, error, cost), front) in rows.iter().zip(pareto_front(&points)) {
        let baseline = rows.iter().find(|r| r.0 == METHODS[0].name && r.1 == *samples).map_or(f64::NAN, |r| r.4);
        table.row(&[
            (*name).to_owned(),
            samples.to_string(),
            format!("{seconds:.2}"),
            format!("{error:.3e}"),
            format!("{cost:.3e}"),
            format!("{:.1}", baseline / cost),
            if front { "*" } else { "" }.to_owned(),
        ]);
    }
    let chart = Chart {
        title: "Light transports: noise against time".into(),
        x: "processor time (s)".into(),
        y: "relative mean square error".into(),
        series: series(&points),
    };
    let summary = Some(Summary { title: "at equal error".into(), table: at_equal_error(&points) });
    Ok(Measured { name: "transports", table, chart, summary })
}

/// The seconds that each method takes to the errors that `path` has with each number of samples, and how many times those of `path` that is.
fn at_equal_error(points: &[Tradeoff]) -> Table {
    let of = |name: &str| points.iter().filter(|p| p.line == name).map(|p| (p.error, p.cost)).collect::<Vec<_>>();
    let best = of(METHODS[BEST].name);
    let columns = best.iter().flat_map(|(error, _)| [format!("s to {error:.1e}"), format!("times `path` to {error:.1e}")]);
    let columns: Vec<String> = std::iter::once("method".to_owned()).chain(columns).collect();
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for method in &METHODS {
        let own = of(method.name);
        let mut row = vec![method.name.to_owned()];
        for (error, of_best) in &best {
            let cost = cost_at(&own, *error);
            let shown = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.2}"));
            row.extend([shown(cost), shown(cost.map(|cost| cost / of_best))]);
        }
        table.row(&row);
    }
    table
}
