//! The program `bhs`: reads the command line, does what it says, and says how it ended. `src/main.rs` and the command that the Python package installs
//! both are this.

use crate::cli::{Cli, Command, full_command};
use crate::commands::{self, Common, ExitStatus};
use crate::signals::Signals;
use crate::{message, output, say};
use anyhow::{Context, Result};
use clap::FromArgMatches;
use clap::error::ErrorKind;
use std::ffi::OsString;

/// Runs the command line `words`, of which the first is the program's name; its exit code.
pub fn run(words: &[OsString]) -> u8 {
    output::ignore_file_size_signal();
    message::report_panics();
    let mut command = full_command();
    let parsed = command.try_get_matches_from_mut(words).and_then(|found| Cli::from_arg_matches(&found));
    let cli = match parsed.map_err(|error| error.format(&mut command)) {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            // Without anybody to read it, it is lost, and the exit code remains.
            let _ = error.print();
            return ExitStatus::CommandLine as u8;
        }
        Err(text) if text.kind() == ErrorKind::DisplayVersion && words.iter().any(|word| word == "--verbose") => {
            return status(commands::print(&commands::verbose_version()).map(|()| ExitStatus::Done));
        }
        // Help and version are no errors, whatever clap calls them.
        Err(text) => return status(text.print().map(|()| ExitStatus::Done).context("cannot write to standard output")),
    };
    let _last_line = LastLine;
    status(act(&cli))
}

/// Says that it failed, to programs that are told how it ends, if nothing else has: where a panic ends it.
struct LastLine;

impl Drop for LastLine {
    fn drop(&mut self) {
        message::end("failed", 101);
    }
}

fn act(cli: &Cli) -> Result<ExitStatus> {
    // Whoever listens hears of whatever fails from here on.
    match &cli.command {
        Command::Render(args) => message::begin(args.show.messages(), commands::start(&args.scenes)),
        Command::Watch(args) => message::begin(args.show.messages(), commands::start(&[&args.scene])),
        Command::Merge(args) => message::begin(args.messages(), commands::start(&args.parts)),
        _ => {}
    }
    let common = &Common::of(cli)?;
    match &cli.command {
        Command::Render(args) => commands::render(args, common, &Signals::listen()),
        Command::Watch(args) => commands::watch(args, common, &Signals::listen()),
        Command::Merge(args) => commands::merge(args, common),
        Command::Check { scenes, json, definitions } => commands::check(scenes, definitions, *json, common),
        Command::Completions { shell } => commands::completions(*shell),
        Command::Man { command } => commands::man(command.as_deref()),
        Command::Format { scene, write } => commands::format(scene, *write, common),
        Command::Convert { scene, output, definitions } => commands::convert(scene, output.as_deref(), definitions, common),
        Command::Plugins { kind, name, json } => commands::plugins(kind.as_deref(), name.as_deref(), *json),
        Command::Trace(args) => commands::trace(args, common),
        Command::Bench(args) => commands::bench(args, common),
        Command::Denoise(args) => commands::denoise(args, common),
        Command::Develop(args) => commands::develop(args, common),
        Command::Compare { a, b, diff, json } => commands::compare(a, b, diff.as_deref(), *json, common),
    }
}

/// The exit code; says what went wrong.
fn status(result: Result<ExitStatus>) -> u8 {
    let status = match result {
        Ok(status) => status,
        Err(error) if commands::is_closed_pipe(&error) => ExitStatus::Done,
        Err(error) => {
            say!("error: {error:#}");
            ExitStatus::Fault
        }
    };
    message::end(status.word(), status as u8);
    status as u8
}
