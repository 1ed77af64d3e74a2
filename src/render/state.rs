//! A render under way: what the threads that render share with the one that saves.

use super::{Counted, Ended, Job, Limits, Rendered, TileWork, Wave};
use crate::film::{Framebuffer, Tile};
use crate::layers::LayerCollector;
use crate::memory::OutOfMemory;
use crate::not_finite::FirstSamples;
use crate::progress::Progress;
use crate::signals::{Signals, StopSignal};
use crate::sky_points;
use crate::wavelengths;
use bhs_core::spectrum::VisibleWavelengths;
use bhs_engine::stats::Counters;
use bhs_engine::transport::{LightTransport, RenderSetting};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, TryLockError};
use std::time::{Duration, Instant};

/// Tiles that wait to be saved at most: threads that change tiles faster than they can be saved wait.
const TILES_TO_SAVE: usize = 64;

/// A render under way.
///
/// Threads change a tile while they hold its lock and share `shared`. Whoever takes `shared` alone therefore has a moment between samples
/// of all tiles. A snapshot marks such a moment and lets the threads go on: who is about to change a tile that the snapshot does not have
/// yet hands over a copy of it first. So saving needs neither the time of the threads nor the memory of a second frame.
pub struct RenderState<'a> {
    job: Job<'a>,
    frame: Arc<Framebuffer>,
    layers: Option<LayerCollector<'a>>,
    wavelengths: VisibleWavelengths,
    shared: RwLock<Shared>,
    counted: Mutex<Counted>,
    /// Set while somebody waits for `shared`: threads let go of it after their batch.
    pause: AtomicBool,
    started: Instant,
    /// Seconds of rendering before this process.
    seconds_before: f64,
}

/// What changes between waves only.
struct Shared {
    /// The transport's memory, if it has one.
    memory: Option<Box<dyn LightTransport>>,
    /// The wave under way: all before it have ended.
    wave: Wave,
    /// Whether the memory has been told of it.
    is_begun: bool,
    /// Number of the latest snapshot, and where its tiles go.
    snapshot: u32,
    sink: Option<SyncSender<SavedTile>>,
}

/// Number of a tile, and what [`Tile::to_bytes`] made of it.
type SavedTile = (usize, Vec<u8>);

/// What a render has found at one moment, but for its tiles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Waves that have ended.
    pub waves: u32,
    /// What was counted.
    pub counters: Counters,
    /// The first of the samples that were not finite.
    pub not_finite: FirstSamples,
    /// Seconds of rendering.
    pub seconds: f64,
}

impl<'a> RenderState<'a> {
    /// A render that has not begun, with the points of the sky that its picture shows, if it has the first sample: of the parts of a picture
    /// those show them. They are found on the current rayon pool.
    ///
    /// # Errors
    /// If there is not enough memory for its frame.
    pub fn new(job: Job<'a>) -> Result<Self, OutOfMemory> {
        let frame = Framebuffer::from_sample(job.first_sample, job.film, job.layers)?
            .with_points((job.first_sample == 0).then(|| sky_points::draw(&job)).flatten());
        Ok(Self {
            frame: Arc::new(if job.noise.is_some() { frame.watching_noise()? } else { frame }),
            layers: LayerCollector::new(job.scene, job.film, job.layers),
            wavelengths: wavelengths::drawn(&job),
            shared: RwLock::new(Shared {
                memory: job.transport.for_render(&job.setting()),
                wave: Wave::of(job.first_sample),
                is_begun: false,
                snapshot: 0,
                sink: None,
            }),
            counted: Mutex::default(),
            pause: AtomicBool::new(false),
            started: Instant::now(),
            seconds_before: 0.0,
            job,
        })
    }

    /// Takes over what a snapshot has; the tiles of [`RenderState::frame`] are restored by the caller.
    pub fn restore(&mut self, snapshot: Snapshot) {
        let shared = self.shared.get_mut().unwrap_or_else(PoisonError::into_inner);
        shared.wave = Wave(snapshot.waves);
        *lock(&self.counted) = Counted { counters: snapshot.counters, not_finite: snapshot.not_finite };
        self.seconds_before = snapshot.seconds;
    }

    /// The frame under way.
    pub fn frame(&self) -> &Framebuffer {
        &self.frame
    }

    /// The same, for whoever looks at it meanwhile: its tiles change.
    pub fn shared_frame(&self) -> &Arc<Framebuffer> {
        &self.frame
    }

    /// Seconds of rendering so far, those before it was resumed included.
    pub fn seconds(&self) -> f64 {
        self.seconds_before + self.started.elapsed().as_secs_f64()
    }

    /// Whether any pixel has a sample. Waits for threads that are at work on a tile.
    pub fn has_samples(&self) -> bool {
        self.frame.sample_counts()[1] > 0
    }

