//! How far a render has come, as standard error shows it: a bar, lines for people, or lines for programs.
//!
//! Threads that render count, once a tile and never once a sample; somebody else reads the counts and writes.

mod form;
mod tally;

pub use form::ProgressForm;

use crate::message;
use crate::ticker::Ticker;
use bhs_core::sampling::MOST_SAMPLES;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::sync::Arc;
use std::time::{Duration, Instant};
pub use tally::Reached;
use tally::{Picture, Tally};

/// Time between two lines for people: at first, and after [`FIRST`].
const LINES: [Duration; 2] = [Duration::from_secs(3), Duration::from_secs(5)];
/// How long lines come at first.
const FIRST: Duration = Duration::from_secs(60);
/// Time between two lines for programs.
const EVENTS: Duration = Duration::from_secs(1);

/// Shows how far a render has come.
pub struct Progress {
    tally: Arc<Tally>,
    shown: Shown,
}

/// Where it is shown.
enum Shown {
    Nowhere,
    Bar(ProgressBar),
    /// By a thread of its own.
    Lines {
        form: ProgressForm,
        _writer: Ticker,
    },
}

impl Progress {
    /// Shows nothing.
    pub fn hidden() -> Self {
        Self { tally: Arc::new(Tally::new([0, 1], [0, 1])), shown: Shown::Nowhere }
    }

    /// Shows how much is done of so many pictures, of so many pixel samples each: `[samples, pictures]`. `of_scenes`: their scene's number
    /// among several, from 0, and how many there are.
    pub fn new(pictures: [u64; 2], form: ProgressForm, of_scenes: [u32; 2]) -> Self {
        let tally = Arc::new(Tally::new(pictures, of_scenes));
        let shown = match form {
            ProgressForm::None => Shown::Nowhere,
            ProgressForm::Tty => {
                let bar = bar();
                message::keep_clear_of(Some(&bar));
                Shown::Bar(bar)
            }
            ProgressForm::Lines | ProgressForm::Json | ProgressForm::Openjd => {
                let (of_interval, of_line) = (Arc::clone(&tally), Arc::clone(&tally));
                let (pause, line) = (move || interval(form, of_interval.since()), move || tell(form, &of_line.reached()));
                Shown::Lines { form, _writer: Ticker::start("progress", pause, line) }
            }
        };
        Self { tally, shown }
    }

    /// The next picture begins: what it is called among others, and where `samples` of all pictures are behind. `time`: what it may take.
    pub fn picture(&self, name: String, samples: u64, time: Option<Duration>) {
        if !name.is_empty() {
            message::openjd("status", name.trim_end_matches([',', ' ']));
        }
        self.tally.picture(Picture::new(name, time, samples));
        if let Shown::Bar(bar) = &self.shown {
            bar.set_position(position(&self.tally.reached()));
        }
    }

    /// So many samples of the picture were there before.
    pub fn skip(&self, samples: u64) {
        self.tally.skip(samples);
        if let Shown::Bar(bar) = &self.shown {
            bar.set_position(position(&self.tally.reached()));
            bar.reset_eta();
        }
    }

    /// Does something that may write to standard error, without the bar.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        match &self.shown {
            Shown::Bar(bar) => {
                message::keep_clear_of(None);
                let done = bar.suspend(work);
                message::keep_clear_of(Some(bar));
                done
            }
            _ => work(),
        }
    }

    /// A new wave begins; every pixel has `done` of `total` samples.
    pub fn wave(&self, done: u32, total: u32) {
        self.tally.wave(done, total);
        if let Shown::Bar(bar) = &self.shown {
            bar.set_prefix(format!("{}{} spp", self.tally.reached().name, of_total([done, total])));
        }
    }

    /// The picture under way is expected to have so many samples in the end, all pixels together.
    pub fn expect(&self, samples: u64) {
        self.tally.expect(samples);
    }

    /// A tile is done: so many samples, so many rays.
    pub fn tile(&self, samples: u64, rays: u64) {
        self.tally.tile(samples, rays);
        if let Shown::Bar(bar) = &self.shown {
            let reached = self.tally.reached();
            bar.set_position(position(&reached));
            bar.set_message(format!("tile {}, {:.2} Mray/s", self.tally.tiles(), reached.rate));
        }
    }

    /// A picture is over, with so many samples in every pixel; `whole`: with all that it was to have.
    pub fn picture_done(&self, spp: u32, whole: bool) {
        self.tally.picture_done(spp, whole);
        // Short renders end before the first line is due; programs hear of them all the same.
        if let Shown::Lines { form, .. } = &self.shown
            && *form != ProgressForm::Lines
        {
            tell(*form, &self.tally.reached());
        }
    }

    /// How far it is.
    pub fn reached(&self) -> Reached {
        self.tally.reached()
    }

    /// Takes the bar away; no more lines come.
    pub fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            message::keep_clear_of(None);
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Samples that are done of those that are to be done, where that has an end.
fn of_total([done, total]: [u32; 2]) -> String {
    if total == MOST_SAMPLES { done.to_string() } else { format!("{done}/{total}") }
}

/// Where the bar is full.
const FULL: u64 = 10_000;

/// How far the bar is.
fn position(reached: &Reached) -> u64 {
    (FULL as f64 * reached.percent / 100.0) as u64
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(FULL), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{prefix} [{wide_bar}] {percent:>3} % {msg}, {elapsed} gone, {eta} left");
    if let Ok(style) = style {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Time to the next line.
fn interval(form: ProgressForm, since: Instant) -> Duration {
    match form {
        ProgressForm::Lines if since.elapsed() < FIRST => LINES[0],
        ProgressForm::Lines => LINES[1],
        _ => EVENTS,
    }
}

/// Writes a line.
fn tell(form: ProgressForm, reached: &Reached) {
    let Reached { name, percent, of_all, spp: [done, total], elapsed, remaining, rate } = reached;
    match form {
        // What follows takes no samples, and the closing words come soon.
        ProgressForm::Lines if *percent >= 100.0 => {}
        ProgressForm::Lines => {
            let left = remaining.map_or(String::new(), |left| format!(", {} left", short(left)));
            let gone = short(*elapsed);
            crate::say!(
                "progress: {percent:5.1} %, {name}{} spp, {rate:.2} Mray/s, {gone} gone{left}",
                of_total([*done, *total])
            );
        }
        ProgressForm::Json => message::event(
            "progress",
            json!({
                "percent": (10.0 * of_all).round() / 10.0,
                "picture": name.trim_end_matches([',', ' ']),
                "spp": done,
                "total_spp": (*total != MOST_SAMPLES).then_some(*total),
                "elapsed": (1e3 * elapsed).round() / 1e3,
                "remaining": remaining.map(|left| (1e3 * left).round() / 1e3),
                "mray_per_second": (1e3 * rate).round() / 1e3,
            }),
        ),
        ProgressForm::Openjd => message::openjd("progress", &format!("{of_all:.1}")),
        ProgressForm::Tty | ProgressForm::None => {}
    }
}

/// A time as people read it.
fn short(seconds: f64) -> String {
    let s = seconds.round() as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{}:{:02} min", s / 60, s % 60),
        _ => format!("{}:{:02} h", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short() {
        assert_eq!([0.2, 59.4, 61.0, 3599.0, 7384.0].map(short), ["0 s", "59 s", "1:01 min", "59:59 min", "2:03 h"]);
    }
}
