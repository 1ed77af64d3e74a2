//! `bhs develop`: PNG files of an EXR file.

use super::{Common, ExitStatus, show};
use crate::cli::DevelopArgs;
use crate::develop::{Content, input::Input};
use crate::false_color::{self, FalseColor};
use crate::output::{NamedBy, OutputFile, OutputSet, Plan};
use crate::say;
use anyhow::{Result, bail};

/// `bhs develop`
///
/// # Errors
/// If the picture cannot be read, has no such layer, or a file cannot be written.
pub fn develop(args: &DevelopArgs, common: &Common) -> Result<ExitStatus> {
    let input = Input::read(&args.picture, common.open(&args.picture)?)?;
    let look = args.look.changes().over(input.look());
    let layer = args.look.layer.as_deref();
    let (content, notes) = match layer {
        Some(name) => input.layer(name, args.look.false_color)?,
        None => input.picture()?,
    };
    let mut contents = vec![content];
    let besides: Vec<&str> = if args.look.false_color && layer.is_none() { input.recorded().collect() } else { Vec::new() };
    if args.look.false_color && layer.is_none() && besides.is_empty() {
        say!("error: --false-color shows layers, and `{}` has none of bhs; --layer NAME shows another", args.picture.display());
        return Ok(ExitStatus::Fault);
    }
    for name in &besides {
        contents.push(input.layer(name, true)?.0);
    }
    if !args.quiet {
        notes.iter().for_each(|note| say!("note: `{}`: {note}", args.picture.display()));
    }

    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        bail!("cannot write `{}`: the output's name ends in .png", args.output.display());
    }
    let mut sources = common.sources();
    sources.add_input(&args.picture, "the picture that is developed");
    let mut plan = Plan::new(&sources);
    let files = claim(args, &besides, &mut plan);
    if let Err(found) = plan.finish() {
        show(&found, &sources, common.color);
        return Ok(ExitStatus::Fault);
    }
    files.iter().try_for_each(OutputFile::probe)?;

    let (look, texts) = (&look, &input.texts());
    let mut set = OutputSet::new();
    for (file, content) in files.into_iter().zip(&contents) {
        if let (Content::FalseColor(layer, _), false) = (content, args.quiet) {
            say!("{} shows {}", file.path().display(), FalseColor::new(layer));
        }
        set.add(file, move |to| content.write(to, look, texts));
    }
    set.write_in_place()?;
    Ok(ExitStatus::Done)
}

/// The file of the picture, and those of the layers besides. `plan` says what is wrong with them.
fn claim(args: &DevelopArgs, besides: &[&str], plan: &mut Plan) -> Vec<OutputFile> {
    let layers = besides.iter().map(|layer| false_color::path(&args.output, layer));
    [args.output.clone()].into_iter().chain(layers).filter_map(|path| plan.claim(&path, NamedBy::CommandLine)).collect()
}
