//! The files of a picture: their names, and how they are written.

use super::finished::Finished;
use super::part;
use super::render::{closing_words, stats_json};
use crate::animation::digits;
use crate::checkpoint::{self, previous};
use crate::cli::RenderArgs;
use crate::develop::{self, Content, Texts};
use crate::false_color::{self, FalseColor};
use crate::files::FileId;
use crate::image::Picture;
use crate::lang::BuiltScene;
use crate::layers::LayerPicture;
use crate::output::{Kept, NamedBy, OutputFile, OutputSet, Plan, Rescue};
use crate::parts::PartArgs;
use crate::render::Rendered;
use crate::say;
use crate::stats::Phases;
use anyhow::Result;
use bhs_core::diagnostics::Diagnostic;
use bhs_engine::layer::NamedLayer;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// What the names of a scene's outputs are made from.
pub(super) struct Naming<'a> {
    /// The scene; `-` is standard input.
    scene: &'a Path,
    /// The EXR file and the stats that the command line names.
    output: Option<&'a Path>,
    stats: Option<&'a Path>,
    quick: bool,
    false_color: bool,
    /// The layer that the PNG shows in place of the picture.
    layer: Option<&'a str>,
    no_overwrite: bool,
    /// The number of the frame, if it is one of several.
    frame: Option<u32>,
    /// Knows whether there is to be a checkpoint, and where.
    args: Option<&'a RenderArgs>,
}

impl<'a> Naming<'a> {
    /// As the command line says.
    pub fn of(args: &'a RenderArgs) -> Self {
        Self {
            output: args.output.as_deref(),
            stats: args.stats.as_deref().filter(|_| !args.prints_stats()),
            quick: args.quick,
            false_color: args.look.false_color,
            layer: args.look.layer.as_deref(),
            no_overwrite: args.no_overwrite,
            args: Some(args),
            ..Self::without_flags(&args.scene)
        }
    }

    /// As the scene says.
    pub fn without_flags(scene: &'a Path) -> Self {
        Self {
            scene,
            output: None,
            stats: None,
            quick: false,
            false_color: false,
            layer: None,
            no_overwrite: false,
            frame: None,
            args: None,
        }
    }

    /// The same of one of several frames.
    pub fn of_frame(self, frame: u32) -> Self {
        Self { frame: Some(frame), ..self }
    }

    /// Which part of a picture is rendered, if it is one.
    fn part(&self) -> Option<&'a PartArgs> {
        self.args.map(|args| &args.parts).filter(|parts| parts.is_given())
    }

    /// The name of one of several frames.
    fn numbered(&self, path: PathBuf) -> PathBuf {
        self.frame.map_or(path.clone(), |frame| with_infix(&path, &digits(frame)))
    }

    /// Of the files that the command line names once for all cameras and frames: that of one of them.
    pub fn own_name(&self, path: &Path, camera: Option<&str>) -> PathBuf {
        self.numbered(camera.map_or(path.to_owned(), |camera| with_infix(path, camera)))
    }

    /// The EXR file of the only picture of a scene, and where its name comes from.
    pub fn exr(&self, built: &BuiltScene) -> (PathBuf, NamedBy) {
        if let Some(path) = self.output {
            return (path.to_owned(), NamedBy::CommandLine);
        }
        let filename = built.film.filename();
        let span = built.filename_span.filter(|_| !filename.is_empty());
        (self.called(filename), NamedBy::Scene(span))
    }

    /// The EXR file of the only picture of a scene whose film has this `filename`, which may be empty.
    fn called(&self, filename: &str) -> PathBuf {
        if !filename.is_empty() {
            return filename.into();
        }
        let mut name = match self.scene.file_stem() {
            Some(stem) if self.scene != Path::new("-") => stem.to_owned(),
            _ => OsString::from("bhs"),
        };
        name.push(".exr");
        name.into()
    }

    /// The EXR files of a scene whose film has this `filename` and that has these cameras, if -o names none.
    pub fn all(&self, filename: &str, cameras: &[Option<&str>]) -> Vec<PathBuf> {
        let path = self.called(filename);
        let of_camera = |camera: &Option<&str>| self.quickened(camera.map_or(path.clone(), |camera| with_infix(&path, camera)));
        cameras.iter().map(of_camera).collect()
    }

    /// The name of a preview, if it is one and -o does not say otherwise.
    fn quickened(&self, path: PathBuf) -> PathBuf {
        if self.quick && self.output.is_none() { with_infix(&path, "quick") } else { path }
    }

    /// The EXR file of one camera, and where its name comes from.
    pub fn exr_of(&self, built: &BuiltScene, camera: Option<&str>) -> (PathBuf, NamedBy) {
        let one = built.camera_names().count() == 1;
        let (path, by) = self.exr(built);
        // The only picture is called what the command line says.
        let camera = camera.filter(|_| !(one && self.output.is_some()));
        let path = camera.map_or(path.clone(), |camera| with_infix(&path, camera));
        let path = self.numbered(self.quickened(path));
        match self.args.and_then(|args| args.parts.label(args.picture.crop)) {
            // The only part is called what the command line says.
            Some(label) if self.output.is_none() => (with_infix(&path, &label).with_extension(part::ENDING), by),
            _ => (path, by),
        }
    }
}

