//! One picture of `bhs render`: from the first sample, or from a checkpoint, to its files.

use super::outputs::Outputs;
use super::part;
use super::replay::{self, PictureId};
use super::{Common, is_closed_pipe, print};
use crate::checkpoint::{CheckpointFile, Found, Identity};
use crate::cli::RenderArgs;
use crate::denoise::Denoiser;
use crate::diagnosis::{self, BlackFrames, Explanation, Level};
use crate::display::Display;
use crate::finished::{Finished, stats_json};
use crate::lang::BuiltScene;
use crate::message;
use crate::not_finite::{self, SampleId};
use crate::output::{Kept, Rescue};
use crate::parts::{Cover, Windowed};
use crate::progress::Progress;
use crate::render::{Ended, JUDGED_FROM, Job, Limits, RenderState, Rendered};
use crate::say;
use crate::signals::Signals;
use crate::stats::Phases;
use anyhow::Result;
use bhs_core::camera::Film;
use bhs_core::sampling::MOST_SAMPLES;
use serde_json::json;
use std::path::Path;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Time after which the first checkpoint is written: soon, so that there is one to go on from.
const FIRST: Duration = Duration::from_millis(300);
/// How often it is asked whether a checkpoint is due.
const POLL: Duration = Duration::from_millis(50);

/// What a picture is rendered with.
pub(super) struct Session<'s> {
    pub args: &'s RenderArgs,
    pub common: &'s Common,
    pub signals: &'s Signals,
    pub pool: &'s rayon::ThreadPool,
    pub rescue: Rescue,
    /// Takes the noise out of pictures, if that is asked for.
    pub denoiser: Option<&'s Denoiser>,
    /// How far all pictures of the scene have come together.
    pub progress: &'s Progress,
    /// Whether this is one of several frames.
    pub is_film: bool,
    /// Shows the picture meanwhile.
    pub display: Option<&'s Display>,
    /// What has been found of the frames of a film, if this is one of several.
    pub black_frames: Option<&'s BlackFrames>,
}

