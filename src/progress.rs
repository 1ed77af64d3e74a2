//! The progress bar on standard error: hidden off a terminal and with `--quiet`.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shows how far a render has come. Told once a tile, never once a sample.
pub struct Progress {
    bar: ProgressBar,
    rays: AtomicU64,
    tiles: AtomicU64,
    start: Instant,
    /// Which picture of several this is, before everything else.
    picture: Mutex<String>,
}

impl Progress {
    /// A bar over `samples` pixel samples in all.
    pub fn new(samples: u64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(samples), target);
        let style = ProgressStyle::with_template("{prefix} [{wide_bar}] {percent:>3} % {msg}, {elapsed} gone, {eta} left");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, rays: AtomicU64::new(0), tiles: AtomicU64::new(0), start: Instant::now(), picture: Mutex::default() }
    }

    /// So many samples were there before.
    pub fn skip(&self, samples: u64) {
        self.bar.inc(samples);
        self.bar.reset_eta();
    }

    /// The next picture begins, where `samples` of all pictures are behind.
    pub fn picture(&self, name: String, samples: u64) {
        *self.picture.lock().unwrap_or_else(PoisonError::into_inner) = name;
        self.bar.set_position(samples);
    }

    /// Does something that may write to standard error, without the bar.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.suspend(work)
    }

    /// A new wave begins; every pixel has `done` of `total` samples.
    pub fn wave(&self, done: u32, total: u32) {
        self.tiles.store(0, Ordering::Relaxed);
        let picture = self.picture.lock().unwrap_or_else(PoisonError::into_inner);
        self.bar.set_prefix(format!("{picture}{done}/{total} spp"));
    }

    /// A tile is done: so many samples, so many rays.
    pub fn tile(&self, samples: u64, rays: u64) {
        let tile = self.tiles.fetch_add(1, Ordering::Relaxed) + 1;
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        self.bar.inc(samples);
        let rate = rays as f64 / 1e6 / self.start.elapsed().as_secs_f64().max(1e-9);
        self.bar.set_message(format!("tile {tile}, {rate:.2} Mray/s"));
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
