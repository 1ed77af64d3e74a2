//! How far the loading of a scene has come: who loads counts, and somebody else tells.

use crate::say;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time before the first line, and between two.
const EVERY: Duration = Duration::from_secs(3);

/// What has been loaded. Nothing that is loaded depends on it.
#[derive(Debug, Default)]
pub struct Loading {
    bytes: AtomicU64,
    shapes: AtomicU64,
    all_shapes: AtomicU64,
}

impl Loading {
    /// A file of so many bytes has been read.
    pub fn read(&self, bytes: usize) {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// `made` of the scene's `all` shapes have been made.
    pub fn shapes(&self, made: usize, all: usize) {
        self.shapes.store(made as u64, Ordering::Relaxed);
        self.all_shapes.store(all as u64, Ordering::Relaxed);
    }

    /// It in words that can follow "loading: ".
    fn words(&self) -> String {
        let [bytes, made, all] = [&self.bytes, &self.shapes, &self.all_shapes].map(|n| n.load(Ordering::Relaxed));
        let read = format!("{:.2} GB read", bytes as f64 / 1e9);
        match all {
            0 => read,
            _ if made < all => format!("{read}, {made} of {all} shapes made"),
            _ => format!("{read}, all shapes made, surfaces are sorted by place"),
        }
    }
}

/// Tells how far loading is, every few seconds until it is dropped.
pub struct Told {
    until: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Told {
    /// Tells of `loading`, unless it is soon done.
    pub fn of(loading: &Arc<Loading>) -> Self {
        let (until, end) = mpsc::channel::<()>();
        let (loading, start) = (Arc::clone(loading), Instant::now());
        let write = move || {
            while end.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                say!("loading: {:.0} s, {}", start.elapsed().as_secs_f64(), loading.words());
            }
        };
        // Without a thread nothing is told, and the scene is loaded all the same.
        let thread = std::thread::Builder::new().name("loading".to_owned()).spawn(write).ok();
        Self { until: Some(until), thread }
    }
}

impl Drop for Told {
    fn drop(&mut self) {
        self.until = None;
        if let Some(thread) = self.thread.take() {
            // It has nothing to return, and what it may have failed at was told.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_how_far_it_is() {
        let loading = Loading::default();
        loading.read(1_500_000_000);
        assert_eq!(loading.words(), "1.50 GB read");
        loading.shapes(3, 7);
        assert_eq!(loading.words(), "1.50 GB read, 3 of 7 shapes made");
        loading.shapes(7, 7);
        assert_eq!(loading.words(), "1.50 GB read, all shapes made, surfaces are sorted by place");
    }
}