impl Session<'_> {
    /// The checkpoint of the picture of the current camera, if there is one, and whether it is saved now and then.
    fn checkpoint(built: &BuiltScene, part: Option<Cover>, outputs: &Outputs) -> Option<(CheckpointFile, bool)> {
        let (path, is_saved) = outputs.checkpoint()?;
        let identity = match part {
            None => Identity::of(built),
            Some(Cover { window, samples: [first, _] }) => Identity::of_part(built, window, first),
        };
        Some((CheckpointFile::new(path.to_owned(), identity, built.sampler.depends_on_count()), is_saved))
    }

    /// Renders the picture of the current camera and writes its files. How it ended, and whether all files are in their places.
    ///
    /// # Errors
    /// If a checkpoint cannot be resumed, or a file cannot be written.
    pub fn render(&self, built: &BuiltScene, outputs: Outputs, phases: &mut Phases) -> Result<(Ended, bool)> {
        let Self { args, signals, pool, ref rescue, progress, .. } = *self;
        let part = part::cover(args, built).map_err(anyhow::Error::msg)?;
        let (checkpoint, is_saved) = Self::checkpoint(built, part, &outputs).unzip();
        let checkpoint = checkpoint.as_ref();
        let most = part.map_or(built.sampler.samples_per_pixel(), |cover| cover.samples[1]);
        // What is finished has no wave that would tell of it.
        progress.wave(part.map_or(0, |cover| cover.samples[0]), most);
        if args.resume
            && let Some(cover) = part
            && part::is_there(built, cover, &outputs, args.quiet)
        {
            progress.skip(cover.size());
            progress.picture_done(cover.samples[1], true);
            if let Some(file) = checkpoint {
                file.remove_own();
            }
            return Ok((Ended::Complete, true));
        }
        let windowed = part.map(|cover| Windowed::new(&*built.film, cover.window));
        let film: &dyn Film = windowed.as_ref().map_or(&*built.film, |windowed| windowed);
        let first_sample = part.map_or(0, |cover| cover.samples[0]);
        let limits = Limits {
            most,
            least: args.min_spp.unwrap_or(1).min(most),
            judged_from: args.min_spp.unwrap_or(JUDGED_FROM),
            time: args.time,
        };
        let whole = Job::of(built);
        // Which pixels need more samples shows in all of them only.
        let noise = whole.noise.filter(|_| part.is_none());
        let new = || pool.install(|| RenderState::new(Job { film, first_sample, noise, ..whole }));
        let state = match checkpoint.filter(|_| args.resume) {
            None => new()?,
            Some(file) => {
                let (state, found) = file.resume(new)?;
                if let Some(cover) = part {
                    part::fits(&state, cover, &found)?;
                }
                if self.is_finished(&state, &found, most) {
                    phases.end("render");
                    let rendered = state.rendered(Ended::Complete);
                    progress.picture_done(rendered.samples, true);
                    if let Some(cover) = part {
                        let in_place = part::write(built, cover, &rendered, (&outputs, checkpoint), phases, self);
                        return Ok((Ended::Complete, in_place));
                    }
                    // Whatever ended the program before may have come between the checkpoint and the pictures.
                    let (finished, is_denoised) = self.finish(&rendered, phases);
                    let hold = outputs.hold(built, &finished);
                    let in_place = hold || outputs.write(built, &finished, phases, args.quiet, rescue) == Kept::InPlace;
                    let told = self.announce(built, (&outputs, &finished), phases, in_place);
                    return Ok((Ended::Complete, in_place && is_denoised && told));
                }
                state
            }
        };
        progress.skip(state.frame().samples());
        if let Some(display) = self.display {
            display.begin(&self.shown_as(&outputs), state.shared_frame());
        }
        let is_saved = is_saved == Some(true);
        let saver = Saver { state: &state, file: checkpoint, is_saved, outputs: &outputs, built, session: self };
        let ended = std::thread::scope(|scope| {
            let (done, is_done) = mpsc::channel::<()>();
            let saver = &saver;
            scope.spawn(move || saver.run(&is_done));
            let ended = pool.install(|| state.run(&limits, progress, signals));
            drop(done);
            ended
        });
        phases.end("render");
        progress.aside(|| self.keep((built, part), (&state, ended), (&outputs, checkpoint), phases))
    }

    /// Writes what has been rendered. How it ended, and whether all files are in their places.
    fn keep(
        &self,
        (built, part): (&BuiltScene, Option<Cover>),
        (state, ended): (&RenderState, Ended),
        (outputs, checkpoint): (&Outputs, Option<&CheckpointFile>),
        phases: &mut Phases,
    ) -> Result<(Ended, bool)> {
        let args = self.args;
        if !state.has_samples() {
            if let Ended::Stopped(signal) = ended {
                say!("stopped by {} before there was a sample: nothing is written", signal.name());
            }
            return Ok((ended, true));
        }
        // A part is whole or not there: of one that was stopped there is what it can go on from.
        // First what the render can go on from. The picture is written whether or not that succeeds.
        let saved = checkpoint.filter(|_| part.is_none() || ended != Ended::Complete);
        let saved = saved.map_or(Ok(()), |file| file.save(state));
        phases.end("checkpoint");
        if let Err(error) = &saved {
            say!("error: {error:#}");
        }
        let rendered = state.rendered(ended);
        self.progress.picture_done(rendered.samples, !matches!(ended, Ended::Stopped(_)));
        let picture = PictureId { camera: built.camera_name.as_deref(), variables: &built.variables, seed: self.seed(built) };
        let replay = |sample: &SampleId| replay::command(args, self.common, picture, sample);
        let (count, first) = (rendered.counters.not_finite, &rendered.not_finite);
        not_finite::warnings(count, first, &rendered.frame, built.seed, replay).iter().for_each(|line| say!("{line}"));
        if let Some(cover) = part {
            if ended == Ended::Complete {
                let in_place = part::write(built, cover, &rendered, (outputs, checkpoint), phases, self);
                return Ok((ended, in_place));
            }
            if saved.is_ok()
                && let Some(file) = checkpoint
            {
                say!("stopped: what there is of the part is kept in `{}`, and --resume goes on", file.path().display());
            }
            return Ok((ended, saved.is_ok()));
        }
        let (finished, is_denoised) = self.finish(&rendered, phases);
        let kept = outputs.write(built, &finished, phases, args.quiet, &self.rescue);
        let told = self.announce(built, (outputs, &finished), phases, kept == Kept::InPlace);
        self.explain(built, &rendered, outputs);
        Ok((ended, saved.is_ok() && kept == Kept::InPlace && is_denoised && told))
    }

    /// What has been rendered, denoised if that is asked for, and whether that has succeeded: if not, it is said, and the noisy picture is there.
    fn finish(&self, rendered: &Rendered, phases: &mut Phases) -> (Finished, bool) {
        let mut finished = Finished::of(rendered);
        let Some(denoiser) = self.denoiser else { return (finished, true) };
        let denoised = finished.denoise(denoiser);
        phases.end("denoise");
        if let Err(fault) = &denoised {
            say!("error: the picture cannot be denoised: {fault}; it is written with its noise, and `bhs denoise` can try again");
        }
        (finished, denoised.is_ok())
    }

    /// What a viewer calls the picture: the name of its file, with the folder where there are several scenes.
    fn shown_as(&self, outputs: &Outputs) -> String {
        let path = outputs.exr_path();
        let name = path.file_name().map(Path::new).filter(|_| self.args.of_scenes[1] == 1);
        name.unwrap_or(path).to_string_lossy().into_owned()
    }

    /// Tells the viewer, and programs that listen, of a picture that has been written, as far as it was. Whether they could be told.
    fn announce(&self, built: &BuiltScene, (outputs, finished): (&Outputs, &Finished), phases: &Phases, in_place: bool) -> bool {
        if let Some(display) = self.display {
            display.end(&self.shown_as(outputs), finished.all_channels().into_owned());
        }
        self.tell(built, (outputs.exr_path(), &finished.rendered), phases, in_place)
    }

    /// Tells programs that listen of a picture, or of a part, whose file is `path`. Whether they could be told.
    pub fn tell(&self, built: &BuiltScene, (path, rendered): (&Path, &Rendered), phases: &Phases, in_place: bool) -> bool {
        let what = json!({
            "output": path.to_string_lossy(),
            "camera": built.camera_name,
            "spp": rendered.samples,
            "most_spp": rendered.most_samples,
            "seconds": rendered.seconds,
            "stopped": rendered.ended.name(),
            "in_place": in_place,
        });
        message::event("picture", what);
        if !self.args.prints_stats() {
            return true;
        }
        match print(&format!("{}\n", stats_json(built, rendered, phases))) {
            // Who has read enough does not keep the other pictures from being made.
            Err(error) if !is_closed_pipe(&error) => {
                say!("error: {error:#}");
                false
            }
            _ => true,
        }
    }

    /// Says why the picture shows nothing, if it does and somebody knows.
    fn explain(&self, built: &BuiltScene, rendered: &Rendered, outputs: &Outputs) {
        let is_told = |said: &Explanation| {
            let is_of_another = said.code == diagnosis::EXPOSURE && outputs.shows_layer();
            !(is_of_another || self.args.quiet && said.level == Level::Note)
        };
        let Some(said) = diagnosis::after(built, rendered).filter(is_told) else { return };
        match self.black_frames {
            None => say!("{said}"),
            Some(frames) if frames.tells(said.code) => say!("{said}; so is `{}`", outputs.exr_path().display()),
            Some(_) => {}
        }
    }

    /// The seed of a picture, if it is not the scene's.
    fn seed(&self, built: &BuiltScene) -> Option<u64> {
        self.args.scene_args.seed.or(self.is_film.then_some(built.seed))
    }

    /// Says what was found, and whether nothing is left to be rendered.
    fn is_finished(&self, state: &RenderState, found: &Found, most: u32) -> bool {
        let quiet = self.args.quiet;
        let Found::File(path, warning) = found else {
            if !quiet {
                say!("there is no checkpoint yet: the render starts");
            }
            return false;
        };
        if let Some(warning) = warning {
            say!("warning: {warning}");
        }
        let [samples, more] = state.frame().sample_counts();
        if more > most {
            say!("warning: some pixels have {more} samples in it, more than the {most} that are asked for, and keep them");
        }
        // Pixels that have no more noise than they may have are found out when the next wave begins.
        let finished = samples >= most;
        if !quiet {
            let shown = path.display();
            match finished {
                true => say!("`{shown}` is finished: every pixel has {samples} samples, and {most} are asked for"),
                false if most == MOST_SAMPLES => say!("going on from `{shown}`"),
                false => say!("going on from `{shown}`: every pixel has {samples} samples of {most}"),
            }
        }
        finished
    }
}

