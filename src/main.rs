//! The program `bhs`: reads the command line, does what it says, exits with the right code.

use bhs::cli::{Cli, Command};
use bhs::commands::{self, ExitStatus};
use bhs::say;
use bhs::signals::Signals;
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors, whatever clap calls them.
            let status = if error.use_stderr() { ExitStatus::CommandLine } else { ExitStatus::Done };
            let _ = error.print();
            return status.into();
        }
    };
    let color = cli.color.on_standard_error();
    let result = match &cli.command {
        Command::Render(args) => commands::render(args, color, &Signals::listen()),
        Command::Check { scene, json } => commands::check(scene, *json, color),
        Command::Format { scene, write } => commands::format(scene, *write, color),
        Command::Plugins { kind, name, json } => commands::plugins(kind.as_deref(), name.as_deref(), *json),
        Command::Trace(args) => commands::trace(args, color),
        Command::Bench(args) => commands::bench(args, color),
        Command::Compare { a, b, json } => commands::compare(a, b, *json),
    };
    match result {
        Ok(status) => status.into(),
        Err(error) if commands::is_closed_pipe(&error) => ExitStatus::Done.into(),
        Err(error) => {
            say!("error: {error:#}");
            ExitStatus::Fault.into()
        }
    }
}
