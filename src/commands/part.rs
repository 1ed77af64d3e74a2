//! `bhs render SCENE --samples A..B` and `--part K/N`: a part of a picture, in a file that `bhs merge` reads.

use super::ExitStatus;
use super::outputs::Outputs;
use super::picture::Session;
use crate::checkpoint::{CheckpointFile, Found};
use crate::cli::RenderArgs;
use crate::finished::stats_json;
use crate::lang::BuiltScene;
use crate::output::{Kept, OutputSet};
use crate::parts::Cover;
use crate::parts::file::{self, PartHead};
use crate::render::{RenderState, Rendered};
use crate::say;
use crate::signals::StopSignal;
use crate::stats::Phases;
use anyhow::{Result, bail};
use bhs_core::sampling::MOST_SAMPLES;
use std::io::Write;

/// How the names of parts end.
pub(super) const ENDING: &str = "bhspart";

/// What is rendered of the current picture of a scene; `None`: all of it.
///
/// # Errors
/// If that cannot be a part.
pub(super) fn cover(args: &RenderArgs, built: &BuiltScene) -> Result<Option<Cover>, String> {
    if args.parts.is_given() && built.sampler.noise_target().is_some() && built.sampler.samples_per_pixel() == MOST_SAMPLES {
        return Err("pixels of parts all have as many samples, whatever the sampler's `noise`; --spp says how many".to_owned());
    }
    args.parts.cover(&*built.film, built.sampler.samples_per_pixel(), args.picture.crop)
}

/// Why the command line asks for something else than parts, if it does.
pub(super) fn unfit(args: &RenderArgs) -> Option<String> {
    if !args.parts.is_given() {
        return None;
    }
    let flags = [
        ("--time", args.time.is_some(), "gives pixels as many samples as there is time for, and does not split into parts"),
        ("--noise-over", args.noise_over.is_some(), "belongs to --noise, which does not split into parts"),
        ("--min-spp", args.min_spp.is_some(), "belongs to --time and --noise, which do not split into parts"),
        ("--write-partial", args.write_partial, "writes pictures, and a part is none; --checkpoint keeps what there is of it"),
        (
            "--layer",
            args.look.layer.is_some(),
            "is for pictures, and a part is none; `bhs develop` shows layers of the merged one",
        ),
        ("--false-color", args.look.false_color, "writes pictures, and a part is none; `bhs merge --false-color` does"),
        (
            "--denoise",
            args.denoise,
            "is for pictures, and a part is none; give all parts `--aov albedo --aov normal`, and `bhs denoise` the merged one",
        ),
        ("--display-server", args.show.display_server.is_some(), "shows pictures, and a part is none"),
        ("--preview", args.frames.preview.is_some(), "shows pictures, and a part is none"),
        ("--pixel", args.pixel.is_some(), "replays a sample, whatever the part"),
    ];
    let (flag, _, why) = flags.into_iter().find(|(_, is_given, _)| *is_given)?;
    Some(format!("{flag} {why}"))
}

/// Whether the file of a part is there, whole. Says so.
pub(super) fn is_there(built: &BuiltScene, cover: Cover, outputs: &Outputs, quiet: bool) -> bool {
    let path = outputs.exr_path();
    let is_there = path.exists() && file::holds(path, &PartHead::of(built, cover, outputs.frame), (&*built.film, &built.layers));
    if is_there && !quiet {
        say!("`{}` is there already, and whole: {cover}", path.display());
    }
    is_there
}

/// Makes sure that a part can go on from what it has found.
///
/// # Errors
/// If that is of a part with the same first sample, and has samples that this one is not to have.
pub(super) fn fits(state: &RenderState, cover: Cover, found: &Found) -> Result<()> {
    let (Found::File(path, _), [_, most]) = (found, state.frame().sample_counts()) else { return Ok(()) };
    let end = cover.samples[1];
    if most > end {
        let path = path.display();
        bail!(
            "cannot resume from `{path}`: it is of a longer part, with samples up to {most}, and this one ends at {end}; \
             delete it, or give this part another -o"
        );
    }
    Ok(())
}

/// Writes a part that is whole, and removes what it would have gone on from. Whether it is in its place, and all who listen know.
pub(super) fn write(
    built: &BuiltScene,
    cover: Cover,
    rendered: &Rendered,
    (outputs, checkpoint): (&Outputs, Option<&CheckpointFile>),
    phases: &mut Phases,
    session: &Session,
) -> bool {
    let head = PartHead::of(built, cover, outputs.frame);
    let mut set = OutputSet::new();
    let (part, stats) = outputs.part_files();
    set.add(part.clone(), |to| Ok(file::write(to, &head, rendered)?));
    if let Some(stats) = stats {
        let phases = &*phases;
        set.add(stats.clone(), move |to| {
            let mut phases = phases.clone();
            phases.end("write");
            Ok(writeln!(to, "{}", serde_json::to_string_pretty(&stats_json(built, rendered, &phases))?)?)
        });
    }
    let in_place = set.write(&session.rescue) == Kept::InPlace;
    phases.end("write");
    if in_place {
        if let Some(file) = checkpoint {
            // It is of no more use.
            file.remove_own();
        }
        if !session.args.quiet {
            say!("{}: {cover}, in {:.1} s, {:.1} s in all", outputs.exr_path().display(), rendered.seconds, phases.total());
        }
    }
    session.tell(built, (outputs.exr_path(), rendered), phases, in_place) && in_place
}

/// The exit code of a render that a signal has stopped: of a part that is kept, that it can be tried again.
pub(super) fn stopped(args: &RenderArgs, status: ExitStatus, signal: StopSignal) -> ExitStatus {
    match status {
        ExitStatus::Done if args.parts.is_given() => ExitStatus::TryAgain,
        ExitStatus::Done => signal.into(),
        other => other,
    }
}
