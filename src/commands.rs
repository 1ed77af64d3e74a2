//! What the program's commands do.

use crate::cli::{Cli, Command, Definitions, PictureArgs, SceneArgs};
use crate::files::{self, Root};
use crate::lang::{self, BuiltScene, Labels, Overrides, SourceMap, Variables};
use crate::memory::picture::TooLarge;
use crate::output::{OutputFile, Plan};
use crate::progress::ProgressForm;
use crate::registry::Registry;
use crate::signals::StopSignal;
use crate::{diagnosis, message, plugins_table, report, say};
use anyhow::{Context, Result, anyhow};
use bhs_core::diagnostics::Diagnostic;
use std::io::Write;
use std::path::{Path, PathBuf};

mod about;
mod bench;
mod compare;
mod convert;
mod denoise;
mod develop;
mod frames;
mod merge;
mod naming;
mod outputs;
mod part;
mod picture;
mod render;
mod replay;
mod several;
mod trace;
mod watch;

pub use about::{completions, man, verbose_version};
pub use bench::bench;
pub use compare::compare;
pub use convert::convert;
pub use denoise::denoise;
pub use develop::develop;
pub use merge::merge;
use naming::Naming;
use outputs::Outputs;
pub use render::{render, start};
pub use trace::trace;
pub use watch::watch;

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
    /// Stopped with a part of a picture under way, which is kept: the same command with `--resume` goes on (`EX_TEMPFAIL` of sysexits.h).
    TryAgain = 75,
    /// The terminal is gone; what was rendered is written.
    HungUp = 129,
    /// Interrupted; what was rendered is written.
    Interrupted = 130,
    /// Told to end; what was rendered is written.
    Terminated = 143,
}

impl ExitStatus {
    /// One word for it, for programs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Fault | Self::CommandLine => "failed",
            Self::TryAgain | Self::HungUp | Self::Interrupted | Self::Terminated => "stopped",
        }
    }
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

/// Whether somebody has closed the pipe that was written to, such as `head`: no fault of anybody's.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|e| e.downcast_ref::<std::io::Error>()).any(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// What all commands are told.
#[derive(Clone, Debug, Default)]
pub struct Common {
    /// Whether standard error has colours.
    pub color: bool,
    /// What confines the files of a scene.
    pub root: Option<Root>,
    /// Whether scenes are pbrt-v4's, whatever their files are called.
    pub pbrt: bool,
    /// Files that are read at the end of a scene.
    pub include: Vec<PathBuf>,
    /// Whether it is told how far the loading of a scene has come.
    pub tells_loading: bool,
}

impl Common {
    /// As the command line says.
    ///
    /// # Errors
    /// If there is no such folder as the root.
    pub fn of(cli: &Cli) -> Result<Self> {
        let root = cli.root.as_deref().map(Root::new).transpose()?;
        let tells_loading = match &cli.command {
            Command::Render(args) => ProgressForm::choose(args.show.progress, args.quiet) != ProgressForm::None,
            _ => false,
        };
        let (color, include) = (cli.color.on_standard_error(), cli.include.clone());
        Ok(Self { color, root, pbrt: cli.pbrt, include, tells_loading })
    }

    /// No texts yet.
    fn sources(&self) -> SourceMap {
        SourceMap::confined_to(self.root.clone()).reading(self.pbrt, self.include.clone())
    }

    /// Opens a file, not a scene, that the command line names.
    fn open(&self, path: &Path) -> Result<std::fs::File> {
        let opened = self.root.as_ref().map_or(Ok(()), |root| root.admit_named(path)).and_then(|()| files::open(path));
        opened.map(|(file, _)| file).map_err(|why| {
            let help = files::pipe_help(path).map(|help| format!("; {help}")).unwrap_or_default();
            anyhow!("cannot read `{}`: {why}{help}", path.display())
        })
    }
}

/// Loads a scene and says on standard error what is wrong with it. `None` if it cannot be built.
fn load(scene: &Path, overrides: &Overrides, common: &Common) -> Option<(BuiltScene, SourceMap)> {
    load_labelled(scene, overrides, common).map(|(built, _, sources)| (built, sources))
}

/// The same, with what its shapes and lights are called.
fn load_labelled(scene: &Path, overrides: &Overrides, common: &Common) -> Option<(BuiltScene, Labels, SourceMap)> {
    let mut sources = common.sources();
    let told = common.tells_loading.then(|| sources.loading().tell());
    let loaded = lang::load_labelled(scene, &Registry::builtin(), overrides, &mut sources);
    drop(told);
    match loaded {
        Ok((built, labels)) => {
            show(&built.warnings, &sources, common.color);
            Some((built, labels, sources))
        }
        Err(found) => {
            show(&found, &sources, common.color);
            None
        }
    }
}

