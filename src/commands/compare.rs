//! `bhs compare`: how far two pictures are apart, in numbers and as pictures.

use super::{Common, ExitStatus, print, show};
use crate::difference::{self, Difference};
use crate::image::Picture;
use crate::output::{NamedBy, OutputFile, OutputSet, Plan};
use anyhow::{Result, bail};
use serde_json::json;
use std::path::{Path, PathBuf};

/// `bhs compare`
///
/// # Errors
/// If a file cannot be read or written, or the pictures cannot be compared.
pub fn compare(a: &Path, b: &Path, diff: Option<&Path>, as_json: bool, common: &Common) -> Result<ExitStatus> {
    for path in [a, b] {
        common.open(path)?;
    }
    // Whether the results can be kept is found out before they are made.
    let mut files = Vec::new();
    if let Some(out) = diff {
        if out.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
            bail!("cannot write `{}`: the name of --diff ends in .png", out.display());
        }
        let Some(claimed) = claim(out, [a, b], common) else { return Ok(ExitStatus::Fault) };
        claimed.iter().try_for_each(OutputFile::probe)?;
        files = claimed;
    }
    let (first, second) = (Picture::read_exr(a)?, Picture::read_exr(b)?);
    let comparison = crate::compare::compare(&first, &second)?;
    // FLIP takes by far the longest.
    let difference = if diff.is_some() || as_json { Difference::new(&first, &second) } else { None };
    if diff.is_some() {
        let difference = difference::check(difference.as_ref())?;
        let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let pair = format!("of {} against {}", name(a), name(b));
        let mut set = OutputSet::new();
        let flip = format!("FLIP {pair}, mean {:.6}", difference.mean_flip());
        let numbers = [(&difference.flip, flip), (&difference.relative, format!("relative error {pair}"))];
        for (file, (numbers, said)) in files.into_iter().zip(numbers) {
            set.add(file, move |to| difference.write_png(to, numbers, &said));
        }
        set.write_in_place()?;
    }
    let flip = difference.as_ref().map(Difference::mean_flip);
    let text = match as_json {
        true => {
            let mut all = comparison.to_json();
            all["flip"] = json!(flip);
            serde_json::to_string_pretty(&all)? + "\n"
        }
        false => flip.map_or_else(|| comparison.to_string(), |flip| format!("{comparison}mean FLIP            {flip:.6}\n")),
    };
    print(&text)?;
    Ok(ExitStatus::Done)
}

/// The files of FLIP and of the relative error; says what is wrong with them.
fn claim(out: &Path, inputs: [&Path; 2], common: &Common) -> Option<Vec<OutputFile>> {
    let mut sources = common.sources();
    inputs.iter().for_each(|path| sources.add_input(path, "a picture that is compared"));
    let mut plan = Plan::new(&sources);
    let paths: [PathBuf; 2] = [out.to_owned(), difference::relative_path(out)];
    let files: Option<Vec<OutputFile>> = paths.iter().map(|path| plan.claim(path, NamedBy::CommandLine)).collect();
    match plan.finish() {
        Ok(()) => files,
        Err(found) => {
            show(&found, &sources, common.color);
            None
        }
    }
}
