//! `bhs merge`: pictures of parts.

use super::naming::with_infix;
use super::{Common, ExitStatus, show};
use crate::animation::digits;
use crate::cli::MergeArgs;
use crate::develop::{self, Texts};
use crate::false_color::{self, FalseColor};
use crate::finished::Finished;
use crate::output::{NamedBy, OutputFile, OutputSet, Plan};
use crate::parts::file::film_of;
use crate::parts::join::{self, PictureParts, Sorted};
use crate::parts::joined;
use crate::{header, memory, message, say};
use anyhow::Result;
use bhs_core::diagnostics::Diagnostic;
use bhs_engine::layer::NamedLayer;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Places that are said to be missing at most.
const MOST_SAID: usize = 20;

/// The files of a picture.
struct MergedFiles {
    exr: OutputFile,
    png: OutputFile,
    /// A false-colour picture for each layer, if they are asked for.
    shown: Vec<OutputFile>,
}

/// `bhs merge`
///
/// # Errors
/// If a part changes while it is read, or a file cannot be written.
pub fn merge(args: &MergeArgs, common: &Common) -> Result<ExitStatus> {
    let open = |path: &Path| {
        let admitted = common.root.as_ref().map_or(Ok(()), |root| root.admit_named(path));
        admitted.and_then(|()| crate::files::open(path)).map(|(file, _)| file)
    };
    let Sorted { pictures, refused } = join::sort(&args.parts, open);
    let level = if args.partial { "warning" } else { "error" };
    refused.iter().for_each(|why| say!("{level}: {why}"));
    let is_missing = pictures.iter().any(|picture| !picture.missing.is_empty());
    pictures.iter().for_each(|picture| say_missing(picture, pictures.len() > 1, level));
    if pictures.is_empty() {
        say!("error: there is no part to join; nothing is written");
        return Ok(ExitStatus::Fault);
    }
    if !args.partial && (is_missing || !refused.is_empty()) {
        say!("nothing is written; --partial joins what there is");
        return Ok(ExitStatus::Fault);
    }
    let mut sources = common.sources();
    args.parts.iter().for_each(|path| sources.add_input(path, "a part"));
    let mut plan = Plan::new(&sources);
    let several = [
        pictures.iter().map(|p| &p.key.1).collect::<BTreeSet<_>>().len() > 1,
        pictures.iter().map(|p| p.key.0).collect::<BTreeSet<_>>().len() > 1,
    ];
    let files: Vec<Option<MergedFiles>> = pictures.iter().map(|picture| claim(args, picture, several, &mut plan)).collect();
    let mut found = plan.finish().err().unwrap_or_default();
    if found.is_empty() {
        found.extend(pictures.first().and_then(too_large));
    }
    if !found.is_empty() {
        show(&found, &sources, common.color);
        return Ok(ExitStatus::Fault);
    }
    files.iter().flatten().flat_map(|f| [&f.exr, &f.png].into_iter().chain(&f.shown)).try_for_each(OutputFile::probe)?;
    for (picture, files) in pictures.iter().zip(files.iter().flatten()) {
        write(args, picture, files, &open)?;
    }
    Ok(ExitStatus::Done)
}

/// Says which samples of which pixels no part has.
fn say_missing(picture: &PictureParts, is_one_of_several: bool, level: &str) {
    let (Some(whole), false) = (picture.whole(), picture.missing.is_empty()) else { return };
    let of = if is_one_of_several { format!("of {}, ", name(picture)) } else { String::new() };
    for cover in picture.missing.iter().take(MOST_SAID) {
        let [from, to] = cover.samples;
        match cover.window == whole.window {
            true => say!(
                "{level}: missing: {of}samples {from}..{to} of all pixels, the window x {}..{}, y {}..{}",
                cover.window[0],
                cover.window[1],
                cover.window[2],
                cover.window[3]
            ),
            false => say!("{level}: missing: {of}{cover}"),
        }
    }
    if picture.missing.len() > MOST_SAID {
        say!("{level}: missing: {} more such places", picture.missing.len() - MOST_SAID);
    }
    let missing: u64 = picture.missing.iter().map(|c| c.size()).sum();
    let (share, all) = (100.0 * missing as f64 / whole.size() as f64, whole.samples[1]);
    say!("{level}: {share:.3} % of the {all} samples of each pixel are missing");
}

