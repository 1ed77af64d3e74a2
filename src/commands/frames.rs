//! `bhs render SCENE --frames A-B`: a picture for each frame and each camera.

use super::naming::{Naming, with_infix};
use super::outputs::Outputs;
use super::part;
use super::picture::{Session, samples};
use super::render::refuse;
use super::several::Earlier;
use super::{Common, ExitStatus, show};
use crate::animation::keys::Keys;
use crate::animation::preview::{self, Format};
use crate::animation::{FrameRange, Ranges, digits};
use crate::cli::RenderArgs;
use crate::denoise::Denoiser;
use crate::diagnosis::{self, BlackFrames};
use crate::display::Display;
use crate::header;
use crate::lang::source::FileCache;
use crate::lang::{self, BuiltScene, FrameCheck, Overrides, SourceMap, Variables};
use crate::output::{self, Kept, NamedBy, OutputFile, OutputSet, Plan, Rescue};
use crate::progress::{Progress, ProgressForm};
use crate::registry::Registry;
use crate::render::Ended;
use crate::signals::Signals;
use crate::stats::Phases;
use crate::threads;
use crate::{report, say};
use anyhow::{Context, Result, anyhow};
use bhs_core::diagnostics::Diagnostic;
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An animation that is asked for.
pub(super) struct Film<'a> {
    pub args: &'a RenderArgs,
    pub range: FrameRange,
    /// What holds for all frames.
    pub overrides: Overrides,
    pub common: &'a Common,
    pub signals: &'a Signals,
    /// Takes the noise out of pictures, if that is asked for.
    pub denoiser: Option<&'a Denoiser>,
    /// What frames make of the files that they share.
    pub cache: Arc<FileCache>,
    /// Shows the pictures meanwhile.
    pub display: Option<&'a Display>,
    /// What other scenes of this call have written.
    pub earlier: &'a Earlier,
    /// What has been found of frames that show nothing.
    pub black: BlackFrames,
}

/// What is written of one frame.
struct FrameOutputs {
    frame: u32,
    /// One for each camera; none if the frame is there already.
    pictures: Vec<Outputs>,
}

/// The film as seen through one camera.
struct Reel {
    /// The PNGs of all frames.
    frames: Vec<PathBuf>,
    preview: Option<OutputFile>,
}

/// What is wrong, with the texts that it is about.
pub(super) type Faults = (Vec<Diagnostic>, SourceMap);

/// Renders all frames.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn render(film: &Film) -> Result<ExitStatus> {
    let args = film.args;
    if args.scene == Path::new("-") {
        say!("error: --frames reads the scene once a frame, and standard input can be read only once; give a file");
        return Ok(ExitStatus::CommandLine);
    }
    let mut phases = Phases::default();
    let registry = Registry::builtin();
    let keys = match film.keys()? {
        Ok(keys) => keys,
        Err((found, sources)) => {
            show(&found, &sources, film.common.color);
            return Ok(ExitStatus::Fault);
        }
    };
    let mut told = BTreeSet::new();
    let first = film.range.first();
    let Some((built, mut sources)) = film.load(first, &keys, &registry, &mut told) else { return Ok(ExitStatus::Fault) };
    phases.end("load");
    if let Some(status) = refuse(args, &built, &sources, film.common) {
        return Ok(status);
    }
    if let Some(path) = &args.frames.keys {
        sources.add_input(path, "the file of keys");
    }
    // Whether all frames can be kept, and made, is found out before the first one is.
    let mut plan = Plan::new(&sources);
    film.earlier.leave(&mut plan);
    let (frames, reels) = film.plan(&built, &mut plan);
    film.earlier.note(&args.scene, &plan);
    if let Err(found) = plan.finish() {
        show(&found, &sources, film.common.color);
        return Ok(ExitStatus::Fault);
    }
    frames.iter().flat_map(|f| &f.pictures).take(reels.len()).try_for_each(Outputs::probe)?;
    reels.iter().filter_map(|r| r.preview.as_ref()).try_for_each(OutputFile::probe)?;
    drop(sources);
    if !film.check(&frames, &keys, &registry)? {
        return Ok(ExitStatus::Fault);
    }
    film.signals.stop_gracefully(output::discard_all);
    let status = film.render_all(frames, built, (&keys, &registry, &mut told), phases)?;
    if matches!(status, ExitStatus::Done | ExitStatus::Fault) {
        let is_written = film.write_previews(&reels);
        return Ok(if is_written { status } else { ExitStatus::Fault });
    }
    Ok(status)
}

/// The keys in a file, or what is wrong with them.
///
/// # Errors
/// If it cannot be read.
pub(super) fn read_keys(path: &Path, common: &Common) -> Result<Result<Keys, Faults>> {
    let mut text = String::new();
    common.open(path)?.read_to_string(&mut text).map_err(|why| anyhow!("cannot read `{}`: {why}", path.display()))?;
    let text = text.trim_start_matches('\u{feff}');
    let mut sources = common.sources();
    let file = sources.add(&path.to_string_lossy(), text);
    Ok(Keys::parse(text, file).map_err(|found| (vec![*found], sources)))
}

