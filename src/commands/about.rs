//! What the program says of itself: completions, manual pages, and how it was built.

use super::{ExitStatus, print};
use crate::cli::full_command;
use crate::denoise::Denoiser;
use crate::{say, vectors};
use anyhow::{Context, Result};
use clap_complete::Shell;

/// `bhs completions`
///
/// # Errors
/// If standard output cannot be written.
pub fn completions(shell: Shell) -> Result<ExitStatus> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut full_command(), "bhs", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(ExitStatus::Done)
}

/// `bhs man`
///
/// # Errors
/// If standard output cannot be written.
pub fn man(command: Option<&str>) -> Result<ExitStatus> {
    let mut all = full_command();
    all.build();
    let page = match command {
        None => all,
        Some(name) => match all.find_subcommand(name) {
            // Called `bhs-render`, as the page of all commands names it.
            Some(found) => found.clone(),
            None => {
                let names: Vec<&str> = all.get_subcommands().map(clap::Command::get_name).collect();
                say!("error: there is no command `{name}`; there are {}", names.join(", "));
                return Ok(ExitStatus::CommandLine);
            }
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).context("cannot make the manual page")?;
    print(&String::from_utf8_lossy(&text))?;
    Ok(ExitStatus::Done)
}

/// What `bhs --version --verbose` prints: a line each.
pub fn verbose_version() -> String {
    let unknown = "unknown";
    let embree = embree().unwrap_or_else(|| "none: the slow `reference` intersector stands in for it".to_owned());
    let denoiser = Denoiser::load(None).map_or_else(|_| "not found; `bhs denoise` says how to get it".to_owned(), |d| d.name());
    format!(
        "bhs {}\ncommit: {}\ndate: {}\nEmbree: {embree}\nvector code: {}\ndenoiser: {denoiser}\n",
        env!("CARGO_PKG_VERSION"),
        option_env!("BHS_COMMIT").unwrap_or(unknown),
        option_env!("BHS_COMMIT_DATE").unwrap_or(unknown),
        vectors::told(),
    )
}

/// The version of Embree that is loaded, if any is.
fn embree() -> Option<String> {
    let version = bhs_intersectors::embree::version()?;
    Some(format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100))
}
