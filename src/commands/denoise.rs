//! `bhs denoise`: a picture without its noise.

use super::{Common, ExitStatus, show};
use crate::cli::DenoiseArgs;
use crate::denoise::{self, Denoiser};
use crate::develop::{self, Texts};
use crate::header;
use crate::image::ExrFile;
use crate::look::Look;
use crate::memory;
use crate::output::{Kept, NamedBy, OutputFile, OutputSet, Plan, Rescue};
use crate::{say, threads};
use anyhow::{Context, Result};
use bhs_textures::decode::exr_parts::Shown;
use std::path::Path;
use std::time::Instant;

/// `bhs denoise`
///
/// # Errors
/// If the picture cannot be read or denoised, or the result not be written.
pub fn denoise(args: &DenoiseArgs, common: &Common) -> Result<ExitStatus> {
    let start = Instant::now();
    common.open(&args.picture)?;
    let mut sources = common.sources();
    sources.add_input(&args.picture, "the picture that is denoised");
    // Whether the result can be kept is found out before it is made.
    let mut plan = Plan::new(&sources);
    let outputs = outputs(args, &mut plan);
    if let Err(found) = plan.finish() {
        show(&found, &sources, common.color);
        return Ok(ExitStatus::Fault);
    }
    let Some([png, exr]) = outputs else { return Ok(ExitStatus::Fault) };
    [&png, &exr].into_iter().try_for_each(OutputFile::probe)?;

    let shown = || format!("cannot denoise `{}`", args.picture.display());
    let ExrFile { picture, header: attributes } = ExrFile::read(&args.picture)?;
    denoise::check(&picture).with_context(shown)?;
    let denoiser = Denoiser::load(threads::count(args.threads))?;
    let needed = denoise::bytes((picture.size[0] * picture.size[1]) as u64, picture.channels.len());
    memory::require("taking out its noise", needed).with_context(shown)?;
    let was_denoised = picture.find(denoise::NOISY).is_some();
    if was_denoised && !args.quiet {
        say!("`{}` has been denoised before: its layer `noisy` is denoised anew", args.picture.display());
    }
    let picture = denoiser.denoise(&picture).with_context(shown)?;
    let attributes = attributes.with_text(header::DENOISED, &denoiser.name());

    // As `bhs develop` shows it.
    let rgb = Shown::Rgb(picture.find(denoise::COLORS).unwrap_or_default());
    let (colors, notes) = develop::colours(&picture, rgb, attributes.chromaticities());
    if !args.quiet {
        notes.iter().for_each(|note| say!("note: `{}`: {note}", args.picture.display()));
    }
    let look = Look::of_words(|name| attributes.word(&format!("bhs:{name}")));
    let texts = Texts::of(|name| attributes.word(name));
    let mut set = OutputSet::new();
    set.add(png, |to| develop::write_png(to, &colors, &look, &texts));
    set.add(exr, |to| picture.write_exr_like(to, &attributes));
    let kept = set.write(&Rescue::beside(&args.picture, common.root.as_ref()));
    if kept != Kept::InPlace {
        return Ok(ExitStatus::Fault);
    }
    if !args.quiet {
        say!("{} and .png: denoised in {:.1} s", args.output.display(), start.elapsed().as_secs_f64());
    }
    Ok(ExitStatus::Done)
}

/// The PNG and the EXR file; `None` if `plan` says what is wrong with them.
fn outputs(args: &DenoiseArgs, plan: &mut Plan) -> Option<[OutputFile; 2]> {
    let exr: &Path = &args.output;
    if !plan.ends_in(exr, "exr", "a .png is written beside it", NamedBy::CommandLine) {
        return None;
    }
    let png = exr.with_extension("png");
    let claimed = [png.as_path(), exr].map(|path| plan.claim_unless_there(path, NamedBy::CommandLine, args.no_overwrite));
    let [png, exr] = claimed;
    Some([png?, exr?])
}
