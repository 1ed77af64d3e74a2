//! The program `bhs`: [`bhs::program`], by the code that suits the processor ([`bhs::vectors`]).

use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    // In a download this is the program for the least processor, with those for better ones beside it.
    match bhs::vectors::hand_over(&words) {
        Ok(Some(code)) => code.into(),
        Ok(None) => bhs::program::run(&words).into(),
        Err(why) => {
            bhs::say!("error: {why}");
            ExitCode::FAILURE
        }
    }
}
