//! What the files of a picture are called.

use super::part;
use crate::animation::digits;
use crate::checkpoint::previous;
use crate::cli::RenderArgs;
use crate::false_color;
use crate::lang::BuiltScene;
use crate::output::NamedBy;
use crate::parts::PartArgs;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// What the names of a scene's outputs are made from.
#[derive(Clone)]
pub(super) struct Naming<'a> {
    /// The scene; `-` is standard input.
    scene: &'a Path,
    /// The EXR file and the stats that the command line names.
    output: Option<&'a Path>,
    pub stats: Option<&'a Path>,
    quick: bool,
    pub false_color: bool,
    /// The layer that the PNG shows in place of the picture.
    pub layer: Option<&'a str>,
    pub no_overwrite: bool,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
    /// Knows whether there is to be a checkpoint, and where.
    pub args: Option<&'a RenderArgs>,
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

    /// Whether layers are shown beside the picture, and none of them in its place.
    pub fn shows_layers_besides(&self) -> bool {
        self.false_color && self.layer.is_none()
    }

    /// Which part of a picture is rendered, if it is one.
    pub fn part(&self) -> Option<&'a PartArgs> {
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

    /// All files of the pictures of a scene whose film has this `filename`, but for what the command line names: one for each of these cameras
    /// and each frame, with the layers of these names.
    pub fn all(&self, filename: &str, cameras: &[Option<&str>], layers: &BTreeSet<String>) -> Vec<PathBuf> {
        let of_camera = |camera: &Option<&str>| {
            let exr = self.exr_called(filename, *camera, cameras.len() == 1);
            let checkpoint = self.args.and_then(|args| args.checkpoint_for(&exr, |path| self.own_name(path, *camera)));
            let states = checkpoint.into_iter().flat_map(|path| [previous(&path), path]);
            let layers = layers.iter().filter(|_| self.shows_layers_besides()).map(String::as_str);
            let shown = if self.part().is_some() { vec![exr] } else { with_pngs(exr, layers) };
            shown.into_iter().chain(states).collect::<Vec<_>>()
        };
        cameras.iter().flat_map(of_camera).collect()
    }

    /// The name of a preview, if it is one and -o does not say otherwise.
    fn quickened(&self, path: PathBuf) -> PathBuf {
        if self.quick && self.output.is_none() { with_infix(&path, "quick") } else { path }
    }

    /// The EXR file of one camera, and where its name comes from.
    pub fn exr_of(&self, built: &BuiltScene, camera: Option<&str>) -> (PathBuf, NamedBy) {
        let one = built.camera_names().count() == 1;
        (self.exr_called(built.film.filename(), camera, one), self.exr(built).1)
    }

    /// The EXR file of one camera, or of the `only` one, of a scene whose film has this `filename`.
    fn exr_called(&self, filename: &str, camera: Option<&str>, only: bool) -> PathBuf {
        let path = self.output.map_or_else(|| self.called(filename), Path::to_owned);
        // The only picture is called what the command line says.
        let camera = camera.filter(|_| !(only && self.output.is_some()));
        let path = camera.map_or(path.clone(), |camera| with_infix(&path, camera));
        let path = self.numbered(self.quickened(path));
        match self.args.and_then(|args| args.parts.label(args.picture.crop)) {
            // The only part is called what the command line says.
            Some(label) if self.output.is_none() => with_infix(&path, &label).with_extension(part::ENDING),
            _ => path,
        }
    }
}

/// A picture, the PNG beside it, and those that show the layers of these names.
pub(super) fn with_pngs<'n>(exr: PathBuf, layers: impl Iterator<Item = &'n str>) -> Vec<PathBuf> {
    let shown: Vec<PathBuf> = layers.map(|name| false_color::path(&exr, name)).collect();
    [exr.with_extension("png"), exr].into_iter().chain(shown).collect()
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
