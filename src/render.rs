//! The render loop: waves of samples over tiles, in parallel, the same bytes for any number of threads.
//!
//! A sample depends on nothing but (seed, pixel, index) and on what a transport makes for its wave; sums are exact, so that they do not depend on
//! the order of samples, and parts of a picture add up to the whole. An interruption ends a wave between samples: the picture so far is
//! whole, if noisier in places, and a render that is resumed goes on there.

mod coarse;
mod state;
pub(crate) mod waves;

pub use crate::adaptive::{NoiseFound, NoiseGoal};
pub use crate::job::Job;
pub use coarse::coarse;
pub use state::{RenderState, Snapshot};
pub use waves::{JUDGED_FROM, Limits, Wave};

use crate::film::{Framebuffer, Tile, TileProgress, variance_at};
use crate::lang::BuiltScene;
use crate::layers::LayerCollector;
use crate::memory::OutOfMemory;
use crate::not_finite::{FirstSamples, SampleId};
use crate::patches::Patches;
use crate::progress::Progress;
use crate::sample::CameraSample;
use crate::signals::{Signals, StopSignal};
use arrayvec::ArrayVec;
use bhs_colour::LUMINANCE;
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::VisibleWavelengths;
use bhs_engine::stats::{Counters, PathLog};
use bhs_engine::transport::{BATCH, PathSample};
use std::sync::Arc;

/// As [`try_render_quietly`], for small pictures.
///
/// # Panics
/// If there is not enough memory for its frame.
pub fn render_quietly(built: &BuiltScene) -> Rendered {
    try_render_quietly(built).unwrap_or_else(|e| panic!("{e}"))
}

/// Renders a built scene to its end on the current rayon pool, and shows nothing meanwhile.
///
/// # Errors
/// If there is not enough memory for its frame.
pub fn try_render_quietly(built: &BuiltScene) -> Result<Rendered, OutOfMemory> {
    let state = RenderState::new(Job::of(built))?;
    let ended = state.run(&Limits::of(&*built.sampler), &Progress::hidden(), &Signals::default());
    Ok(state.rendered(ended))
}

/// What a render leaves behind. A copy of it shares its frame.
#[derive(Clone)]
pub struct Rendered {
    /// The frame, whole or as far as it came. Where the render goes on, its tiles change.
    pub frame: Arc<Framebuffer>,
    /// What was counted.
    pub counters: Counters,
    /// The first of the samples that were not finite and were left out; `counters` says how many there are.
    pub not_finite: FirstSamples,
    /// Samples that every pixel has at least.
    pub samples: u32,
    /// Samples that the pixel with the most has.
    pub most_samples: u32,
    /// The noise that is left, where that decided how many samples pixels got.
    pub noise: Option<NoiseFound>,
    /// Seconds of rendering, those before it was resumed included.
    pub seconds: f64,
    /// Why it ended.
    pub ended: Ended,
}

impl Rendered {
    /// Samples of a pixel, in the mean over the picture.
    pub fn mean_samples(&self) -> f64 {
        self.frame.samples() as f64 / self.frame.pixel_count().max(1) as f64
    }

    /// Samples of its pixels, as people read it: one number, or the least and the greatest.
    pub fn spp(&self) -> String {
        match self.noise {
            Some(_) if self.most_samples > self.samples => format!("{} to {}", self.samples, self.most_samples),
            _ => self.samples.to_string(),
        }
    }
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
    wavelengths: &'a VisibleWavelengths,
    channels: usize,
}

impl TileWork<'_> {
    /// Goes on with the range of samples that is under way in a tile, until it is done or `pause` says so, which is asked after every
    /// [`BATCH`] of samples.
    fn advance(&self, tile: &mut Tile, pause: impl Fn() -> bool) -> Counted {
        let Self { job, channels, .. } = *self;
        let mut log = PathLog::default();
        let mut not_finite = FirstSamples::default();
        let variance = variance_at(job.layers);
        let mut brought = vec![0.0; channels];
        let TileProgress { first, done, end, position } = tile.progress;
        let samples = end.saturating_sub(done).max(1);
        // Pixel after pixel.
        let pixels = tile.under_way(samples);
        let samples = samples as usize;
        let all = pixels.len() * samples;
        let mut rest = (position as usize..all).map(|at| (at / samples, pixels[at / samples].1 + (at % samples) as u32));
        let (mut seen, mut paths) = (ArrayVec::<CameraSample, BATCH>::new(), ArrayVec::<PathSample, BATCH>::new());
        if all == 0 {
            tile.progress = TileProgress { first, done: end, end, position: 0 };
        }
        // Of the pixels from the current one on.
        let current = position as usize / samples;
        let patches = Patches::of(job, pixels.iter().skip(current).map(|(i, _)| tile.pixel(*i)));
        while tile.progress.position > 0 || tile.progress.done < end {
            for (at, index) in rest.by_ref().take(BATCH) {
                let pixel = tile.pixel(pixels[at].0);
                let stream = SampleStream::new(job.sampler, pixel, index);
                let (sample, mut path) = CameraSample::new(job, self.wavelengths, SampleId { pixel, sample: index }, stream);
                path.patch = patches.get(at - current);
                seen.push(sample);
                paths.push(path);
            }
            job.transport.follow_all(job.scene, &mut paths, &mut log);
            for (seen, path) in seen.iter().zip(&paths) {
                log.counters.add_camera_ray(&path.first);
                let pixel = tile.index(seen.id.pixel);
                if let Some(layers) = self.layers {
                    tile.add_layers(pixel, job.layers, layers.values(path, seen.camera_ratio()), f64::from(seen.weight));
                }
                // Each sample by itself, so that its numbers do not depend on those before it.
                brought.fill(0.0);
                let weight = seen.add(job, path, &mut brought, &mut log);
                if let Some(noise) = tile.noise.get_mut(pixel) {
                    noise.add(weight.map(|weight| [luminance(&brought), weight]));
                }
                match weight {
                    Some(weight) => {
                        tile.add_color(pixel, &brought, weight);
                        if let Some(at) = variance.filter(|_| weight != 0.0) {
                            tile.add_variance(pixel, at, color(&brought).map(|sum| sum / weight));
                        }
                    }
                    None => not_finite.insert(seen.id),
                }
            }
            tile.progress.position += paths.len() as u32;
            if tile.progress.position as usize >= all {
                tile.progress = TileProgress { first, done: end, end, position: 0 };
            }
            seen.clear();
            paths.clear();
            if pause() {
                break;
            }
        }
        Counted { counters: log.counters, not_finite }
    }
}

/// What is counted in a part of a render. The order of parts does not matter.
#[derive(Clone, Default)]
struct Counted {
    counters: Counters,
    not_finite: FirstSamples,
}

/// The luminance of what a sample brought.
fn luminance(sums: &[f64]) -> f64 {
    LUMINANCE.iter().zip(color(sums)).map(|(weight, c)| weight * c).sum()
}

/// Red, green and blue, with which all films begin.
fn color(sums: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| sums.get(c).copied().unwrap_or_default())
}
