//! Shows pictures under way in a viewer: tev or HDRView, which listen for them.
//!
//! A thread of its own looks at the tiles now and then and sends those that have changed. It asks nothing of the threads that render: who is
//! at work on a tile keeps it, and the tile is sent another time. What a viewer has not read is not kept, for the tiles are there still; so a
//! viewer that is slow, stalls, goes away or comes late costs neither time nor memory, and changes no picture.

mod address;
mod connection;
mod images;
mod packet;
mod tiles;

pub use address::Address;

use crate::film::Framebuffer;
use crate::image::Picture;
use crate::say;
use connection::{Connection, PATIENCE, has_stalled};
use images::Images;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time between two looks at the tiles: no less than this, ...
const LOOK: Duration = Duration::from_millis(100);
/// ... and so many times what the last one took, so that looking takes little of the processors; ...
const REST: u32 = 25;
/// ... but no more than this.
const LONGEST_REST: Duration = Duration::from_secs(5);
/// Time after which a viewer that is not there is looked for again, and one that did not read.
const AGAIN: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(5)];

/// The viewer, as renders see it.
pub struct Display(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    /// Something is to be sent.
    news: Condvar,
    /// The thread has ended.
    ended: Condvar,
}

#[derive(Default)]
struct State {
    images: Images,
    has_news: bool,
    is_closing: bool,
    has_ended: bool,
}

impl Display {
    /// Looks for the viewer from now on. `quiet`: says nothing of one that is not there.
    pub fn start(address: Address, quiet: bool) -> Self {
        let shared = Arc::new(Shared { state: Mutex::default(), news: Condvar::new(), ended: Condvar::new() });
        let mut sender =
            Sender { shared: Arc::clone(&shared), address, quiet, connection: None, next: Instant::now(), told: [false; 2] };
        let thread = std::thread::Builder::new().name("display".to_owned()).spawn(move || sender.run());
        if let Err(error) = thread {
            say!("warning: the picture is not shown: {error}");
            shared.lock().has_ended = true;
        }
        Self(shared)
    }

    /// An image of this name is rendered from now on.
    pub fn begin(&self, name: &str, frame: &Arc<Framebuffer>) {
        self.change(|images| images.begin(name, frame));
    }

    /// Some of the `channels` of an image, before its tiles come.
    pub fn coarse(&self, name: &str, channels: &[String], picture: Picture) {
        self.change(|images| images.coarse(name, channels, picture));
    }

    /// All of an image in the end, with all its channels.
    pub fn end(&self, name: &str, picture: Picture) {
        self.change(|images| images.end(name, picture));
    }

    fn change(&self, change: impl FnOnce(&mut Images)) {
        let mut state = self.0.lock();
        change(&mut state.images);
        state.has_news = true;
        self.0.news.notify_one();
    }
}

/// Waits until the viewer has been sent everything, but no longer than it may take to read.
impl Drop for Display {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        state.is_closing = true;
        self.0.news.notify_one();
        let waited = self.0.ended.wait_timeout_while(state, PATIENCE, |state| !state.has_ended);
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread that sends.
struct Sender {
    shared: Arc<Shared>,
    address: Address,
    quiet: bool,
    connection: Option<Connection>,
    /// When a viewer is looked for again.
    next: Instant,
    /// Whether it has been said that nobody is there, and that nobody reads.
    told: [bool; 2],
}

impl Sender {
    fn run(&mut self) {
        let mut rest = Duration::ZERO;
        loop {
            let is_closing = {
                let state = self.shared.lock();
                let waits = |state: &mut State| !(state.is_closing || state.has_news);
                let (mut state, _) =
                    self.shared.news.wait_timeout_while(state, rest, waits).unwrap_or_else(PoisonError::into_inner);
                state.has_news = false;
                state.is_closing
            };
            let start = Instant::now();
            let sent = self.send(is_closing);
            // A viewer that went away in the last moment may be back.
            if is_closing && !sent && self.next <= Instant::now() {
                self.send(true);
            }
            if is_closing {
                break;
            }
            rest = (REST * start.elapsed()).clamp(LOOK, LONGEST_REST);
        }
        if let Some(connection) = self.connection.take() {
            connection.close();
        }
        self.shared.lock().has_ended = true;
        self.shared.ended.notify_all();
    }

    /// Sends what there is, if there is a viewer; false if it went away meanwhile.
    fn send(&mut self, is_closing: bool) -> bool {
        if self.connection.as_mut().is_some_and(Connection::is_gone) {
            self.connection = None;
        }
        if self.connection.is_none() && (is_closing || self.next <= Instant::now()) {
            self.connect();
        }
        let Some(connection) = &mut self.connection else { return true };
        let work = self.shared.lock().images.take_work();
        let Err(error) = work.iter().try_for_each(|work| work.send(|packet| connection.send(packet))) else { return true };
        self.connection = None;
        let stalled = has_stalled(&error);
        self.next = Instant::now() + if stalled { AGAIN[1] } else { Duration::ZERO };
        if stalled {
            self.note(1, "does not read; the render goes on");
        }
        false
    }

    fn connect(&mut self) {
        match Connection::open(&self.address) {
            Ok(connection) => {
                self.connection = Some(connection);
                self.shared.lock().images.forget_sent();
            }
            Err(error) => {
                self.next = Instant::now() + AGAIN[0];
                if self.shared.lock().images.is_empty() {
                    return;
                }
                self.note(0, &format!("is not there ({error}); the picture is shown once it is"));
            }
        }
    }

    /// Says something of the viewer, once.
    fn note(&mut self, which: usize, what: &str) {
        if !(self.quiet || std::mem::replace(&mut self.told[which], true)) {
            say!("note: the viewer at {} {what}", self.address);
        }
    }
}
