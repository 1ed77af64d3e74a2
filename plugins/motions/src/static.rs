//! `static`: at rest, as everything is that names no motion.
//!
//! ```bhs
//! Camera "perspective" "string motion" "static"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::Params;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> = Plugin { name: "static", summary: "at rest, as everything that names no motion", build };

#[derive(Debug)]
struct Static;

fn build(_: &Params) -> Option<Box<dyn Motion>> {
    Some(Box::new(Static))
}

impl Motion for Static {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        here.at_rest()
    }

    fn is_static(&self) -> bool {
        true
    }
}