    /// Whether any pixel has a sample, asked in a moment between samples: threads at work count what they have first.
    pub fn pause_and_look(&self) -> bool {
        let _moment = self.shared_alone();
        lock(&self.counted).counters.paths > 0
    }

    /// What there is, and why it ended.
    pub fn rendered(&self, ended: Ended) -> Rendered {
        let [samples, most_samples] = self.frame.pixel_samples();
        let noise = self.job.noise.map(|goal| goal.find(&self.frame));
        let Counted { counters, not_finite } = lock(&self.counted).clone();
        Rendered {
            frame: Arc::clone(&self.frame),
            counters,
            not_finite,
            samples,
            most_samples,
            noise,
            seconds: self.seconds(),
            ended,
        }
    }

    /// Renders on the current rayon pool until `limits` are reached or a signal stops it.
    pub fn run(&self, limits: &Limits, progress: &Progress, signals: &Signals) -> Ended {
        let mut until = limits.time.and_then(|time| Instant::now().checked_add(time));
        let mut is_prepared = false;
        let stopped = || Ended::Stopped(signals.stopped_by().unwrap_or(StopSignal::Interrupt));
        let mut pace = Pace::default();
        loop {
            let done = self.frame.sample_counts()[0];
            if done >= limits.most {
                return Ended::Complete;
            }
            if signals.stop() {
                return stopped();
            }
            // What has to be done is done whatever the time.
            let deadline = until.filter(|_| done >= limits.least);
            let end = self.shared().wave.samples().end.min(limits.most);
            let end = match deadline {
                None if done < limits.least && limits.time.is_some() => end.min(limits.least),
                None => end,
                Some(deadline) => match pace.affordable(deadline) {
                    0 => return Ended::TimeOver,
                    samples => end.min(done.saturating_add(samples)),
                },
            };
            let mut began = Instant::now();
            let is_first = !std::mem::replace(&mut is_prepared, true);
            let late = |deadline: Option<Instant>| deadline.is_some_and(|d| Instant::now() >= d);
            if !self.begin_wave(limits, progress, || signals.stop() || (!is_first && late(deadline))) {
                return Ended::Complete;
            }
            let mut deadline = deadline;
            if is_first {
                // What a resumed render has to find out once more takes nothing of its time, or it might come to no sample for ever.
                let later = |d: Instant| d.checked_add(began.elapsed());
                (until, deadline) = (until.and_then(later), deadline.and_then(later));
                began = Instant::now();
            }
            if signals.stop() {
                return stopped();
            }
            progress.wave(done, limits.most);
            let over = || signals.stop() || late(deadline);
            let advance = |i| self.advance(i, end, progress, &over);
            let whole = (0..self.frame.tiles.len()).into_par_iter().with_max_len(1).map(advance).reduce(|| true, |a, b| a && b);
            if !whole {
                return if signals.stop() { stopped() } else { Ended::TimeOver };
            }
            pace.note(end.saturating_sub(done), began.elapsed());
            let mut shared = self.shared_alone();
            if end >= shared.wave.samples().end {
                shared.wave = shared.wave.next();
                shared.is_begun = false;
            }
        }
    }

    /// Decides which pixels take part in the wave under way, and tells the transport's memory of it, once. False if none does: all have samples enough.
    /// Where the render is `over` meanwhile, the memory may not be ready for it.
    fn begin_wave(&self, limits: &Limits, progress: &Progress, over: impl Fn() -> bool + Send + Sync) -> bool {
        let mut shared = self.shared_alone();
        let samples = shared.wave.samples();
        // A tile that has come further took part in what was decided for this wave.
        let is_new = || self.frame.tiles.iter().all(|tile| lock(tile).progress.is_at(samples.start));
        if let Some(goal) = self.job.noise.filter(|_| samples.start >= limits.judged_from.max(1) && is_new()) {
            let found = goal.plan(&self.frame);
            progress.expect(found.expected);
            if found.above == 0 {
                return false;
            }
        }
        if !std::mem::replace(&mut shared.is_begun, true)
            && let Some(memory) = &mut shared.memory
        {
            let setting = self.job.setting();
            let pixels = if self.job.noise.is_some() { self.frame.pixels_under_way() } else { setting.pixels };
            memory.begin_wave(&RenderSetting { pixels, is_stopped: Arc::new(&over), ..setting }, samples);
            // It may have left off: then the wave begins anew whenever the render goes on.
            shared.is_begun = !over();
        }
        true
    }

