//! `bhs convert`: a scene in our own terms.

use super::{Common, ExitStatus, print, show};
use crate::cli::Definitions;
use crate::lang::{self, Variables};
use crate::output::{NamedBy, Plan};
use anyhow::Result;
use std::io::Write;
use std::path::Path;

/// `bhs convert`
///
/// # Errors
/// If the scene cannot be written.
pub fn convert(scene: &Path, output: Option<&Path>, definitions: &Definitions, common: &Common) -> Result<ExitStatus> {
    let mut sources = common.sources();
    let variables = Variables::defined(&definitions.define);
    let folder = output.and_then(Path::parent).unwrap_or(Path::new(""));
    let text = match lang::convert(scene, &mut sources, &variables, folder) {
        Ok((text, warnings)) => {
            show(&warnings, &sources, common.color);
            text
        }
        Err(found) => {
            show(&found, &sources, common.color);
            return Ok(ExitStatus::Fault);
        }
    };
    let Some(output) = output else {
        print(&text)?;
        return Ok(ExitStatus::Done);
    };
    let mut plan = Plan::new(&sources);
    let file = plan.claim(output, NamedBy::CommandLine);
    if let Err(found) = plan.finish() {
        show(&found, &sources, common.color);
        return Ok(ExitStatus::Fault);
    }
    if let Some(file) = file {
        file.finish(|to| Ok(to.write_all(text.as_bytes())?))?;
    }
    Ok(ExitStatus::Done)
}
