//! Paths from which a guide learns, and which tell whether guiding pays. They are followed before a wave of samples, as the camera's paths are, but belong to
//! no pixel: what is learned is a function of the seed and of the sample that comes next, whatever part of the picture is rendered.
//!
//! Several paths go to each place of the picture, which is as large as a pixel. By how much what they find differs, relative to its mean, is noise that guiding may lower; rays followed are
//! what it costs. Whether directions are guided is decided by the product of both, against that of the first paths, which were not guided (the efficiency of a Monte
//! Carlo estimate is one over variance times cost).

use super::{Guide, Lesson};
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample, RenderSetting};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Paths of each place.
const PATHS: usize = 8;
/// Stages: from which sample on, and paths a pixel; the more samples there are to be, the more is worth being known. Pictures of few samples are done before.
const STAGES: [(u32, f64); 6] = [(8, 0.33), (8, 0.33), (8, 0.33), (16, 1.0), (32, 2.0), (64, 4.0)];
/// So many of them tell whether it pays to go on.
const FIRST_STAGES: u32 = 3;
/// Paths of a stage.
const PATHS_OF_STAGE: RangeInclusive<u64> = 8192..=1 << 18;
/// Pictures of fewer pixels are done before anything is learned.
const LEAST_PIXELS: u64 = 128 * 128;
/// What finding out what was learned adds to the cost of a ray.
const OVERHEAD: f64 = 1.08;
/// By how much efficiency has to be better for directions to be guided. These paths have independent numbers and say too much good of it: samples of a pixel that are
/// spread over it have less noise of the kind that guiding takes away. In the scenes of README the true gain was 0.7 to 0.85 of theirs (docs/performance.md).
const PAYS: f64 = 1.3;
/// If it is not as good as this after the first stages, no more is learned.
const HOPELESS: f64 = 1.1;
/// The column of pixels that no picture has whose random numbers these are.
const COLUMN: u32 = u32::MAX - 1;

/// What the paths of a stage found.
#[derive(Default)]
pub struct Lessons {
    open: Vec<OpenLesson>,
}

/// A lesson of a path that is under way.
struct OpenLesson {
    path: usize,
    lesson: Lesson,
    /// Weight of what is found in the direction, and what the path had found before: means over the wavelengths.
    throughput: f32,
    /// `None` until that is known; if it never is, the path ended there.
    before: Option<f32>,
}

impl Lessons {
    /// Path number `path` of its batch goes on in a direction of which `lesson` is to be learned, with the weight `throughput`.
    pub fn begin(&mut self, path: usize, lesson: Lesson, throughput: f32) {
        self.open.push(OpenLesson { path, lesson, throughput, before: None });
    }

    /// Path number `path` arrives where it went, and has found `before` until then.
    pub fn arrive(&mut self, path: usize, before: f32) {
        if let Some(open) = self.open.iter_mut().rev().find(|open| open.path == path) {
            open.before.get_or_insert(before);
        }
    }

    /// What is learned of paths that have found what `after` says.
    fn finish(self, after: impl Fn(usize) -> f32) -> impl Iterator<Item = Lesson> {
        self.open.into_iter().filter_map(move |OpenLesson { path, lesson, throughput, before }| {
            let radiance = before.map_or(0.0, |before| (after(path) - before) / throughput);
            (radiance >= 0.0 && radiance.is_finite()).then_some(Lesson { radiance, ..lesson })
        })
    }
}

/// How paths are followed: by a guide if there is one, and with lessons to be learned.
pub type Follow<'f> = dyn Fn(&Guide, &mut [PathSample], &mut PathLog, &mut Lessons) + Sync + 'f;

/// A guide in training.
pub struct Pilots {
    guide: Guide,
    /// Whether directions are guided whatever comes of it.
    is_wanted: bool,
    /// Pixels of the whole picture.
    pixels: u64,
    stage: u32,
    /// Variance times cost without a guide, and with it.
    unguided: Option<f64>,
    guided: Option<f64>,
}

impl Pilots {
    /// Those of a render; `None` if its picture is too small, unless a guide `is_wanted` whatever comes of it.
    pub fn new(setting: &RenderSetting, is_wanted: bool) -> Option<Self> {
        let guide = Guide::new(setting.scene.world.bounds_of_both_sides());
        let pixels = setting.pixels;
        (is_wanted || pixels >= LEAST_PIXELS).then_some(Self { guide, is_wanted, pixels, stage: 0, unguided: None, guided: None })
    }

    /// The guide, where directions are to be guided.
    pub fn guide(&self) -> Option<&Guide> {
        (self.stage > 0 && (self.is_wanted || self.gain() > PAYS)).then_some(&self.guide)
    }

