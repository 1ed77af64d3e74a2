//! `bhs merge`

use crate::message::Form;
use crate::progress::ProgressForm;
use clap::Args;
use std::path::PathBuf;

/// `bhs merge`
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// The parts, in any order; those of several frames and cameras make several pictures
    #[arg(required = true, value_name = "PART.bhspart")]
    pub parts: Vec<PathBuf>,
    /// EXR file to write; the PNG stands beside it. Of several pictures: OUT.CAMERA.FRAME.exr, as `render` names them
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Join what there is: leave out what is missing, and files that do not belong, with a warning
    #[arg(long)]
    pub partial: bool,
    /// Write every layer as OUT.NAME.png too, for people to look at
    #[arg(long)]
    pub false_color: bool,
    /// Replace no file: end if one of the outputs is there
    #[arg(long)]
    pub no_overwrite: bool,
    /// No closing words
    #[arg(long)]
    pub quiet: bool,
    /// How what happens is told on standard error: `json` and `openjd` are for programs
    #[arg(long, value_enum, value_name = "FORM")]
    pub progress: Option<ProgressForm>,
}

impl MergeArgs {
    /// The form of everything on standard error.
    pub fn messages(&self) -> Form {
        self.progress.map_or(Form::Plain, ProgressForm::of_messages)
    }
}
