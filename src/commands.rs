//! What the program's commands do.

use crate::cli::{BenchArgs, SceneArgs, TraceArgs};
use crate::image::Picture;
use crate::lang::{self, BuiltScene, Overrides, SourceMap};
use crate::output::OutputFile;
use crate::registry::Registry;
use crate::signals::StopSignal;
use crate::{message, plugins_table, report, say};
use anyhow::{Context, Result};
use bhs_core::diagnostics::Diagnostic;
use serde_json::json;
use std::io::{BufReader, Write};
use std::path::Path;
use std::process::ExitCode;

mod outputs;
mod picture;
mod render;

pub use render::render;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ExitStatus {
    /// Done.
    Done = 0,
    /// The scene or a file is at fault.
    Fault = 1,
    /// The command line is at fault.
    CommandLine = 2,
    /// The terminal is gone; what was rendered is written.
    HungUp = 129,
    /// Interrupted; what was rendered is written.
    Interrupted = 130,
    /// Told to end; what was rendered is written.
    Terminated = 143,
}

impl From<StopSignal> for ExitStatus {
    fn from(signal: StopSignal) -> Self {
        match signal {
            StopSignal::Interrupt => Self::Interrupted,
            StopSignal::Terminate => Self::Terminated,
            StopSignal::Hangup => Self::HungUp,
        }
    }
}

impl From<ExitStatus> for ExitCode {
    fn from(status: ExitStatus) -> Self {
        ExitCode::from(status as u8)
    }
}

/// Whether somebody has closed the pipe that was written to, such as `head`: no fault of anybody's.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|e| e.downcast_ref::<std::io::Error>()).any(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Loads a scene and says on standard error what is wrong with it. `None` if it cannot be built.
fn load(scene: &Path, overrides: &Overrides, color: bool) -> Option<BuiltScene> {
    let mut sources = SourceMap::new();
    match lang::load(scene, &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => {
            show(&built.warnings, &sources, color);
            Some(built)
        }
        Err(found) => {
            show(&found, &sources, color);
            None
        }
    }
}

fn show(found: &[Diagnostic], sources: &SourceMap, color: bool) {
    if !found.is_empty() {
        message::write(format_args!("{}", report::render(found, sources, color)));
    }
}

fn overrides(args: &SceneArgs) -> Overrides {
    Overrides { integrator: args.integrator.clone(), seed: args.seed, ..Default::default() }
}

/// `bhs check`
///
/// # Errors
/// If standard output is closed.
pub fn check(scene: &Path, as_json: bool, color: bool) -> Result<ExitStatus> {
    if !as_json {
        let Some(_) = load(scene, &Overrides::default(), color) else { return Ok(ExitStatus::Fault) };
        say!("{}: no errors", scene.display());
        return Ok(ExitStatus::Done);
    }
    let mut sources = SourceMap::new();
    let (found, status) = match lang::load(scene, &Registry::builtin(), &Overrides::default(), &mut sources) {
        Ok(built) => (built.warnings, ExitStatus::Done),
        Err(found) => (found, ExitStatus::Fault),
    };
    let mut out = std::io::stdout().lock();
    for diagnostic in &found {
        writeln!(out, "{}", report::to_json(diagnostic, &sources))?;
    }
    Ok(status)
}

/// `bhs format`
///
/// # Errors
/// If the scene cannot be written.
pub fn format(scene: &Path, write: bool, color: bool) -> Result<ExitStatus> {
    if write && scene == Path::new("-") {
        say!("error: --write writes a file, and the scene comes from standard input");
        return Ok(ExitStatus::CommandLine);
    }
    let mut sources = SourceMap::new();
    let formatted = sources.open(scene).map_err(|d| vec![*d]).and_then(|file| {
        let text = sources.get(file).map_or("", |s| &*s.text);
        lang::format(text, file)
    });
    match formatted {
        Err(found) => {
            show(&found, &sources, color);
            Ok(ExitStatus::Fault)
        }
        Ok(text) if write => {
            OutputFile::reserve(scene)?.finish(|to| Ok(to.write_all(text.as_bytes())?))?;
            Ok(ExitStatus::Done)
        }
        Ok(text) => {
            std::io::stdout().write_all(text.as_bytes())?;
            Ok(ExitStatus::Done)
        }
    }
}

/// `bhs plugins`
///
/// # Errors
/// If standard output is closed.
pub fn plugins(kind: Option<&str>, name: Option<&str>, as_json: bool) -> Result<ExitStatus> {
    let registry = Registry::builtin();
    let made = match as_json {
        true => plugins_table::to_json(&registry, kind, name).map(|all| format!("{all:#}\n")),
        false => plugins_table::render(&registry, kind, name),
    };
    match made {
        Ok(text) => {
            std::io::stdout().write_all(text.as_bytes())?;
            Ok(ExitStatus::Done)
        }
        Err(unknown) => {
            say!("error: {unknown}");
            Ok(ExitStatus::CommandLine)
        }
    }
}

