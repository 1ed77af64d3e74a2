//! Paths from which a guide learns. They are followed before a wave of samples, as the camera's paths are, but belong to
//! no pixel: what is learned is a function of the seed and of the sample that comes next, whatever part of the picture is rendered.

use super::{Guide, Lesson};
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample, RenderSetting};
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Stages: before which sample, and paths a pixel; the more samples there are to be, the more is worth being known.
const STAGES: [(u32, f64); 6] = [(0, 0.33), (0, 0.33), (0, 0.33), (16, 1.0), (32, 2.0), (64, 4.0)];
/// Paths of a stage.
const PATHS_OF_STAGE: RangeInclusive<u64> = 8192..=1 << 18;
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
    /// Pixels of the whole picture.
    pixels: u64,
    /// Stages that are done.
    stage: u32,
}

impl Pilots {
    /// Those of a render.
    pub fn new(setting: &RenderSetting) -> Self {
        Self { guide: Guide::new(setting.scene.world.bounds_of_both_sides()), pixels: setting.pixels, stage: 0 }
    }

    /// What was learned.
    pub fn guide(&self) -> &Guide {
        &self.guide
    }

    /// Learns what is to be known before the sample number `sample`.
    pub fn prepare(&mut self, setting: &RenderSetting, sample: u32, follow: &Follow<'_>) {
        while let Some(paths) = self.next_stage(sample) {
            if !self.train(setting, paths, follow) {
                return;
            }
        }
    }

    /// Paths of the next stage, if it is due before the sample number `sample`.
    fn next_stage(&self, sample: u32) -> Option<u64> {
        let (from, per_pixel) = STAGES.get(self.stage as usize)?;
        let paths = (self.pixels as f64 * per_pixel) as u64;
        (sample >= *from).then_some(paths.clamp(*PATHS_OF_STAGE.start(), *PATHS_OF_STAGE.end()))
    }

    /// Goes through the next stage, of so many paths; false, and it is still the next one, if the render is to end meanwhile.
    fn train(&mut self, setting: &RenderSetting, paths: u64, follow: &Follow<'_>) -> bool {
        let (guide, stage) = (&self.guide, self.stage);
        let batches = paths.div_ceil(BATCH as u64) as u32;
        let taught: Vec<Vec<Lesson>> = (0..batches).into_par_iter().map(|b| taught(setting, [stage, b], guide, follow)).collect();
        if (setting.is_stopped)() {
            return false;
        }
        // In their order, for sums of floating point depend on it.
        taught.iter().for_each(|lessons| self.guide.learn(lessons));
        self.guide.refine();
        self.stage += 1;
        true
    }
}

/// What batch number `batch` of the stage number `stage` teaches; nothing if the render is to end.
fn taught(setting: &RenderSetting, [stage, batch]: [u32; 2], guide: &Guide, follow: &Follow<'_>) -> Vec<Lesson> {
    if (setting.is_stopped)() {
        return Vec::new();
    }
    let RenderSetting { sampler, lambda_range: [lo, hi], camera_ray, .. } = setting;
    let mut paths: Vec<PathSample> = (0..BATCH as u32)
        .map(|i| {
            let mut stream = SampleStream::new(*sampler, [COLUMN, stage], batch * BATCH as u32 + i);
            let (film, lens) = (stream.next_2d(), stream.next_2d());
            let lambda = SampledWavelengths::visible(stream.next_1d(), *lo, *hi);
            PathSample::new(camera_ray(film, lens), lambda, stream)
        })
        .collect();
    let mut lessons = Lessons::default();
    follow(guide, &mut paths, &mut PathLog::default(), &mut lessons);
    lessons.finish(|path| paths[path].radiance.mean()).collect()
}
