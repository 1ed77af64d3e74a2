//! The files of a picture: their names, and how they are written.

use super::naming::Naming;
use super::part;
use super::render::closing_words;
use crate::checkpoint::{self, previous};
use crate::develop::{self, Content, Texts};
use crate::false_color::{self, FalseColor};
use crate::files::FileId;
use crate::finished::{Finished, stats_json};
use crate::image::Picture;
use crate::lang::BuiltScene;
use crate::output::{Kept, NamedBy, OutputFile, OutputSet, Plan, Rescue};
use crate::render::Rendered;
use crate::say;
use crate::stats::Phases;
use anyhow::Result;
use bhs_engine::layer::NamedLayer;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

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
        let layers: &[NamedLayer] = if naming.shows_layers_besides() { &built.layers } else { &[] };
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
        let content = |to: &mut Vec<u8>| self.content(finished)?.write(to, &built.look, &texts);
        let png = || self.png.as_ref().is_none_or(|png| is(png.path(), &content));
        let stats = || self.stats.as_ref().is_none_or(|file| file.path().exists());
        shown && png() && stats() && {
            let all = finished.all_channels();
            Picture::read_exr(self.exr.path()).is_ok_and(|there| there.same_channels(&all))
        }
    }

    /// Whether the PNG shows a layer in place of the picture.
    pub fn shows_layer(&self) -> bool {
        self.layer.is_some()
    }

    /// What the PNG shows.
    fn content<'p>(&self, finished: &'p Finished) -> Result<Content<'p>> {
        finished.content(self.layer.as_deref(), self.false_color)
    }

    /// Writes the picture as it is now, while it goes on; its files can be written again.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn write_partial(&self, built: &BuiltScene, rendered: &Rendered) -> Result<()> {
        let finished = Finished::of(rendered);
        let attributes = finished.attributes(built);
        let (content, texts) = (self.content(&finished)?, Texts::of_attributes(&attributes));
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
            set.add(self.as_far_as_mine(png), |to| self.content(finished)?.write(to, &built.look, texts));
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