/// Writes to standard output. What is left in its buffer would be lost without a word.
///
/// # Errors
/// If it cannot be written.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to standard output")
}

fn show(found: &[Diagnostic], sources: &SourceMap, color: bool) {
    if !found.is_empty() {
        let objects = || found.iter().map(|d| report::to_json(d, sources)).collect();
        message::findings(&report::render(found, sources, color), objects);
    }
}

/// Says what makes pictures black, as far as that is known of a scene without rendering it; the scene keeps it.
fn diagnose(built: &mut BuiltScene, sources: &SourceMap, common: &Common) {
    let found = diagnosis::before(built);
    show(&found, sources, common.color);
    built.warnings.extend(found);
}

/// What the command line changes of a scene, and of how its picture is rendered.
fn overrides(args: &SceneArgs, picture: &PictureArgs) -> Overrides {
    Overrides {
        integrator: args.integrator.clone(),
        seed: args.seed,
        variables: Variables::defined(&args.definitions.define),
        transport: picture.transport.clone(),
        spp: picture.spp,
        resolution: picture.resolution,
        crop: picture.crop,
        ..Default::default()
    }
}

/// `bhs check`: all that `render` would refuse without flags.
///
/// # Errors
/// If standard output is closed.
pub fn check(scenes: &[impl AsRef<Path>], definitions: &Definitions, as_json: bool, common: &Common) -> Result<ExitStatus> {
    if let Some(fault) = several::fault_of_names(scenes) {
        say!("error: {fault}");
        return Ok(ExitStatus::CommandLine);
    }
    let mut all = ExitStatus::Done;
    for scene in scenes {
        if check_one(scene.as_ref(), definitions, as_json, common)? != ExitStatus::Done {
            all = ExitStatus::Fault;
        }
    }
    Ok(all)
}

fn check_one(scene: &Path, definitions: &Definitions, as_json: bool, common: &Common) -> Result<ExitStatus> {
    let mut sources = common.sources();
    let variables = Variables::defined(&definitions.define);
    let overrides = Overrides { too_large: TooLarge::Warn, variables, ..Overrides::default() };
    let (found, status) = match lang::load(scene, &Registry::builtin(), &overrides, &mut sources) {
        Ok(mut built) => {
            loop {
                let found = diagnosis::before(&built);
                // Of each camera; what is wrong with the lights is wrong for all.
                let new: Vec<Diagnostic> = found.into_iter().filter(|d| !built.warnings.contains(d)).collect();
                built.warnings.extend(new);
                if !built.next_camera() {
                    break;
                }
            }
            let mut plan = Plan::new(&sources);
            Outputs::plan(&Naming::without_flags(scene), &built, &mut plan);
            match plan.finish() {
                Ok(()) => (built.warnings, ExitStatus::Done),
                Err(found) => ([built.warnings, found].concat(), ExitStatus::Fault),
            }
        }
        Err(found) => (found, ExitStatus::Fault),
    };
    if as_json {
        let lines: String = found.iter().map(|diagnostic| format!("{}\n", report::to_json(diagnostic, &sources))).collect();
        print(&lines)?;
        return Ok(status);
    }
    show(&found, &sources, common.color);
    if status == ExitStatus::Done {
        say!("{}: no errors", scene.display());
    }
    Ok(status)
}

/// `bhs format`
///
/// # Errors
/// If the scene cannot be written.
pub fn format(scene: &Path, write: bool, common: &Common) -> Result<ExitStatus> {
    if write && scene == Path::new("-") {
        say!("error: --write writes a file, and the scene comes from standard input");
        return Ok(ExitStatus::CommandLine);
    }
    let mut sources = common.sources();
    let formatted = sources.open(scene).map_err(|d| vec![*d]).and_then(|file| {
        let text = sources.get(file).map_or("", |s| &*s.text);
        lang::format(text, file)
    });
    match formatted {
        Err(found) => {
            show(&found, &sources, common.color);
            Ok(ExitStatus::Fault)
        }
        Ok(text) if write => {
            OutputFile::reserve(scene)?.finish(|to| Ok(to.write_all(text.as_bytes())?))?;
            Ok(ExitStatus::Done)
        }
        Ok(text) => {
            print(&text)?;
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
            print(&text)?;
            Ok(ExitStatus::Done)
        }
        Err(unknown) => {
            say!("error: {unknown}");
            Ok(ExitStatus::CommandLine)
        }
    }
}
