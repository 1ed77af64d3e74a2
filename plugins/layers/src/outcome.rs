//! `outcome`: shares of the rays that arrive on a surface, escape, and fall into the hole.
//!
//! ```bhs
//! Film "rgb" "string layers" "outcome"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::Arrival;
use bhs_engine::layer::{Display, Layer, LayerFormat, Value, VisibleSurface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "outcome", summary: "shares of the rays that hit a surface, escape, fall into the hole", build };

struct Outcome;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Outcome))
}

impl Layer for Outcome {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["outcome.hit", "outcome.escaped", "outcome.captured"], "").shown(Display::Range([0.0, 1.0]))
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        match seen.end.arrival {
            Arrival::Surface(_) => Some([1.0, 0.0, 0.0]),
            Arrival::Sky(..) => Some([0.0, 1.0, 0.0]),
            Arrival::Captured => Some([0.0, 0.0, 1.0]),
            Arrival::OutOfSteps => None,
        }
    }
}
