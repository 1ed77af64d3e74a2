//! The counts of a render, and what follows of them.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What has been done so far.
pub(super) struct Tally {
    /// Pixel samples of one picture, and the number of pictures of the scene.
    a_picture: u64,
    pictures: u64,
    samples: AtomicU64,
    /// Samples that were there before this process.
    skipped: AtomicU64,
    rays: AtomicU64,
    tiles: AtomicU64,
    start: Instant,
    /// The number of the scene among several, and how many there are.
    of_scenes: [u32; 2],
    picture: Mutex<Picture>,
}

/// The picture under way.
#[derive(Clone)]
pub(super) struct Picture {
    /// What it is called among others, with a comma.
    name: String,
    /// What it may take.
    time: Option<Duration>,
    start: Instant,
    /// Samples of all pictures before it.
    behind: u64,
    /// Samples a pixel: done, and to be done.
    spp: [u32; 2],
    /// Samples that it is expected to have in the end, all pixels together, where that is not what all pictures were to have.
    expected: Option<u64>,
}

/// How far it has come.
pub struct Reached {
    /// What the picture under way is called among others, with a comma.
    pub name: String,
    /// Of the scene.
    pub percent: f64,
    /// Of all scenes.
    pub of_all: f64,
    /// Samples a pixel: done, and to be done.
    pub spp: [u32; 2],
    /// Seconds.
    pub elapsed: f64,
    /// Seconds, as far as they can be foreseen.
    pub remaining: Option<f64>,
    /// Million rays a second.
    pub rate: f64,
}

impl Picture {
    pub fn new(name: String, time: Option<Duration>, behind: u64) -> Self {
        Self { name, time, start: Instant::now(), behind, spp: [0; 2], expected: None }
    }
}

impl Tally {
    pub fn new([a_picture, pictures]: [u64; 2], of_scenes: [u32; 2]) -> Self {
        let [samples, skipped, rays, tiles] = std::array::from_fn(|_| AtomicU64::new(0));
        let picture = Mutex::new(Picture::new(String::new(), None, 0));
        Self { a_picture, pictures, samples, skipped, rays, tiles, start: Instant::now(), of_scenes, picture }
    }

    pub fn since(&self) -> Instant {
        self.start
    }

    pub fn picture(&self, picture: Picture) {
        self.samples.store(picture.behind, Ordering::Relaxed);
        *self.lock() = picture;
    }

    pub fn skip(&self, samples: u64) {
        self.skipped.fetch_add(samples, Ordering::Relaxed);
        self.samples.fetch_add(samples, Ordering::Relaxed);
    }

    pub fn wave(&self, done: u32, total: u32) {
        self.tiles.store(0, Ordering::Relaxed);
        self.lock().spp = [done, total];
    }

    pub fn expect(&self, samples: u64) {
        self.lock().expected = Some(samples.max(1));
    }

    pub fn tile(&self, samples: u64, rays: u64) {
        self.tiles.fetch_add(1, Ordering::Relaxed);
        self.rays.fetch_add(rays, Ordering::Relaxed);
        self.samples.fetch_add(samples, Ordering::Relaxed);
    }

    pub fn picture_done(&self, spp: u32, whole: bool) {
        let mut picture = self.lock();
        picture.spp[0] = spp;
        picture.expected = None;
        if whole {
            self.samples.store(picture.behind + self.a_picture, Ordering::Relaxed);
        }
    }

    /// Tiles of this wave.
    pub fn tiles(&self) -> u64 {
        self.tiles.load(Ordering::Relaxed)
    }

    /// Million rays a second.
    fn rate(&self) -> f64 {
        self.rays.load(Ordering::Relaxed) as f64 / 1e6 / self.start.elapsed().as_secs_f64().max(1e-9)
    }

    pub fn reached(&self) -> Reached {
        let picture = self.lock().clone();
        let elapsed = self.start.elapsed().as_secs_f64();
        let total = self.a_picture.saturating_mul(self.pictures).max(1) as f64;
        let samples = self.samples.load(Ordering::Relaxed);
        let of_picture = samples.saturating_sub(picture.behind) as f64;
        let of_picture = of_picture * picture.expected.map_or(1.0, |expected| self.a_picture as f64 / expected as f64);
        let samples = (picture.behind as f64 + of_picture) / total;
        // What counts where the time is limited: a picture is over with its samples or with its time, whichever comes first.
        let in_time = picture.time.map(|time| (picture.start.elapsed().as_secs_f64() / time.as_secs_f64().max(1e-9)).min(1.0));
        let behind = picture.behind as f64 / total;
        let share = in_time.map_or(samples, |time| samples.max(behind + time / self.pictures.max(1) as f64)).clamp(0.0, 1.0);
        let before = self.skipped.load(Ordering::Relaxed) as f64 / total;
        let remaining = (share > before).then(|| elapsed * (1.0 - share) / (share - before));
        let [number, scenes] = self.of_scenes;
        let of_all = 100.0 * (f64::from(number) + share) / f64::from(scenes.max(1));
        Reached { name: picture.name, percent: 100.0 * share, of_all, spp: picture.spp, elapsed, remaining, rate: self.rate() }
    }

    fn lock(&self) -> MutexGuard<'_, Picture> {
        self.picture.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_samples_or_time_of_all_pictures_and_scenes() {
        // The second of two scenes, with two pictures of 100 samples.
        let tally = Tally::new([100, 2], [1, 2]);
        tally.skip(20);
        tally.tile(30, 1000);
        let Reached { percent, of_all, remaining, .. } = tally.reached();
        assert_eq!((percent, of_all), (25.0, 62.5));
        // What was there before took no time.
        let elapsed = tally.start.elapsed().as_secs_f64();
        assert!(remaining.is_some_and(|left| left <= elapsed * 0.75 / 0.15), "{remaining:?} {elapsed}");
        // Its time is over.
        tally.picture(Picture::new("second".to_owned(), Some(Duration::ZERO), 100));
        assert_eq!(tally.reached().percent, 100.0);
        tally.picture(Picture::new("second".to_owned(), Some(Duration::from_secs(1_000_000)), 100));
        tally.tile(50, 0);
        assert!((75.0..75.01).contains(&tally.reached().percent));
        tally.picture_done(7, true);
        let Reached { percent, of_all, spp, .. } = tally.reached();
        assert_eq!((percent, of_all, spp[0]), (100.0, 100.0, 7));
    }
}