impl Film<'_> {
    /// The keys, if there are any; or what is wrong with them.
    fn keys(&self) -> Result<Result<Keys, Faults>> {
        self.args.frames.keys.as_ref().map_or(Ok(Ok(Keys::default())), |path| read_keys(path, self.common))
    }

    /// No texts yet, and what other frames have made of files.
    fn sources(&self) -> SourceMap {
        self.common.sources().keeping(&self.cache)
    }

    /// What holds for one frame.
    fn overrides(&self, frame: u32, keys: &Keys) -> Overrides {
        let variables = Variables {
            keys: keys.at(f64::from(frame)),
            frame: Some(frame),
            frames_per_second: self.args.frames.fps,
            ..self.overrides.variables.clone()
        };
        Overrides { variables, ..self.overrides.clone() }
    }

    /// Loads a frame, and says what is wrong with it. `told` has what has been said of other frames, and need not be said again.
    fn load(&self, frame: u32, keys: &Keys, registry: &Registry, told: &mut BTreeSet<String>) -> Option<(BuiltScene, SourceMap)> {
        let mut sources = self.sources();
        match lang::load(&self.args.scene, registry, &self.overrides(frame, keys), &mut sources) {
            Ok(mut built) => {
                built.warnings.extend(diagnosis::before(&built));
                let is_told = |d: &&Diagnostic| !diagnosis::is_about_the_picture(d) || self.black.tells(d.code);
                let mut is_new =
                    |d: &&Diagnostic| is_told(d) && told.insert(report::render(std::slice::from_ref(*d), &sources, false));
                let new: Vec<Diagnostic> = built.warnings.iter().filter(|d| is_new(d)).cloned().collect();
                show(&new, &sources, self.common.color);
                Some((built, sources))
            }
            Err(found) => {
                show(&found, &sources, self.common.color);
                say!("error: this is wrong with frame {frame}");
                None
            }
        }
    }

    /// The files of all frames. `plan` says what is wrong with them; if it does, some are missing.
    fn plan(&self, built: &BuiltScene, plan: &mut Plan) -> (Vec<FrameOutputs>, Vec<Reel>) {
        let args = self.args;
        let cameras: Vec<Option<&str>> = built.camera_names().collect();
        let mut reels = Vec::new();
        for camera in &cameras {
            let path = args.frames.preview.as_ref().map(|path| match camera.filter(|_| cameras.len() > 1) {
                Some(camera) => with_infix(path, camera),
                None => path.clone(),
            });
            let preview = path.and_then(|path| plan.claim(&path, NamedBy::CommandLine));
            reels.push(Reel { frames: Vec::new(), preview });
        }
        let (mut frames, mut there) = (Vec::new(), Vec::new());
        for frame in self.range.numbers() {
            let naming = Naming::of(args).of_frame(frame);
            let names: Vec<PathBuf> = cameras.iter().map(|camera| naming.exr_of(built, *camera).0).collect();
            reels.iter_mut().zip(&names).for_each(|(reel, exr)| reel.frames.push(exr.with_extension("png")));
            let pictures = if args.frames.skip_existing && names.iter().all(|exr| is_complete(exr, args)) {
                there.push(frame);
                Vec::new()
            } else {
                Outputs::plan(&naming, built, plan)
            };
            frames.push(FrameOutputs { frame, pictures });
        }
        if !there.is_empty() && !args.quiet {
            say!("there already, and left as they are: frames {}", Ranges(&there));
        }
        (frames, reels)
    }

    /// Whether all frames can be made, as far as can be said without the shapes that they share. Says what is wrong with the first that
    /// cannot, and which others there are.
    fn check(&self, frames: &[FrameOutputs], keys: &Keys, registry: &Registry) -> Result<bool> {
        let scene = &self.args.scene;
        let mut wrong = Vec::new();
        let of_first = FrameCheck::of_first(scene, &self.overrides(self.range.first(), keys), &mut self.sources());
        let check = of_first.map_err(|_| anyhow!("the scene `{}` has changed while it was read", scene.display()))?;
        for frame in frames.iter().filter(|f| !f.pictures.is_empty() && f.frame != self.range.first()).map(|f| f.frame) {
            let mut sources = self.sources();
            let found = check.errors(scene, registry, &self.overrides(frame, keys), &mut sources);
            if !found.is_empty() {
                if wrong.is_empty() {
                    show(&found, &sources, self.common.color);
                }
                wrong.push(frame);
            }
        }
        match &wrong[..] {
            [] => return Ok(true),
            [one] => say!("error: this is wrong with frame {one}; nothing has been rendered"),
            [one, ..] => say!(
                "error: this is wrong with frame {one}; of {} frames these have errors: {}; nothing has been rendered",
                frames.len(),
                Ranges(&wrong)
            ),
        }
        Ok(false)
    }

    fn render_all(
        &self,
        frames: Vec<FrameOutputs>,
        built: BuiltScene,
        (keys, registry, told): (&Keys, &Registry, &mut BTreeSet<String>),
        mut phases: Phases,
    ) -> Result<ExitStatus> {
        let args = self.args;
        let pool = threads::start(args.picture.threads)?;
        let pictures: usize = frames.iter().map(|f| f.pictures.len()).sum();
        let a_picture = samples(&built, part::cover(args, &built).map_err(anyhow::Error::msg)?);
        let form = ProgressForm::choose(args.show.progress, args.quiet);
        let progress = Progress::new([a_picture, pictures as u64], form, args.of_scenes);
        let rescue = Rescue::beside(&args.scene, self.common.root.as_ref());
        let session = Session {
            args,
            common: self.common,
            signals: self.signals,
            pool: &pool,
            rescue,
            denoiser: self.denoiser,
            progress: &progress,
            is_film: true,
            display: self.display,
            black_frames: Some(&self.black),
        };
        let mut status = ExitStatus::Done;
        let mut first = Some(built);
        let mut done = 0;
        for FrameOutputs { frame, pictures: outputs } in frames {
            // What the first frame was loaded for serves it alone.
            let loaded = first.take().filter(|_| frame == self.range.first());
            if outputs.is_empty() {
                continue;
            }
            let loaded = loaded.or_else(|| {
                let loaded = progress.aside(|| self.load(frame, keys, registry, told)).map(|(built, _)| built);
                phases.end("load");
                loaded
            });
            let Some(mut built) = loaded else {
                progress.finish();
                return Ok(ExitStatus::Fault);
            };
            for outputs in outputs {
                progress.picture(format!("frame {frame}, {}/{pictures}, ", done + 1), done as u64 * a_picture, args.time);
                let rendered = session.render(&built, outputs, &mut phases).with_context(|| format!("frame {frame}"));
                let (ended, in_place) = rendered.inspect_err(|_| progress.finish())?;
                if !in_place {
                    status = ExitStatus::Fault;
                }
                if let Ended::Stopped(signal) = ended {
                    progress.finish();
                    if !args.quiet {
                        say!(
                            "stopped in frame {frame}; the frames before it are complete, and --skip-existing goes on behind them"
                        );
                    }
                    return Ok(part::stopped(args, status, signal));
                }
                done += 1;
                phases = Phases::default();
                built.next_camera();
            }
        }
        progress.finish();
        Ok(status)
    }

    /// Writes what is asked for of previews, and says how a film is made. Whether all is in its place.
    fn write_previews(&self, reels: &[Reel]) -> bool {
        let args = self.args;
        let seconds = f64::from(self.range.step()) / args.frames.fps;
        let mut in_place = true;
        for reel in reels {
            let there: Vec<PathBuf> = reel.frames.iter().filter(|path| path.exists()).cloned().collect();
            if let Some(file) = &reel.preview
                && let Ok(format) = Format::of(file.path())
                && !there.is_empty()
            {
                let mut set = OutputSet::new();
                set.add(file.clone(), |to| preview::write(to, format, &there, seconds));
                let kept = set.write(&Rescue::beside(&args.scene, self.common.root.as_ref()));
                in_place &= kept == Kept::InPlace;
                if !args.quiet && kept == Kept::InPlace {
                    say!("{}: {} frames", file.path().display(), there.len());
                }
            }
            if let Some(first) = reel.frames.first().filter(|_| !args.quiet && there.len() > 1) {
                say!("a film of them: {}", ffmpeg(first, self.range, args.frames.fps));
            }
        }
        in_place
    }
}