/// The files of one picture.
pub(super) struct Outputs {
    exr: OutputFile,
    /// None beside a part.
    png: Option<OutputFile>,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
    /// The layer that the PNG shows, and whether in false colours.
    layer: Option<String>,
    false_color: bool,
    /// A false-colour picture for each layer, if they are asked for.
    shown: Vec<OutputFile>,
    stats: Option<OutputFile>,
    /// The checkpoint, if there is to be one; of a part that is stopped there is one in any case.
    checkpoint: Option<OutputFile>,
    /// Whether it is asked for.
    is_saved: bool,
    /// Whether the picture has been written, as far as it was.
    is_written: AtomicBool,
}

impl Outputs {
    /// The files of all pictures of a scene, one for each camera. `plan` says what is wrong with them; if it does, some are missing.
    pub fn plan(naming: &Naming, built: &BuiltScene, plan: &mut Plan) -> Vec<Self> {
        built.camera_names().filter_map(|camera| Self::plan_one(naming, built, camera, plan)).collect()
    }

    fn plan_one(naming: &Naming, built: &BuiltScene, camera: Option<&str>, plan: &mut Plan) -> Option<Self> {
        let one = built.camera_names().count() == 1;
        let (exr_path, by) = naming.exr_of(built, camera);
        let own_name = |path: &Path| naming.own_name(path, camera.filter(|_| !one));
        let is_part = naming.part().is_some();
        let (ending, help) = match is_part {
            true => (part::ENDING, "a part of a picture holds sums; `bhs merge` makes pictures of parts"),
            false => ("exr", "a .png is written beside it"),
        };
        if !plan.ends_in(&exr_path, ending, help, by) {
            return None;
        }
        let layers: &[NamedLayer] = if naming.false_color { &built.layers } else { &[] };
        let png = (!is_part).then(|| exr_path.with_extension("png"));
        let shown: Vec<PathBuf> = layers.iter().map(|l| false_color::path(&exr_path, l.name)).collect();
        let stats = naming.stats.map(own_name);
        if naming.no_overwrite {
            let all = [&exr_path].into_iter().chain(&png).chain(&shown).chain(&stats);
            if all.filter(|path| plan.is_there(path)).count() > 0 {
                return None;
            }
        }
        // What is wrong with its folder is said once.
        let mut claim = |path: &PathBuf, by| plan.claim_unless_there(path, by, naming.no_overwrite);
        let exr = claim(&exr_path, by)?;
        let png = png.map(|path| claim(&path, by));
        let shown: Vec<_> = shown.iter().map(|path| claim(path, by)).collect();
        let stats = stats.map(|path| claim(&path, NamedBy::CommandLine));
        if let Some(Err(why)) = naming.args.map(|args| part::cover(args, built)) {
            plan.refuse(Diagnostic::error("no-part", why));
        }
        let asked = naming.args.and_then(|args| args.checkpoint_for(&exr_path, own_name));
        let is_saved = asked.is_some();
        let checkpoint = asked.or_else(|| is_part.then(|| checkpoint::beside(&exr_path))).map(|path| {
            let is_named = naming.args.is_some_and(|args| matches!(args.checkpoint, Some(Some(_))));
            claim_checkpoint(plan, &path, if is_named { NamedBy::CommandLine } else { by })
        });
        let shown = shown.into_iter().collect::<Option<_>>()?;
        let (png, stats, checkpoint) = (none_or(png)?, none_or(stats)?, none_or(checkpoint)?);
        let (layer, false_color) = (naming.layer.map(str::to_owned), naming.false_color);
        Some(Self {
            exr,
            png,
            frame: naming.frame,
            layer,
            false_color,
            shown,
            stats,
            checkpoint,
            is_saved,
            is_written: AtomicBool::new(false),
        })
    }

    /// Makes sure that all of them can be written.
    ///
    /// # Errors
    /// Says why not.
    pub fn probe(&self) -> Result<()> {
        [&self.exr]
            .into_iter()
            .chain(&self.png)
            .chain(&self.shown)
            .chain(&self.stats)
            .chain(&self.checkpoint)
            .try_for_each(OutputFile::probe)
    }

    /// Where the picture will stand.
    pub fn exr_path(&self) -> &Path {
        self.exr.path()
    }

    /// Where its checkpoint stands, if there is one, and whether it is saved now and then: of a part only when that is stopped, if nobody asks.
    pub fn checkpoint(&self) -> Option<(&Path, bool)> {
        self.checkpoint.as_ref().map(|file| (file.path(), self.is_saved))
    }

    /// The file of a part, and its statistics, if they are asked for.
    pub fn part_files(&self) -> (&OutputFile, Option<&OutputFile>) {
        (&self.exr, self.stats.as_ref())
    }