/// Which picture of several it is.
fn name(picture: &PictureParts) -> String {
    match &picture.key {
        (Some(frame), Some(camera)) => format!("frame {frame}, camera `{camera}`"),
        (Some(frame), None) => format!("frame {frame}"),
        (None, Some(camera)) => format!("camera `{camera}`"),
        (None, None) => "the picture".to_owned(),
    }
}

/// The files of a picture; `several` says whether there are several cameras, and frames.
fn claim(args: &MergeArgs, picture: &PictureParts, several: [bool; 2], plan: &mut Plan) -> Option<MergedFiles> {
    let camera = picture.key.1.as_ref().filter(|_| several[0]);
    let path = camera.map_or(args.output.clone(), |camera| with_infix(&args.output, camera));
    let path = picture.key.0.filter(|_| several[1]).map_or(path.clone(), |frame| with_infix(&path, &digits(frame)));
    if !plan.ends_in(&path, "exr", "a .png is written beside it", NamedBy::CommandLine) {
        return None;
    }
    let layers = if args.false_color { layers(picture).unwrap_or_default() } else { Vec::new() };
    let mut claim = |path: PathBuf| plan.claim_unless_there(&path, NamedBy::CommandLine, args.no_overwrite);
    let exr = claim(path.clone())?;
    let png = claim(path.with_extension("png"));
    let shown: Option<Vec<_>> = layers.iter().map(|layer| claim(false_color::path(&path, layer.name))).collect();
    Some(MergedFiles { exr, png: png?, shown: shown? })
}

/// The layers of a picture.
fn layers(picture: &PictureParts) -> Option<Vec<NamedLayer>> {
    Some(film_of(&picture.parts.first()?.head)?.1)
}

/// What is said of pictures that are too large for the memory that there is.
fn too_large(picture: &PictureParts) -> Option<Diagnostic> {
    let (film, layers) = film_of(&picture.parts.first()?.head)?;
    memory::picture::check(&*film, &layers)
}

/// Joins the parts of a picture and writes it.
fn write(
    args: &MergeArgs,
    picture: &PictureParts,
    files: &MergedFiles,
    open: &impl Fn(&Path) -> Result<std::fs::File, String>,
) -> Result<()> {
    let Some(first) = picture.parts.first() else { return Ok(()) };
    let (rendered, _) = joined::join(picture, open)?;
    let finished = Finished::of(&rendered);
    let Finished { picture: colors, layers, .. } = &finished;
    let attributes = header::attributes(&first.head.facts, &rendered);
    let texts = &Texts::of_attributes(&attributes);
    let mut set = OutputSet::new();
    set.add(files.png.clone(), |to| develop::write_png(to, colors, &first.head.facts.look, texts));
    for (file, layer) in files.shown.iter().zip(layers) {
        let shown = FalseColor::new(layer);
        if !args.quiet {
            say!("{} shows {shown}", file.path().display());
        }
        let size = colors.size;
        set.add(file.clone(), move |to| develop::write_false_color(to, size, &shown, texts));
    }
    set.add(files.exr.clone(), |to| finished.all_channels().write_exr(to, &attributes));
    set.write_in_place()?;
    let what = json!({
        "output": files.exr.path().to_string_lossy(),
        "camera": picture.key.1,
        "frame": picture.key.0,
        "spp": rendered.samples,
        "stopped": rendered.ended.name(),
        "parts": picture.parts.len(),
    });
    message::event("picture", what);
    if !args.quiet {
        let parts = picture.parts.len();
        let counted = if parts == 1 { "1 part".to_owned() } else { format!("{parts} parts") };
        say!("{} and .png: {} spp from {counted}", files.exr.path().display(), rendered.samples);
    }
    Ok(())
}