    /// Brings a tile to `end` samples a pixel; false if it is `over` before.
    fn advance(&self, number: usize, end: u32, progress: &Progress, over: &(impl Fn() -> bool + Sync)) -> bool {
        loop {
            if over() {
                return false;
            }
            let shared = self.shared();
            let mut tile = lock(&self.frame.tiles[number]);
            if tile.progress.position == 0 {
                if tile.progress.done >= end {
                    return true;
                }
                tile.progress.end = end;
            }
            shared.hand_over(number, &mut tile);
            let job = Job { transport: shared.memory.as_deref().unwrap_or(self.job.transport), ..self.job };
            let work = TileWork {
                job: &job,
                layers: self.layers.as_ref(),
                wavelengths: &self.wavelengths,
                channels: self.frame.channel_count(),
            };
            let before = tile.samples();
            let counted = work.advance(&mut tile, || self.pause.load(Ordering::Relaxed) || over());
            // Within the moment: a snapshot has the counts of the samples that it has.
            let mut all = lock(&self.counted);
            all.counters += counted.counters;
            all.not_finite.merge(&counted.not_finite);
            drop(all);
            progress.tile(tile.samples() - before, counted.counters.geodesics);
        }
    }

    /// Calls `begin` with what there is at this moment, and then `tile` with each tile as it was then, in any order: its number, and
    /// what [`Tile::to_bytes`] made of it. Threads go on meanwhile.
    ///
    /// # Errors
    /// The first of the functions.
    pub fn snapshot<E>(
        &self,
        begin: impl FnOnce(&Snapshot) -> Result<(), E>,
        mut each: impl FnMut(usize, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (sink, changed) = sync_channel(TILES_TO_SAVE);
        let (number, snapshot) = {
            let mut shared = self.shared_alone();
            shared.snapshot = shared.snapshot.wrapping_add(1);
            shared.sink = Some(sink);
            let Counted { counters, not_finite } = lock(&self.counted).clone();
            let snapshot = Snapshot { waves: shared.wave.0, counters, not_finite, seconds: self.seconds() };
            (shared.snapshot, snapshot)
        };
        begin(&snapshot)?;
        let mut left: Vec<usize> = (0..self.frame.tiles.len()).collect();
        let mut missing = left.len();
        while missing > 0 {
            let missing_before = missing;
            let mut failed = None;
            left.retain(|&i| {
                // What threads wait to change comes first.
                for (i, bytes) in changed.try_iter() {
                    missing -= 1;
                    failed = failed.take().or(each(i, &bytes).err());
                }
                let mut tile = match self.frame.tiles[i].try_lock() {
                    Ok(tile) => tile,
                    Err(TryLockError::Poisoned(tile)) => tile.into_inner(),
                    Err(TryLockError::WouldBlock) => return true,
                };
                if tile.snapshot != number && failed.is_none() {
                    tile.snapshot = number;
                    let bytes = tile.to_bytes();
                    drop(tile);
                    missing -= 1;
                    failed = each(i, &bytes).err();
                }
                false
            });
            if let Some(error) = failed {
                return Err(error);
            }
            if missing == missing_before
                && let Ok((i, bytes)) = changed.recv_timeout(Duration::from_millis(5))
            {
                missing -= 1;
                each(i, &bytes)?;
            }
        }
        Ok(())
    }

    fn shared(&self) -> RwLockReadGuard<'_, Shared> {
        self.shared.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until no thread is at work, and keeps them from it.
    fn shared_alone(&self) -> std::sync::RwLockWriteGuard<'_, Shared> {
        self.pause.store(true, Ordering::Relaxed);
        let shared = self.shared.write().unwrap_or_else(PoisonError::into_inner);
        self.pause.store(false, Ordering::Relaxed);
        shared
    }
}

impl Shared {
    /// Saves a tile that is about to change, if the latest snapshot does not have it yet.
    fn hand_over(&self, number: usize, tile: &mut Tile) {
        if tile.snapshot != self.snapshot
            && let Some(sink) = &self.sink
        {
            tile.snapshot = self.snapshot;
            // Nobody takes it where saving has failed.
            let _ = sink.send((number, tile.to_bytes()));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long a sample of all pixels takes: the last round's mean.
#[derive(Default)]
struct Pace(Option<Duration>);

impl Pace {
    fn note(&mut self, samples: u32, took: Duration) {
        self.0 = took.checked_div(samples).or(self.0);
    }

    /// Samples of all pixels that can be made before `deadline`, so that all pixels end with the same number of them; one at least where
    /// that is not known.
    fn affordable(&self, deadline: Instant) -> u32 {
        let left = deadline.saturating_duration_since(Instant::now());
        match self.0 {
            _ if left.is_zero() => 0,
            Some(pace) => (left.as_secs_f64() / pace.as_secs_f64().max(1e-9)) as u32,
            None => 1,
        }
    }
}
