//! Paths from which a guide learns. They are followed before a wave of samples, as the camera's paths are, but belong to
//! no pixel: what is learned is a function of the seed and of the sample that comes next, whatever part of the picture is rendered.
//! Where nobody has said whether to guide, they begin late, and a trial after a few stages says whether to go on.

use super::{Guide, Lesson, trial};
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample, RenderSetting};
use rayon::prelude::*;
use std::ops::{Range, RangeInclusive};

/// Stages: before which sample, and paths a pixel; the more samples there are to be, the more is worth being known.
const STAGES: [(u32, f64); 6] = [(0, 0.33), (0, 0.33), (0, 0.33), (16, 1.0), (32, 2.0), (64, 4.0)];
/// The sample before which it is found out whether guiding pays, if nobody has said whether to guide: pictures of fewer samples are not worth it. And the
/// stages after which that is.
const TRIED_BEFORE: u32 = 16;
const STAGES_TRIED: u32 = 3;
/// The wave whose photons are those of the trial.
pub const TRIED_WAVE: Range<u32> = 8..16;
/// Pixels of the smallest picture of which that is asked: what is learned takes about as many paths, however few they are.
const LEAST_PIXELS: u64 = 1 << 14;
/// By how much it has to pay.
const LEAST_GAIN: f64 = 1.1;
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

/// How paths are followed: by a guide if there is one, and with lessons to be learned if somebody learns.
pub type Follow<'f> = dyn Fn(Option<&Guide>, &mut [PathSample], &mut PathLog, Option<&mut Lessons>) + Sync + 'f;

/// A guide in training.
pub struct Pilots {
    guide: Guide,
    /// Stages that are done.
    stage: u32,
    /// Whether samples are to be guided: where that is not said, a trial decides before the sample number [`TRIED_BEFORE`].
    is_wanted: Option<bool>,
}

impl Pilots {
    /// Those of a render, if it may be guided; `None` of `is_wanted`: where that pays.
    pub fn new(setting: &RenderSetting, is_wanted: Option<bool>) -> Option<Self> {
        let may_guide = is_wanted.unwrap_or(setting.all_pixels() >= LEAST_PIXELS);
        may_guide.then(|| Self { guide: Guide::new(setting.scene.world.bounds_of_both_sides()), stage: 0, is_wanted })
    }

    /// What was learned, if samples are to be guided.
    pub fn guide(&self) -> Option<&Guide> {
        (self.is_wanted == Some(true)).then_some(&self.guide)
    }

    /// Whether samples are guided, or may yet be.
    pub fn may_guide(&self) -> bool {
        self.is_wanted != Some(false)
    }

    /// Whether a trial is due before the sample number `sample`.
    pub fn tries(&self, sample: u32) -> bool {
        self.is_wanted.is_none() && sample >= TRIED_BEFORE
    }

    /// Learns what is to be known before the sample number `sample`.
    pub fn prepare(&mut self, setting: &RenderSetting, sample: u32, follow: &Follow<'_>) {
        loop {
            if self.tries(sample) && self.stage == STAGES_TRIED {
                let follow = |guide: Option<&Guide>, paths: &mut [PathSample], log: &mut PathLog| follow(guide, paths, log, None);
                let Some(gain) = trial::gain(setting, &self.guide, &follow) else { return };
                self.is_wanted = Some(gain > LEAST_GAIN);
            }
            let Some(paths) = self.next_stage(setting, sample) else { return };
            if !self.train(setting, paths, follow) {
                return;
            }
        }
    }

    /// Paths of the next stage, if it is due before the sample number `sample`. Whichever pixels take part in a wave, there are as many.
    fn next_stage(&self, setting: &RenderSetting, sample: u32) -> Option<u64> {
        if self.is_wanted == Some(false) || (self.is_wanted.is_none() && !self.tries(sample)) {
            return None;
        }
        let (from, per_pixel) = STAGES.get(self.stage as usize)?;
        let paths = (setting.all_pixels() as f64 * per_pixel) as u64;
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
    follow(Some(guide), &mut paths, &mut PathLog::default(), Some(&mut lessons));
    lessons.finish(|path| paths[path].radiance.mean()).collect()
}