/// Samples of a picture, or of a part of it, all pixels together.
pub(super) fn samples(built: &BuiltScene, part: Option<Cover>) -> u64 {
    part.unwrap_or_else(|| Cover::whole(&*built.film, built.sampler.samples_per_pixel())).size()
}

/// Saves a render while it goes on: at intervals, and when somebody asks for it.
struct Saver<'s, 'a> {
    state: &'s RenderState<'a>,
    file: Option<&'s CheckpointFile>,
    /// Whether it is saved now and then, or only when somebody asks, as that of a part may be.
    is_saved: bool,
    outputs: &'s Outputs,
    built: &'s BuiltScene,
    session: &'s Session<'s>,
}

impl Saver<'_, '_> {
    /// Goes on until the other end of `done` is gone.
    fn run(&self, done: &Receiver<()>) {
        let args = self.session.args;
        let is_part = args.parts.is_given();
        let saves = self.is_saved || args.write_partial;
        let mut due = Instant::now() + FIRST.min(args.checkpoint_every);
        while done.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
            let asked = self.session.signals.take_save_request();
            let is_due = saves && Instant::now() >= due;
            if !(asked || is_due) {
                continue;
            }
            if !self.state.pause_and_look() {
                // Nothing yet: soon again.
                due = Instant::now() + FIRST;
                if asked && !args.quiet {
                    say!("there is no sample yet: nothing is written");
                }
                continue;
            }
            if let Some(file) = self.file.filter(|_| self.is_saved || is_part) {
                self.report(file.save(self.state), file.path());
            }
            // A part is whole or not there.
            if (asked || args.write_partial) && !is_part {
                let rendered = self.state.rendered(Ended::Underway);
                self.report(self.outputs.write_partial(self.built, &rendered), self.outputs.exr_path());
            }
            due = Instant::now() + args.checkpoint_every;
        }
    }

    /// A disk that is full now may have room later, and there is still the picture to be made.
    fn report(&self, result: Result<()>, path: &Path) {
        if let Err(error) = result {
            say!("warning: {error:#}; `{}` is as it was, and the render goes on", path.display());
        }
    }
}