/// Whether a picture is there with all samples that it was to have, and denoised if it is to be.
fn is_complete(exr: &Path, args: &RenderArgs) -> bool {
    if args.parts.is_given() {
        // Whole or not there.
        return exr.exists();
    }
    let is_done = || header::stopped(exr).is_none_or(|why| [Ended::Complete.name(), Ended::TimeOver.name()].contains(&&*why));
    exr.exists() && exr.with_extension("png").exists() && is_done() && (!args.denoise || header::is_denoised(exr))
}

/// The command that makes a film of PNGs, the first of which is `first`.
fn ffmpeg(first: &Path, range: FrameRange, fps: f64) -> String {
    let name = first.to_string_lossy();
    let number = format!(".{}.png", digits(range.first()));
    let stem = name.strip_suffix(&number).unwrap_or(&name);
    let rate = fps / f64::from(range.step());
    let quoted = |text: String| format!("'{}'", text.replace('\'', "'\\''"));
    let input = match range.step() {
        1 => format!("-start_number {} -i {}", range.first(), quoted(format!("{}.%04d.png", stem.replace('%', "%%")))),
        _ => format!("-pattern_type glob -i {}", quoted(format!("{stem}.[0-9][0-9][0-9][0-9].png"))),
    };
    let film = quoted(format!("{stem}.mp4"));
    // Most players want an even number of rows and columns, and colours at half the resolution.
    format!("ffmpeg -framerate {rate} {input} -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p -crf 16 {film}")
}
