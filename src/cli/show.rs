//! What is shown of a render while it goes on.

use crate::display::{Address, Display};
use crate::message::Form;
use crate::progress::ProgressForm;
use clap::Args;

/// What is shown of a render while it goes on.
#[derive(Args, Clone, Debug, Default)]
pub struct ShowArgs {
    /// How progress is shown on standard error: `tty` on a terminal, `lines` elsewhere, and `none` with --quiet if not given
    #[arg(long, value_enum, value_name = "FORM")]
    pub progress: Option<ProgressForm>,
    /// Show the picture under way in a viewer that listens there, such as tev or HDRView: at 127.0.0.1:14158 if no place is given
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true)]
    pub display_server: Option<Option<Address>>,
}

impl ShowArgs {
    /// Looks for the viewer, if one is asked for.
    pub fn display(&self, quiet: bool) -> Option<Display> {
        self.display_server.as_ref().map(|address| Display::start(address.clone().unwrap_or_default(), quiet))
    }

    /// The form of everything on standard error.
    pub fn messages(&self) -> Form {
        self.progress.map_or(Form::Plain, ProgressForm::of_messages)
    }
}
