//! The files of a picture: their names, and how they are written.

use super::render::{closing_words, provenance, stats_json};
use crate::cli::RenderArgs;
use crate::false_color::{self, FalseColor};
use crate::image::{self, Picture};
use crate::lang::BuiltScene;
use crate::output::OutputFile;
use crate::render::Rendered;
use crate::say;
use crate::stats::Phases;
use anyhow::{Result, bail};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The files of one picture.
pub(super) struct Outputs {
    exr: OutputFile,
    png: OutputFile,
    /// A false-colour picture for each layer, if they are asked for.
    shown: Vec<OutputFile>,
    stats: Option<OutputFile>,
    /// Where the checkpoint stands, if there is to be one.
    checkpoint: Option<PathBuf>,
}

impl Outputs {
    /// Makes sure that the files of the given camera can be written.
    pub fn reserve(args: &RenderArgs, built: &BuiltScene, camera: Option<&str>) -> Result<Self> {
        let one = built.camera_names().count() == 1;
        // The only picture is called what the command line says.
        let exr_path = match &args.output {
            Some(path) if one => path.clone(),
            Some(path) => named(path, camera),
            None => named(Path::new(built.film.filename()), camera),
        };
        if exr_path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
            bail!("cannot write `{}`: the output's name ends in .exr (a .png is written beside it)", exr_path.display());
        }
        let exr = OutputFile::reserve(&exr_path)?;
        let png = OutputFile::reserve(&exr_path.with_extension("png"))?;
        let layers = if args.false_color { built.film.layers() } else { &[] };
        let shown = layers.iter().map(|l| OutputFile::reserve(&false_color::path(&exr_path, *l))).collect::<Result<_>>()?;
        let stats = args.stats.as_ref().map(|path| if one { path.clone() } else { named(path, camera) });
        let stats = stats.as_deref().map(OutputFile::reserve).transpose()?;
        let checkpoint = args.checkpoint_for(&exr_path, |path| if one { path.to_owned() } else { named(path, camera) });
        if let Some(path) = &checkpoint {
            drop(OutputFile::reserve(path)?);
        }
        Ok(Self { exr, png, shown, stats, checkpoint })
    }

    /// Where the picture will stand.
    pub fn exr_path(&self) -> &Path {
        self.exr.path()
    }

    /// Where its checkpoint stands, if there is to be one.
    pub fn checkpoint(&self) -> Option<&Path> {
        self.checkpoint.as_deref()
    }

    /// Whether the pictures that stand there are these.
    pub fn hold(&self, built: &BuiltScene, rendered: &Rendered) -> bool {
        let (picture, layers) = (rendered.frame.picture(), rendered.frame.layers());
        let is = |path: &Path, write: &dyn Fn(&mut Vec<u8>) -> Result<()>| {
            let mut bytes = Vec::new();
            write(&mut bytes).is_ok() && std::fs::read(path).is_ok_and(|there| there == bytes)
        };
        let shown = self.shown.iter().zip(&layers).all(|(file, layer)| {
            let colors = FalseColor::new(layer);
            is(file.path(), &|to| image::write_png(to, picture.size, colors.pixels().as_flattened()))
        });
        let png = || is(self.png.path(), &|to| picture.write_png(to, |pixel| built.film.display(pixel)));
        let stats = || self.stats.as_ref().is_none_or(|file| file.path().exists());
        shown && png() && stats() && {
            let picture = picture.with_layers(&layers);
            Picture::read_exr(self.exr.path()).is_ok_and(|there| there.same_channels(&picture))
        }
    }

    /// Writes the picture as it is now, while it goes on; its files can be written again.
    pub fn write_partial(&self, built: &BuiltScene, rendered: &Rendered) -> Result<()> {
        let files = Self {
            exr: OutputFile::reserve(self.exr.path())?,
            png: OutputFile::reserve(self.png.path())?,
            shown: Vec::new(),
            stats: None,
            checkpoint: None,
        };
        files.write(built, rendered, &mut Phases::default(), true)
    }

    /// Writes all of them.
    pub fn write(self, built: &BuiltScene, rendered: &Rendered, phases: &mut Phases, quiet: bool) -> Result<()> {
        let exr_path = self.exr.path().to_owned();
        let (picture, layers) = (rendered.frame.picture(), rendered.frame.layers());
        let attributes = provenance(built, rendered);
        self.png.finish(|to| picture.write_png(to, |pixel| built.film.display(pixel)))?;
        for (file, layer) in self.shown.into_iter().zip(&layers) {
            let colors = FalseColor::new(layer);
            if !quiet {
                say!("{} shows {colors}", file.path().display());
            }
            file.finish(|to| image::write_png(to, picture.size, colors.pixels().as_flattened()))?;
        }
        let picture = picture.with_layers(&layers);
        self.exr.finish(|to| picture.write_exr(to, &attributes))?;
        phases.end("write");
        if let Some(stats) = self.stats {
            let text = serde_json::to_string_pretty(&stats_json(built, rendered, phases))?;
            stats.finish(|to| Ok(writeln!(to, "{text}")?))?;
        }
        if !quiet {
            closing_words(&exr_path, rendered, phases);
        }
        Ok(())
    }
}

/// `path` with the camera's name before its ending, if it has one.
fn named(path: &Path, camera: Option<&str>) -> PathBuf {
    let Some(camera) = camera else { return path.to_owned() };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}.{camera}{ending}"))
}