/// `bhs trace`
///
/// # Errors
/// If the rays cannot be read.
pub fn trace(args: &TraceArgs, color: bool) -> Result<ExitStatus> {
    // One of the two is given: the command line sees to it.
    let Some(input) = args.rays.as_ref().or(args.connect.as_ref()) else { return Ok(ExitStatus::CommandLine) };
    if input == Path::new("-") && args.scene == Path::new("-") {
        say!(
            "error: the scene and its {} cannot both come from standard input",
            if args.rays.is_some() { "rays" } else { "pairs" }
        );
        return Ok(ExitStatus::CommandLine);
    }
    let overrides = Overrides { without_camera: true, ..overrides(&args.scene_args) };
    let Some(built) = load(&args.scene, &overrides, color) else { return Ok(ExitStatus::Fault) };
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut answer = |lines: &mut dyn std::io::BufRead| match args.connect {
        Some(_) => crate::trace::connect(&built.scene, lines, &mut out),
        None => crate::trace::trace(&built.scene, lines, args.path, &mut out),
    };
    if input == Path::new("-") {
        answer(&mut std::io::stdin().lock()).context("standard input")?;
    } else {
        let name = input.display();
        let file = std::fs::File::open(input).with_context(|| format!("cannot read `{name}`"))?;
        answer(&mut BufReader::new(file)).with_context(|| format!("`{name}`"))?;
    }
    Ok(ExitStatus::Done)
}

/// `bhs bench`
///
/// # Errors
/// If the scene cannot be measured or a file cannot be written.
pub fn bench(args: &BenchArgs, color: bool) -> Result<ExitStatus> {
    if args.scene == Path::new("-") {
        // It is read several times.
        say!("error: `bhs bench` needs a file");
        return Ok(ExitStatus::CommandLine);
    }
    // Integrators at the scene's own resolution, which sets what they need not tell apart.
    let Some(built) = load(&args.scene, &Overrides::default(), color) else { return Ok(ExitStatus::Fault) };
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder `{}`", folder.display()))?;
    }
    let hash = built.hash.clone();
    let wanted = |what: &str| args.only.as_deref().is_none_or(|only| only == what);
    let mut measured = Vec::new();
    if wanted("integrators") {
        measured.extend(crate::bench::integrators::measure(&built, args.rays as usize, args.rounds));
    }
    if wanted("transports") {
        // The pictures' own resolution sets what rays need not tell apart; all of them share one scene.
        drop(built);
        let overrides = Overrides { resolution: Some(args.resolution), ..Default::default() };
        let Some(small) = load(&args.scene, &overrides, color) else { return Ok(ExitStatus::Fault) };
        let registry = Registry::builtin();
        let make = |overrides: &Overrides| {
            let mut sources = SourceMap::new();
            lang::load_method(&args.scene, &registry, overrides, &mut sources)
                .map_err(|found| anyhow::anyhow!("{}", report::render(&found, &sources, color)))
        };
        measured.push(crate::bench::transports::measure(small, make, args.rounds)?);
    }
    let mut out = std::io::stdout().lock();
    if args.json {
        let tables: serde_json::Map<_, _> =
            measured.iter().flat_map(|m| m.tables()).map(|(name, table)| (name, table.to_json())).collect();
        writeln!(out, "{}", serde_json::to_string_pretty(&json!({ "scene": hash, "tables": tables }))?)?;
    } else {
        for m in &measured {
            writeln!(out, "{}\n\n{}", m.chart.title, m.table.to_markdown())?;
            if let Some(summary) = &m.summary {
                writeln!(out, "{}, {}\n\n{}", m.name.replace('_', " "), summary.title, summary.table.to_markdown())?;
            }
        }
    }
    if let Some(folder) = &args.output {
        for m in &measured {
            let tables = m.tables().map(|(name, table)| (format!("{name}.csv"), table.to_csv()));
            for (name, text) in tables.chain([(format!("{}.svg", m.name), m.chart.to_svg())]) {
                let file = OutputFile::reserve(&folder.join(name))?;
                file.finish(|to| Ok(to.write_all(text.as_bytes())?))?;
            }
        }
    }
    Ok(ExitStatus::Done)
}

/// `bhs compare`
///
/// # Errors
/// If a file cannot be read, or the pictures cannot be compared.
pub fn compare(a: &Path, b: &Path, as_json: bool) -> Result<ExitStatus> {
    let comparison = crate::compare::compare(&Picture::read_exr(a)?, &Picture::read_exr(b)?)?;
    let mut out = std::io::stdout().lock();
    if as_json {
        writeln!(out, "{}", serde_json::to_string_pretty(&comparison.to_json())?)?;
    } else {
        write!(out, "{comparison}")?;
    }
    Ok(ExitStatus::Done)
}
