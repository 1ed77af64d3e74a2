//! The render loop: waves of samples over tiles, in parallel, the same bytes for any number of threads.
//!
//! A pixel's samples are added in their order, each wave going on where the last one ended; a sample depends on nothing but
//! (seed, pixel, index). An interruption ends a wave between tiles: the picture so far is whole, if noisier in places.

use crate::film::{Framebuffer, Tile};
use crate::lang::BuiltScene;
use crate::layers::LayerCollector;
use crate::progress::Progress;
use arrayvec::ArrayVec;
use bhs_core::camera::{Camera, Film, Filter};
use bhs_core::integrator::Ray;
use bhs_core::layer::Layer;
use bhs_core::observer::Observer;
use bhs_core::sampling::{SampleStream, Sampler};
use bhs_core::scene::Scene;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths, VisibleWavelengths};
use bhs_core::stats::{Counters, TraceLog};
use bhs_core::transport::{BATCH, LightTransport, PathSample};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Everything that a render needs.
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where it is seen from.
    pub camera: &'a dyn Camera,
    /// What records it.
    pub film: &'a dyn Film,
    /// Where samples of a pixel go.
    pub filter: &'a dyn Filter,
    /// Random numbers.
    pub sampler: &'a dyn Sampler,
    /// The method.
    pub transport: &'a dyn LightTransport,
}

impl<'a> Job<'a> {
    /// The render that a built scene describes.
    pub fn of(built: &'a BuiltScene) -> Self {
        Self {
            scene: &built.scene,
            camera: &*built.camera,
            film: &*built.film,
            filter: &*built.filter,
            sampler: &*built.sampler,
            transport: &*built.transport,
        }
    }
}

/// Renders a built scene to its end on the current rayon pool, and shows nothing meanwhile.
pub fn render_quietly(built: &BuiltScene) -> Rendered {
    render(&Job::of(built), &Progress::new(0, true), &AtomicBool::new(false))
}

/// What a render leaves behind.
pub struct Rendered {
    /// The frame, whole or as far as it came.
    pub frame: Framebuffer,
    /// What was counted.
    pub counters: Counters,
    /// Samples that every pixel has at least.
    pub samples: u32,
    /// Whether it was stopped early.
    pub interrupted: bool,
}

/// Samples of the longest wave: short enough for progress and interruptions, long enough for coherent work.
const LONGEST_WAVE: u32 = 32;

/// Renders `job` on the current rayon pool until it is done or `stop` is set.
pub fn render(job: &Job, progress: &Progress, stop: &AtomicBool) -> Rendered {
    let mut own = job.transport.for_render(job.scene);
    let frame = Framebuffer::new(job.film);
    let layers = LayerCollector::new(job.scene, job.film);
    let total = job.sampler.samples_per_pixel();
    let mut counters = Counters::default();
    let (mut done, mut wave) = (0, 0);
    while done < total && !stop.load(Ordering::Relaxed) {
        let next = done + done.clamp(1, LONGEST_WAVE).min(total - done);
        progress.wave(done, total);
        let job = &Job { transport: own.as_deref().unwrap_or(job.transport), ..*job };
        counters += frame
            .tiles
            .par_iter()
            .with_max_len(1)
            .map(|tile| {
                if stop.load(Ordering::Relaxed) {
                    return Counters::default();
                }
                let mut tile = tile.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                let counted = render_tile(job, layers.as_ref(), &mut tile, frame.channel_count(), (wave, done..next));
                progress.tile(u64::from(tile.size[0] * tile.size[1]) * u64::from(next - done), counted.geodesics);
                counted
            })
            .reduce(Counters::default, |mut a, b| {
                a += b;
                a
            });
        if !stop.load(Ordering::Relaxed) {
            done = next;
            if let Some(own) = &mut own {
                own.end_wave();
                // What was learned depends on the numbers so far: the next ones must not.
                wave += 1;
            }
        }
    }
    Rendered { frame, counters, samples: done, interrupted: done < total }
}

