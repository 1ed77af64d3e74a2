//! The render loop: waves of samples over tiles, in parallel, the same bytes for any number of threads.
//!
//! A pixel's samples are added in their order, each wave going on where the last one ended; a sample depends on nothing but
//! (seed, pixel, index), and for transports that learn on its wave. An interruption ends a wave between samples: the picture so far is
//! whole, if noisier in places, and a render that is resumed goes on there.

mod state;
mod waves;

pub use state::{RenderState, Snapshot};
pub use waves::{Limits, Wave};

use crate::film::{Framebuffer, Tile, TileProgress};
use crate::lang::BuiltScene;
use crate::layers::LayerCollector;
use crate::progress::Progress;
use crate::signals::{Signals, StopSignal};
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
use std::sync::Arc;

/// Everything that a render needs.
#[derive(Clone, Copy)]
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
    let state = RenderState::new(Job::of(built));
    let ended = state.run(&Limits::of(&*built.sampler), &Progress::new(0, true), &Signals::default());
    state.rendered(ended)
}

/// What a render leaves behind.
pub struct Rendered {
    /// The frame, whole or as far as it came. Where the render goes on, its tiles change.
    pub frame: Arc<Framebuffer>,
    /// What was counted.
    pub counters: Counters,
    /// Samples that every pixel has at least.
    pub samples: u32,
    /// Samples that the pixel with the most has.
    pub most_samples: u32,
    /// Seconds of rendering, those before it was resumed included.
    pub seconds: f64,
    /// Why it ended.
    pub ended: Ended,
}

/// Why a render has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every pixel has the samples that it was to have.
    Complete,
    /// The time that it was given is over.
    TimeOver,
    /// It was told to stop.
    Stopped(StopSignal),
    /// It has not: this is what there is so far.
    Underway,
}

impl Ended {
    /// One word for it: what the EXR header says.
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::TimeOver => "time",
            Self::Stopped(signal) => signal.name(),
            Self::Underway => "underway",
        }
    }
}

/// What a thread needs to work on tiles.
struct TileWork<'a> {
    job: &'a Job<'a>,
    layers: Option<&'a LayerCollector<'a>>,
    channels: usize,
    /// What random numbers depend on besides pixel and sample, for transports that learn.
    wave: u32,
}

impl TileWork<'_> {
    /// Goes on with the range of samples that is under way in a tile, until it is done or `pause` says so, which is asked after every
    /// [`BATCH`] of samples.
    fn advance(&self, tile: &mut Tile, pause: impl Fn() -> bool) -> Counters {
        let Self { job, channels, .. } = *self;
        let mut log = TraceLog::default();
        let [lo, hi] = job.film.lambda_range();
        let wavelengths = VisibleWavelengths::new(lo, hi);
        let wants_variance = job.film.layers().contains(&Layer::Variance);
        let TileProgress { done, end, position } = tile.progress;
        let samples = end.saturating_sub(done).max(1) as usize;
        // Pixel after pixel.
        let all = tile.weights.len() * samples;
        let mut rest = (position as usize..all).map(|at| (at / samples, done + (at % samples) as u32));
        let (mut seen, mut paths) = (ArrayVec::<Seen, BATCH>::new(), ArrayVec::<PathSample, BATCH>::new());
        while tile.progress.position > 0 || tile.progress.done < end {
            for (i, index) in rest.by_ref().take(BATCH) {
                let pixel = [tile.origin[0] + i as u32 % tile.size[0], tile.origin[1] + i as u32 / tile.size[0]];
                let stream = SampleStream::of_wave(job.sampler, pixel, index, self.wave);
                let (sample, path) = Seen::new(job, &wavelengths, i, pixel, stream);
                seen.push(sample);
                paths.push(path);
            }
            let rays: ArrayVec<Ray, BATCH> = paths.iter().map(|p| p.ray).collect();
            job.transport.radiance_all(job.scene, &mut paths, &mut log);
            for ((seen, path), ray) in seen.iter().zip(&paths).zip(rays) {
                if let Some(layers) = self.layers {
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
            tile.progress.position += paths.len() as u32;
            if tile.progress.position as usize >= all {
                tile.progress = TileProgress { done: end, end, position: 0 };
            }
            seen.clear();
            paths.clear();
            if pause() {
                break;
            }
        }
        log.counters
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
