//! How progress is shown.

use crate::message::Form;
use clap::ValueEnum;
use std::io::IsTerminal;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressForm {
    /// A bar; lines where standard error is no terminal
    Tty,
    /// A line every few seconds
    Lines,
    /// A JSON object a line, for programs: `start`, `progress`, `picture`, `message`, `diagnostic`, and exactly one `end`, which is the last
    Json,
    /// Lines of Open Job Description: `openjd_progress`, `openjd_status`, `openjd_fail`
    Openjd,
    /// Nothing
    None,
}

impl ProgressForm {
    /// What is asked for, or else fits: a bar on a terminal, lines elsewhere, nothing with `--quiet`.
    pub fn choose(asked: Option<Self>, quiet: bool) -> Self {
        let is_terminal = || std::io::stderr().is_terminal();
        match asked {
            None if quiet => Self::None,
            None | Some(Self::Tty) => {
                if is_terminal() {
                    Self::Tty
                } else {
                    Self::Lines
                }
            }
            Some(other) => other,
        }
    }

    /// The form of all that is said with it.
    pub fn of_messages(self) -> Form {
        match self {
            Self::Json => Form::Json,
            Self::Openjd => Form::OpenJd,
            Self::Tty | Self::Lines | Self::None => Form::Plain,
        }
    }
}
