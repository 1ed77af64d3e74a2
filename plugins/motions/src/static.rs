//! `static`: at rest, as everything is that names no motion.
//!
//! ```bhs
//! Camera "perspective" "string motion" "static"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::motion::Motion;
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Place, Spacetime};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> = Plugin { name: "static", summary: "at rest, as everything that names no motion", build };

#[derive(Debug)]
struct Static;

fn build(_: &Params) -> Option<Box<dyn Motion>> {
    Some(Box::new(Static))
}

impl Motion for Static {
    fn observer(&self, _: Option<&dyn Spacetime>, _: Place, at_rest: Option<Observer>) -> Option<Observer> {
        at_rest
    }

    fn is_static(&self) -> bool {
        true
    }
}
