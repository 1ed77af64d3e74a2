//! Several scenes in one call: one after the other, and one that fails does not stop the others.

use super::outputs::Naming;
use super::{Common, ExitStatus, is_closed_pipe, show};
use crate::cli::RenderArgs;
use crate::display::Display;
use crate::lang;
use crate::lang::{SourceMap, Variables};
use crate::message;
use crate::output::{NamedBy, Plan};
use crate::signals::Signals;
use crate::{output, say};
use anyhow::Result;
use serde_json::json;
use std::path::Path;

/// What is wrong with naming several scenes, if something is: standard input can be read once.
pub(super) fn fault_of_names(scenes: &[impl AsRef<Path>]) -> Option<&'static str> {
    let twice = scenes.iter().filter(|scene| scene.as_ref() == Path::new("-")).count() > 1;
    twice.then_some("standard input is named twice, and can be read only once")
}

/// Renders each of the scenes.
///
/// # Errors
/// None but those of all scenes: those of one are said, and make the exit code 1.
pub(super) fn render(args: &RenderArgs, common: &Common, signals: &Signals, display: Option<&Display>) -> Result<ExitStatus> {
    if let Some(fault) = fault(args) {
        say!("error: {fault}");
        return Ok(ExitStatus::CommandLine);
    }
    if let Some(status) = refuse(args, common) {
        return Ok(status);
    }
    let mut all = ExitStatus::Done;
    for one in args.each() {
        message::event("scene", json!({ "scene": one.scene.to_string_lossy() }));
        message::openjd("status", &one.scene.to_string_lossy());
        let status = super::render::render_one(&one, common, signals, display).unwrap_or_else(|error| {
            if is_closed_pipe(&error) {
                return ExitStatus::Done;
            }
            say!("error: {error:#}");
            ExitStatus::Fault
        });
        match status {
            ExitStatus::Done => {}
            ExitStatus::Fault | ExitStatus::CommandLine => all = ExitStatus::Fault,
            stopped => return Ok(if all == ExitStatus::Done { stopped } else { all }),
        }
        if let Some(signal) = signals.stopped_by() {
            return Ok(if all == ExitStatus::Done { signal.into() } else { all });
        }
    }
    Ok(all)
}

/// What several scenes cannot have in common.
fn fault(args: &RenderArgs) -> Option<String> {
    let count = args.scenes.len();
    let one_file = |flag: &str, instead: &str| Some(format!("{flag} names one file, and there are {count} scenes; {instead}"));
    if args.output.is_some() {
        return one_file("-o", "without it each picture is called as its scene says");
    }
    if args.stats.as_ref().is_some_and(|path| path != Path::new("-")) {
        return one_file("--stats", "`--stats -` prints a line for each picture");
    }
    if matches!(args.checkpoint, Some(Some(_))) {
        return one_file("--checkpoint=FILE", "`--checkpoint` alone saves each beside its picture");
    }
    if args.frames.preview.is_some() {
        return one_file("--preview", "render the films one by one");
    }
    if args.pixel.is_some() {
        return Some(format!("--pixel replays a sample of one picture, and there are {count} scenes"));
    }
    fault_of_names(&args.scenes).map(str::to_owned)
}

/// Says which pictures would be one file, if some would; the scenes are read for that, and not built.
fn refuse(args: &RenderArgs, common: &Common) -> Option<ExitStatus> {
    // Which files the scenes read is looked at when each has its turn.
    let nothing = SourceMap::new();
    let mut plan = Plan::new(&nothing);
    for one in args.each().filter(|one| one.scene != Path::new("-")) {
        let mut sources = common.sources();
        // What is wrong with a scene is said in its turn.
        let Some((filename, cameras)) =
            lang::picture_names(&one.scene, &Variables::defined(&args.scene_args.definitions.define), &mut sources)
        else {
            continue;
        };
        let cameras: Vec<Option<&str>> = match &args.camera {
            Some(camera) => vec![Some(camera.as_str())],
            None => cameras.iter().map(Option::as_deref).collect(),
        };
        for exr in Naming::of(&one).all(&filename, &cameras) {
            plan.claim(&exr.with_extension("png"), NamedBy::CommandLine);
            plan.claim(&exr, NamedBy::CommandLine);
        }
    }
    let mut found = plan.finish().err().unwrap_or_default();
    found.retain(|finding| finding.code == output::COINCIDE);
    show(&found, &nothing, common.color);
    if !found.is_empty() {
        say!("these are pictures of different scenes of this call; nothing has been rendered");
    }
    (!found.is_empty()).then_some(ExitStatus::Fault)
}