    /// Whether the pictures that stand there are these.
    pub fn hold(&self, built: &BuiltScene, finished: &Finished) -> bool {
        let Finished { picture, layers, .. } = finished;
        let texts = Texts::of_attributes(&finished.attributes(built));
        let is = |path: &Path, write: &dyn Fn(&mut Vec<u8>) -> Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).is_ok() && std::fs::read(path).is_ok_and(|there| there == bytes)
        };
        let shown = self.shown.iter().zip(layers).all(|(file, layer)| {
            let colors = FalseColor::new(layer);
            is(file.path(), &|to| develop::write_false_color(to, picture.size, &colors, &texts))
        });
        let content = |to: &mut Vec<u8>| self.content(picture, layers)?.write(to, &built.look, &texts);
        let png = || self.png.as_ref().is_none_or(|png| is(png.path(), &content));
        let stats = || self.stats.as_ref().is_none_or(|file| file.path().exists());
        shown && png() && stats() && {
            let all = finished.all_channels();
            Picture::read_exr(self.exr.path()).is_ok_and(|there| there.same_channels(&all))
        }
    }

    /// What the PNG shows.
    fn content<'p>(&self, picture: &'p Picture, layers: &[LayerPicture]) -> Result<Content<'p>> {
        Content::of(picture, layers, self.layer.as_deref(), self.false_color).map_err(anyhow::Error::msg)
    }

    /// Writes the picture as it is now, while it goes on; its files can be written again.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn write_partial(&self, built: &BuiltScene, rendered: &Rendered) -> Result<()> {
        let finished = Finished::of(rendered);
        let attributes = finished.attributes(built);
        let (content, texts) = (self.content(&finished.picture, &finished.layers)?, Texts::of_attributes(&attributes));
        let mut set = OutputSet::new();
        if let Some(png) = &self.png {
            set.add(self.as_far_as_mine(png), |to| content.write(to, &built.look, &texts));
        }
        set.add(self.as_far_as_mine(&self.exr), |to| finished.all_channels().write_exr(to, &attributes));
        set.write_in_place()?;
        self.is_written.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// A file, which may be replaced even with `--no-overwrite` if this render has written it.
    fn as_far_as_mine(&self, file: &OutputFile) -> OutputFile {
        if self.is_written.load(Ordering::Relaxed) { file.clone().replacing() } else { file.clone() }
    }

    /// Writes all of them, together; elsewhere if they cannot be written to their places.
    pub fn write(&self, built: &BuiltScene, finished: &Finished, phases: &mut Phases, quiet: bool, rescue: &Rescue) -> Kept {
        let exr_path = self.exr.path().to_owned();
        let Finished { rendered, picture, layers, .. } = finished;
        let attributes = finished.attributes(built);
        let (size, texts) = (picture.size, &Texts::of_attributes(&attributes));
        let mut set = OutputSet::new();
        if let Some(png) = &self.png {
            set.add(self.as_far_as_mine(png), |to| self.content(picture, layers)?.write(to, &built.look, texts));
        }
        for (file, layer) in self.shown.iter().zip(layers) {
            let colors = FalseColor::new(layer);
            if !quiet {
                say!("{} shows {colors}", file.path().display());
            }
            set.add(file.clone(), move |to| develop::write_false_color(to, size, &colors, texts));
        }
        set.add(self.as_far_as_mine(&self.exr), |to| finished.all_channels().write_exr(to, &attributes));
        if let Some(stats) = &self.stats {
            let phases = &*phases;
            set.add(stats.clone(), move |to| {
                let mut phases = phases.clone();
                phases.end("write");
                Ok(writeln!(to, "{}", serde_json::to_string_pretty(&stats_json(built, rendered, &phases))?)?)
            });
        }
        let kept = set.write(rescue);
        phases.end("write");
        if !quiet && kept == Kept::InPlace {
            closing_words(&exr_path, rendered, phases);
        }
        kept
    }
}

/// `path` with a word before its ending: `room.left.exr` for `room.exr`.
pub(super) fn with_infix(path: &Path, infix: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".");
    name.push(infix);
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

/// Claims a checkpoint and the one before it. They are there for being replaced, also with `--no-overwrite`.
fn claim_checkpoint(plan: &mut Plan, path: &Path, by: NamedBy) -> Option<OutputFile> {
    let file = plan.claim(path, by)?;
    let previous = previous(path);
    // A render that was ended in the middle of saving may have left them as two names of one file.
    let id = |path: &Path| std::fs::metadata(path).ok().map(|found| FileId::of(path, &found));
    if id(&previous).is_none_or(|previous| Some(previous) != id(path)) {
        plan.claim(&previous, by)?;
    }
    Some(file)
}

/// A claim that may not have been made: `None` if it was refused.
fn none_or<T>(claimed: Option<Option<T>>) -> Option<Option<T>> {
    claimed.map_or(Some(None), |claimed| claimed.map(Some))
}
