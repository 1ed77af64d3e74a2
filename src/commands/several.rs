//! Several scenes in one call: one after the other, and one that fails does not stop the others.

use super::frames::read_keys;
use super::naming::Naming;
use super::{Common, ExitStatus, is_closed_pipe, show};
use crate::cli::RenderArgs;
use crate::display::Display;
use crate::files::{self, FileId};
use crate::lang::{self, PictureNames, SourceMap, Variables};
use crate::message;
use crate::output::{NamedBy, Plan};
use crate::signals::Signals;
use crate::{output, say};
use anyhow::Result;
use bhs_core::diagnostics::Diagnostic;
use serde_json::json;
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// What is wrong with naming several scenes, if something is: standard input can be read once.
pub(super) fn fault_of_names(scenes: &[impl AsRef<Path>]) -> Option<&'static str> {
    let twice = scenes.iter().filter(|scene| scene.as_ref() == Path::new("-")).count() > 1;
    twice.then_some("standard input is named twice, and can be read only once")
}

/// What the scenes of a call have written that have had their turn, with the scene.
#[derive(Default)]
pub(super) struct Earlier(RefCell<Vec<(PathBuf, PathBuf)>>);

impl Earlier {
    /// Keeps `plan` away from these files.
    pub fn leave(&self, plan: &mut Plan) {
        self.0.borrow().iter().for_each(|(scene, path)| plan.leave_to(&format!("`{}` of this call", scene.display()), path));
    }

    /// Notes those of `plan`, of this scene.
    pub fn note(&self, scene: &Path, plan: &Plan) {
        self.0.borrow_mut().extend(plan.claimed().map(|path| (scene.to_owned(), path.to_owned())));
    }
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
    let earlier = Earlier::default();
    for one in args.each() {
        message::event("scene", json!({ "scene": one.scene.to_string_lossy() }));
        message::openjd("status", &one.scene.to_string_lossy());
        let status = super::render::render_one(&one, common, signals, (display, &earlier)).unwrap_or_else(|error| {
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

/// A scene of several, and all that it writes.
struct Planned {
    scene: PathBuf,
    reads: BTreeSet<PathBuf>,
    writes: Vec<PathBuf>,
}

/// Says which pictures would be one file, or would stand in place of what another scene reads, if some would; the scenes are read for that, and
/// not built.
fn refuse(args: &RenderArgs, common: &Common) -> Option<ExitStatus> {
    // What is wrong with a scene is said in its turn.
    let all: Vec<Planned> = args.each().filter_map(|one| planned(&one, common)).collect();
    // What a scene itself reads is looked at when it has its turn.
    let nothing = SourceMap::new();
    let mut plan = Plan::new(&nothing);
    all.iter().flat_map(|one| &one.writes).for_each(|path| drop(plan.claim(path, NamedBy::CommandLine)));
    let mut found = plan.finish().err().unwrap_or_default();
    found.retain(|finding| finding.code == output::COINCIDE);
    found.extend(overwritten(&all));
    show(&found, &nothing, common.color);
    if !found.is_empty() {
        say!("these are files of different scenes of this call; nothing has been rendered");
    }
    (!found.is_empty()).then_some(ExitStatus::Fault)
}

/// What one of the scenes reads and writes; `None` if that cannot be said before its turn.
fn planned(one: &RenderArgs, common: &Common) -> Option<Planned> {
    if one.scene == Path::new("-") {
        return None;
    }
    let frame = one.frames.range.map(|range| range.first());
    let keys = one
        .frames
        .keys
        .as_ref()
        .zip(frame)
        .and_then(|(path, frame)| Some(read_keys(path, common).ok()?.ok()?.at(f64::from(frame))));
    let variables = Variables { keys: keys.unwrap_or_default(), frame, ..Variables::defined(&one.scene_args.definitions.define) };
    let PictureNames { filename, layers, cameras, reads } = lang::picture_names(&one.scene, &variables, &mut common.sources())?;
    let cameras: Vec<Option<&str>> = match &one.camera {
        Some(camera) => vec![Some(camera.as_str())],
        None => cameras.iter().map(Option::as_deref).collect(),
    };
    let layers: BTreeSet<String> = layers.into_iter().chain(super::render::layers(one)).collect();
    let frames = one.frames.range.map_or_else(|| vec![None], |range| range.numbers().map(Some).collect());
    let of_frame = |frame: Option<u32>| {
        let naming = Naming::of(one);
        let naming = frame.map_or(naming.clone(), |frame| naming.of_frame(frame));
        naming.all(&filename, &cameras, &layers)
    };
    Some(Planned { scene: one.scene.clone(), reads, writes: frames.into_iter().flat_map(of_frame).collect() })
}

/// What is to be written that another scene reads.
fn overwritten(all: &[Planned]) -> Vec<Diagnostic> {
    // By what they are, and by their real paths: some are made first, and read then.
    let id = |path: &Path| Some(FileId::of(path, &path.metadata().ok()?));
    let real = |path: &Path| files::resolve(path).ok();
    let (mut by_id, mut by_path) = (HashMap::<_, Vec<_>>::new(), HashMap::<_, Vec<_>>::new());
    for (reader, path) in (0..).zip(all).flat_map(|(i, one): (usize, _)| one.reads.iter().map(move |path| (i, path))) {
        by_id.entry(id(path)).or_default().push((reader, path));
        by_path.entry(real(path)).or_default().push((reader, path));
    }
    let mut found = Vec::new();
    for (writer, path) in (0..).zip(all).flat_map(|(i, one): (usize, _)| one.writes.iter().map(move |path| (i, path))) {
        let of_id = id(path).and_then(|id| by_id.get(&Some(id)));
        let of_path = real(path).and_then(|real| by_path.get(&Some(real)));
        let Some((reader, read)) = of_id.into_iter().chain(of_path).flatten().find(|(reader, _)| *reader != writer) else {
            continue;
        };
        let [writer, reader] = [writer, *reader].map(|i: usize| all[i].scene.display());
        let message = format!("cannot write `{}` of `{writer}`: `{reader}` reads it as `{}`", path.display(), read.display());
        found.push(
            Diagnostic::error(output::IS_INPUT, message)
                .help("render these scenes in calls of their own, or give one of the files another name"),
        );
    }
    found
}