fn render_tile(
    job: &Job,
    layers: Option<&LayerCollector>,
    tile: &mut Tile,
    channels: usize,
    (wave, samples): (u32, std::ops::Range<u32>),
) -> Counters {
    let mut log = TraceLog::default();
    let [lo, hi] = job.film.lambda_range();
    let wavelengths = VisibleWavelengths::new(lo, hi);
    let wants_variance = job.film.layers().contains(&Layer::Variance);
    let mut all = (0..tile.weights.len()).flat_map(|i| samples.clone().map(move |index| (i, index)));
    let (mut seen, mut paths) = (ArrayVec::<Seen, BATCH>::new(), ArrayVec::<PathSample, BATCH>::new());
    loop {
        for (i, index) in all.by_ref().take(BATCH) {
            let pixel = [tile.origin[0] + i as u32 % tile.size[0], tile.origin[1] + i as u32 / tile.size[0]];
            let stream = SampleStream::of_wave(job.sampler, pixel, index, wave);
            let (sample, path) = Seen::new(job, &wavelengths, i, pixel, stream);
            seen.push(sample);
            paths.push(path);
        }
        if paths.is_empty() {
            return log.counters;
        }
        let rays: ArrayVec<Ray, BATCH> = paths.iter().map(|p| p.ray).collect();
        job.transport.radiance_all(job.scene, &mut paths, &mut log);
        for ((seen, path), ray) in seen.iter().zip(&paths).zip(rays) {
            if let Some(layers) = layers {
                tile.add_layers(seen.pixel, job.film.layers(), layers.values(&ray), f64::from(seen.weight));
            }
            let sums = &mut tile.sums[seen.pixel * channels..][..channels];
            let before = wants_variance.then(|| color(sums));
            let weight = seen.add(job, path, sums, &mut log);
            if let Some(before) = before.filter(|_| weight != 0.0) {
                let after = color(sums);
                let sample = std::array::from_fn(|c| (after[c] - before[c]) / weight);
                tile.add_variance(seen.pixel, job.film.layers(), sample);
            }
            tile.weights[seen.pixel] += weight;
        }
        seen.clear();
        paths.clear();
    }
}

/// Red, green and blue, with which all films begin.
fn color(sums: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| sums.get(c).copied().unwrap_or_default())
}

/// One sample of one pixel, as its observer sees it.
struct Seen {
    /// Number of the pixel in its tile.
    pixel: usize,
    /// The filter's weight.
    weight: f32,
    /// Wavelengths where the ray starts.
    lambda: SampledWavelengths,
    /// Wavelength where the ray starts over wavelength at E = 1, of the light that arrives along it; `None` where there is no static observer.
    ratio: Option<f64>,
}

impl Seen {
    /// The sample, and the path that is to be followed for it.
    fn new<'a>(
        job: &Job<'a>,
        wavelengths: &VisibleWavelengths,
        number: usize,
        pixel: [u32; 2],
        mut stream: SampleStream<'a>,
    ) -> (Self, PathSample<'a>) {
        let (offset, weight) = job.filter.sample(stream.next_2d());
        let raster = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5) + offset.as_dvec2();
        let view = job.camera.ray(raster, stream.next_2d());
        let lambda = wavelengths.sample(stream.next_1d());
        let observer = job.scene.observer(view.origin);
        let direction = observer.unwrap_or(Observer::FLAT).chart_direction(view.direction);
        let ray = Ray { origin: view.origin, direction, footprint: job.scene.footprints.camera };
        let seen = Self { pixel: number, weight, lambda, ratio: observer.map(|o| o.ratio(direction)) };
        let along = match seen.ratio {
            Some(ratio) if ratio != 1.0 => SampledWavelengths { lambda_nm: lambda.at(ratio.recip() as f32), ..lambda },
            _ => lambda,
        };
        (seen, PathSample { ray, lambda: along, stream, radiance: SampledSpectrum::ZERO })
    }

    /// Adds what `path` has found to the pixel's sums and returns the weight that it has there.
    fn add(&self, job: &Job, path: &PathSample, sums: &mut [f64], log: &mut TraceLog) -> f64 {
        log.counters.paths += 1;
        let radiance = self.received(job, path.radiance, log);
        if !radiance.is_finite() {
            log.counters.not_finite += 1;
            return 0.0;
        }
        job.film.add(radiance * self.weight, &self.lambda, sums);
        f64::from(self.weight)
    }

    /// The spectral radiance `radiance` at E = 1 as the observer measures it where the ray starts.
    fn received(&self, job: &Job, radiance: SampledSpectrum, log: &mut TraceLog) -> SampledSpectrum {
        match self.ratio {
            Some(1.0) => radiance,
            Some(ratio) => radiance * job.scene.radiance_factor(ratio.recip()),
            None => {
                log.counters.inside_horizon += 1;
                SampledSpectrum::ZERO
            }
        }
    }
}
