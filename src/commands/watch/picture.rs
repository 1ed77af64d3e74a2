//! One picture of `bhs watch`: coarse first, then finer and finer.

use super::Watch;
use crate::develop::{self, Texts};
use crate::diagnosis::{self, Level};
use crate::film::{Framebuffer, SeenTile};
use crate::image::Picture;
use crate::lang::BuiltScene;
use crate::message;
use crate::output::OutputFile;
use crate::progress::{Progress, ProgressForm};
use crate::render::{Ended, Job, Limits, RenderState, coarse};
use crate::say;
use crate::signals::Signals;
use serde_json::json;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Side of the squares of the first impression (pixels).
const SQUARE: u32 = 8;
/// Time from the first impression to the next picture, which doubles from picture to picture ...
const NEXT: Duration = Duration::from_millis(500);
/// ... up to this.
const LONGEST: Duration = Duration::from_secs(8);

/// A picture under way.
pub(super) struct Under<'a> {
    pub watch: &'a Watch<'a>,
    pub built: &'a BuiltScene,
    pub file: &'a OutputFile,
}

impl Under<'_> {
    /// Renders it until it is done, or `stop` says so.
    pub fn draw(&self, stop: &Signals) {
        let Self { watch, built, .. } = *self;
        let start = Instant::now();
        let name = self.file.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let job = Job::of(built);
        let Some(first) = watch.pool.install(|| coarse(&job, SQUARE, || stop.stop())) else { return };
        self.write(&first);
        if let Some(display) = &watch.display {
            let of_layers = built.layers.iter().flat_map(|layer| layer.format.channels.iter().map(|c| (*c).to_owned()));
            let channels: Vec<String> = first.channels.iter().cloned().chain(of_layers).collect();
            display.coarse(&name, &channels, first.clone());
        }
        let state = match watch.pool.install(|| RenderState::new(job)) {
            Ok(state) => state,
            Err(error) => return say!("error: {error}"),
        };
        if let Some(display) = &watch.display {
            display.begin(&name, state.shared_frame());
        }
        let most = built.sampler.samples_per_pixel();
        let limits = Limits { time: watch.args.time, ..Limits::of(&*built.sampler) };
        let form = ProgressForm::choose(watch.args.show.progress, watch.args.quiet);
        let progress = Progress::new([state.frame().pixel_count() * u64::from(most), 1], form, [0, 1]);
        progress.picture(String::new(), 0, watch.args.time);
        let ended = std::thread::scope(|scope| {
            let (done, is_done) = mpsc::channel::<()>();
            let frame = state.frame();
            scope.spawn(move || self.write_now_and_then(frame, first, &is_done));
            let ended = watch.pool.install(|| state.run(&limits, &progress, stop));
            drop(done);
            ended
        });
        if matches!(ended, Ended::Stopped(_)) {
            return;
        }
        let rendered = state.rendered(ended);
        progress.picture_done(rendered.samples, true);
        drop(progress);
        self.write(&rendered.frame.picture());
        if let Some(display) = &watch.display {
            display.end(&name, rendered.frame.picture().with_layers(&rendered.frame.layers()));
        }
        let seconds = start.elapsed().as_secs_f64();
        let said = diagnosis::after(built, &rendered);
        if let Some(said) = said.filter(|said| !(watch.args.quiet && said.level == Level::Note)) {
            say!("{said}");
        }
        let what = json!({
            "output": self.file.path().to_string_lossy(),
            "camera": built.camera_name,
            "spp": rendered.samples,
            "seconds": seconds,
            "stopped": ended.name(),
        });
        message::event("picture", what);
        watch.say(&format!("{}: {} spp in {seconds:.1} s", self.file.path().display(), rendered.spp()));
    }

    /// Writes what there is over the first impression, less and less often, until the other end of `done` is gone.
    fn write_now_and_then(&self, frame: &Framebuffer, first: Picture, done: &Receiver<()>) {
        let mut picture = first;
        let mut seen = vec![SeenTile::default(); frame.tiles.len()];
        let mut wait = NEXT;
        while done.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            let n = picture.channels.len();
            for (number, seen) in seen.iter_mut().enumerate() {
                let Some(tile) = frame.news_of(number, seen) else { continue };
                let all = tile.data.len() / (tile.size[0] * tile.size[1]) as usize;
                for (i, values) in tile.data.chunks_exact(all).enumerate() {
                    let (x, y) = (tile.at[0] + i as u32 % tile.size[0], tile.at[1] + i as u32 / tile.size[0]);
                    picture.data[(y as usize * picture.size[0] + x as usize) * n..][..n].copy_from_slice(&values[..n]);
                }
            }
            self.write(&picture);
            wait = (2 * wait).min(LONGEST);
        }
    }

    /// Writes the PNG file.
    fn write(&self, picture: &Picture) {
        let written = self.file.clone().finish(|to| develop::write_png(to, picture, &self.built.look, &Texts::default()));
        if let Err(error) = written {
            say!("error: {error:#}");
        }
    }
}
