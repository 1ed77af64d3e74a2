//! What other programs and people tell this one while it renders: stop, save what there is.
//!
//! An interrupt (Ctrl-C), a request to terminate and a hangup stop a render, which then writes what it has; while the scene is loaded
//! there is nothing to write, and they end the program at once. A second one of them ends it at once in any case. `SIGUSR1` asks for what
//! there is so far, and the render goes on. A hangup that is ignored when the program starts (`nohup`) stays ignored.

use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What may stop a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopSignal {
    /// `SIGINT`: Ctrl-C.
    Interrupt,
    /// `SIGTERM`: what `kill`, batch systems and shutdowns send.
    Terminate,
    /// `SIGHUP`: the terminal is gone.
    Hangup,
}

impl StopSignal {
    const ALL: [Self; 3] = [Self::Interrupt, Self::Terminate, Self::Hangup];

    /// The system's name for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interrupt => "SIGINT",
            Self::Terminate => "SIGTERM",
            Self::Hangup => "SIGHUP",
        }
    }

    /// The exit code of a program that it ends: 128 and its number.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Interrupt => 130,
            Self::Terminate => 143,
            Self::Hangup => 129,
        }
    }
}

/// What has been told so far.
#[derive(Default)]
pub struct Signals {
    stop: AtomicBool,
    /// The first signal that stopped the render: its exit code.
    first: AtomicU8,
    save: AtomicBool,
    /// What is to be done before the program ends at once; `None` while there is nothing that a signal could stop.
    cleanup: Mutex<Option<fn()>>,
    /// Whether the first signal ends it already.
    at_once: AtomicBool,
}

impl Signals {
    /// Listens from now on, on a thread of its own. Until [`Signals::stop_gracefully`] a signal ends the program at once.
    pub fn listen() -> Arc<Self> {
        let signals = Arc::new(Self::default());
        if let Err(error) = system::listen(Arc::clone(&signals)) {
            crate::say!("warning: a signal will lose the picture: {error}");
        }
        signals
    }

    /// From now on the first signal sets [`Signals::stop`], and the next one ends the program at once, after `cleanup`.
    pub fn stop_gracefully(&self, cleanup: fn()) {
        *self.cleanup.lock().unwrap_or_else(PoisonError::into_inner) = Some(cleanup);
    }

    /// From now on the first signal ends the program at once, after `cleanup`.
    pub fn end_at_once(&self, cleanup: fn()) {
        self.at_once.store(true, Ordering::SeqCst);
        self.stop_gracefully(cleanup);
    }

    /// Stops the render as an interrupt does.
    pub fn interrupt(&self) {
        self.first.store(StopSignal::Interrupt.exit_code(), Ordering::SeqCst);
        self.stop.store(true, Ordering::SeqCst);
    }

    /// Whether the render is to stop.
    pub fn stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The signal that stopped the render, if one has.
    pub fn stopped_by(&self) -> Option<StopSignal> {
        let code = self.first.load(Ordering::SeqCst);
        StopSignal::ALL.into_iter().find(|s| s.exit_code() == code)
    }

    /// Whether somebody has asked for what there is, since this was last asked.
    pub fn take_save_request(&self) -> bool {
        self.save.swap(false, Ordering::SeqCst)
    }

    fn receive(&self, signal: StopSignal) {
        let cleanup = *self.cleanup.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(cleanup) = cleanup {
            if !self.stop.load(Ordering::SeqCst) && !self.at_once.load(Ordering::SeqCst) {
                // The reason is there once the flag is.
                self.first.store(signal.exit_code(), Ordering::SeqCst);
                self.stop.store(true, Ordering::SeqCst);
                return;
            }
            cleanup();
        }
        crate::message::end_at_once("stopped", signal.exit_code());
        system::exit(signal.exit_code());
    }

    fn receive_save_request(&self) {
        self.save.store(true, Ordering::SeqCst);
    }
}

#[cfg(unix)]
mod system {
    use super::{Signals, StopSignal};
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
    use std::sync::Arc;

    pub fn listen(to: Arc<Signals>) -> std::io::Result<()> {
        let mut wanted = vec![SIGINT, SIGTERM, SIGUSR1];
        if !is_ignored(SIGHUP) {
            wanted.push(SIGHUP);
        }
        let mut received = signal_hook::iterator::Signals::new(wanted)?;
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in received.forever() {
                match signal {
                    SIGINT => to.receive(StopSignal::Interrupt),
                    SIGTERM => to.receive(StopSignal::Terminate),
                    SIGHUP => to.receive(StopSignal::Hangup),
                    _ => to.receive_save_request(),
                }
            }
        })?;
        Ok(())
    }

    /// Ends the program without another word: other threads are at work on what destructors would take away.
    pub fn exit(code: u8) -> ! {
        signal_hook::low_level::exit(i32::from(code))
    }

    /// Whether the process ignores a signal: asked of the system's own tables, as nothing else tells without changing it.
    fn is_ignored(signal: i32) -> bool {
        let mask = std::fs::read_to_string("/proc/self/status")
            .ok()
            .and_then(|status| status.lines().find_map(|line| line.strip_prefix("SigIgn:")).map(|mask| mask.trim().to_owned()));
        // Where there is no such table, `ps` knows.
        let mask = mask.or_else(|| {
            let id = std::process::id().to_string();
            let told = std::process::Command::new("/bin/ps").args(["-o", "sigignore=", "-p", &id]).output().ok()?;
            Some(String::from_utf8_lossy(&told.stdout).trim().to_owned())
        });
        mask.and_then(|mask| u64::from_str_radix(&mask, 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
    }
}

#[cfg(not(unix))]
mod system {
    use super::{Signals, StopSignal};
    use signal_hook::consts::{SIGINT, SIGTERM};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    /// How often the flags that handlers set are looked at.
    const INTERVAL: Duration = Duration::from_millis(20);

    pub fn listen(to: Arc<Signals>) -> std::io::Result<()> {
        let flags = [(SIGINT, StopSignal::Interrupt), (SIGTERM, StopSignal::Terminate)];
        let flags = flags.map(|(number, signal)| (number, signal, Arc::new(AtomicBool::new(false))));
        for (number, _, flag) in &flags {
            signal_hook::flag::register(*number, Arc::clone(flag))?;
        }
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            loop {
                std::thread::sleep(INTERVAL);
                for (_, signal, flag) in &flags {
                    if flag.swap(false, Ordering::SeqCst) {
                        to.receive(*signal);
                    }
                }
            }
        })?;
        Ok(())
    }

    pub fn exit(code: u8) -> ! {
        std::process::exit(i32::from(code))
    }
}
