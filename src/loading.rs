//! How far the loading of a scene has come: who loads counts, and somebody else tells.

use crate::say;
use crate::ticker::Ticker;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
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

    /// Tells how far it is, every few seconds until what comes back is dropped; nothing if that is soon.
    pub fn tell(self: &Arc<Self>) -> Ticker {
        let (loading, start) = (Arc::clone(self), Instant::now());
        Ticker::start("loading", || EVERY, move || say!("loading: {:.0} s, {}", start.elapsed().as_secs_f64(), loading.words()))
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