    /// Efficiency with the guide over that without; 0 while it is not known.
    fn gain(&self) -> f64 {
        match (self.unguided, self.guided) {
            (Some(unguided), Some(guided)) if guided > 0.0 => unguided / guided,
            _ => 0.0,
        }
    }

    /// Learns what is to be known before the sample number `sample`.
    pub fn prepare(&mut self, setting: &RenderSetting, sample: u32, follow: &Follow<'_>) {
        while let Some(paths) = self.next_stage(sample) {
            if (setting.is_stopped)() {
                return;
            }
            self.train(setting, paths, follow);
        }
    }

    /// Paths of the next stage, if it is due before the sample number `sample`.
    fn next_stage(&self, sample: u32) -> Option<u64> {
        if self.stage >= FIRST_STAGES && !self.is_wanted && self.gain() < HOPELESS {
            return None;
        }
        let (from, per_pixel) = STAGES.get(self.stage as usize)?;
        let is_first = self.is_wanted && self.stage < FIRST_STAGES;
        let paths = (self.pixels as f64 * per_pixel) as u64;
        (is_first || sample >= *from).then_some(paths.clamp(*PATHS_OF_STAGE.start(), *PATHS_OF_STAGE.end()))
    }

    fn train(&mut self, setting: &RenderSetting, paths: u64, follow: &Follow<'_>) {
        let (guide, stage, pixels) = (&self.guide, self.stage, self.pixels);
        let batches = paths.div_ceil(BATCH as u64) as u32;
        let taught: Vec<Taught> =
            (0..batches).into_par_iter().map(|b| Taught::by(setting, [stage, b], pixels, (guide, follow))).collect();
        let (mut variance, mut rays) = (0.0, 0);
        for batch in taught {
            variance += batch.variance;
            rays += batch.rays;
            self.guide.learn(&batch.lessons);
        }
        self.guide.refine();
        let product = variance * rays as f64 / (f64::from(batches) * f64::from(batches));
        match stage {
            0 => self.unguided = Some(product),
            _ => self.guided = Some(product * OVERHEAD),
        }
        self.stage += 1;
    }
}

/// What a batch of paths teaches.
struct Taught {
    lessons: Vec<Lesson>,
    /// Sum of the relative variances of the paths of each ray of the camera.
    variance: f64,
    /// Rays followed.
    rays: u64,
}

impl Taught {
    /// By batch number `batch` of the stage number `stage`.
    fn by(setting: &RenderSetting, [stage, batch]: [u32; 2], pixels: u64, (guide, follow): (&Guide, &Follow<'_>)) -> Self {
        let RenderSetting { sampler, lambda_range: [lo, hi], camera_ray, .. } = setting;
        let stream = |kind: u32, number: usize| {
            let number = batch * BATCH as u32 + number as u32;
            SampleStream::new(*sampler, [COLUMN, 2 * stage + kind], number)
        };
        // As wide as a pixel of the picture, if it is square.
        let pixel = 1.0 / (pixels.max(1) as f32).sqrt();
        let mut paths: Vec<PathSample> = (0..BATCH)
            .map(|i| {
                let mut camera = stream(0, i / PATHS * PATHS);
                let (film, lens) = (camera.next_2d(), camera.next_2d());
                let lambda = SampledWavelengths::visible(camera.next_1d(), *lo, *hi);
                let mut stream = stream(1, i);
                let film = (film + (stream.next_2d() - 0.5) * pixel).clamp(Vec2::ZERO, Vec2::ONE);
                PathSample::new(camera_ray(film, lens), lambda, stream)
            })
            .collect();
        let (mut log, mut lessons) = (PathLog::default(), Lessons::default());
        follow(guide, &mut paths, &mut log, &mut lessons);
        let found: Vec<f32> = paths.iter().map(|path| path.radiance.mean()).collect();
        let variance = found.chunks(PATHS).map(relative_variance).sum();
        Self { lessons: lessons.finish(|path| found[path]).collect(), variance, rays: log.counters.geodesics }
    }
}

/// Variance over squared mean of a few numbers that are not negative; 0 if all are.
fn relative_variance(numbers: &[f32]) -> f64 {
    let count = numbers.len() as f64;
    let mean = numbers.iter().map(|x| f64::from(*x)).sum::<f64>() / count;
    let squares: f64 = numbers.iter().map(|x| (f64::from(*x) - mean).powi(2)).sum();
    let relative = squares / (count - 1.0) / (mean * mean);
    if relative.is_finite() { relative } else { 0.0 }
}
