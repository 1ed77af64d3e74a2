//! A thread that does something now and then, until nobody needs it any more: lines on progress and on loading.

use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

/// The thread; it ends when this is dropped.
pub struct Ticker {
    until: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Ticker {
    /// Calls `tick` again and again, each time once `interval` has passed. The thread has the given name; without a thread nothing is done, and
    /// nothing fails.
    pub fn start(name: &str, interval: impl Fn() -> Duration + Send + 'static, tick: impl Fn() + Send + 'static) -> Self {
        let (until, end) = mpsc::channel::<()>();
        let run = move || {
            while end.recv_timeout(interval()) == Err(RecvTimeoutError::Timeout) {
                tick();
            }
        };
        Self { until: Some(until), thread: std::thread::Builder::new().name(name.to_owned()).spawn(run).ok() }
    }
}

impl Drop for Ticker {
    fn drop(&mut self) {
        self.until.take();
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has said so.
            let _ = thread.join();
        }
    }
}
