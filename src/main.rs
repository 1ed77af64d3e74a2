//! The program `bhs`: [`bhs::program`].

use std::process::ExitCode;

fn main() -> ExitCode {
    bhs::program::run(&std::env::args_os().collect::<Vec<_>>()).into()
}
