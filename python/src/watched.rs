//! Work that threads do while Python stays awake: signals are heard, and whoever wants to know is told how far it is.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// How often Python's signal handlers are asked.
const POLL: Duration = Duration::from_millis(50);
/// How long work that has been told to stop is waited for. What is in the middle of something that cannot be stopped, such as reading a mesh, ends by itself
/// later, and nobody looks at what comes of it.
const GRACE: Duration = Duration::from_millis(400);
/// As the main thread of a program has it: scenes may be nested.
const STACK: usize = 8 << 20;

/// Does `work` without holding the interpreter. Now and then, and once in the end, it calls `tell` with it. If a signal handler raises an exception, as that of
/// Ctrl-C does, or `tell` does, `stop` is called, and that exception comes out.
pub fn watched<T: Send + 'static>(
    py: Python,
    work: impl FnOnce() -> T + Send + 'static,
    stop: impl Fn(),
    mut tell: impl FnMut() -> PyResult<()>,
) -> PyResult<T> {
    let (done, result) = sync_channel(1);
    let thread = thread::Builder::new().name("bhs".to_owned()).stack_size(STACK).spawn(move || {
        // Nobody waits for what was stopped.
        let _ = done.send(work());
    })?;
    // Receivers are of one thread: this one, which lets go of the interpreter while it waits.
    let result = std::sync::Mutex::new(result);
    let wait = |time: Duration| {
        py.detach(|| {
            let result = result.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            result.recv_timeout(time)
        })
    };
    loop {
        match wait(POLL) {
            Ok(value) => {
                // It has nothing left to do.
                let _ = thread.join();
                tell()?;
                return Ok(value);
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals().and_then(|()| tell()) {
                    stop();
                    let until = Instant::now() + GRACE;
                    let _ = wait(until.saturating_duration_since(Instant::now()));
                    return Err(raised);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                let panic = thread.join().err();
                let said = panic
                    .as_ref()
                    .and_then(|p| p.downcast_ref::<String>().map(String::as_str).or(p.downcast_ref::<&str>().copied()));
                return Err(PyRuntimeError::new_err(format!(
                    "this is a fault of bhs, please report it: {}",
                    said.unwrap_or("a thread has panicked")
                )));
            }
        }
    }
}
