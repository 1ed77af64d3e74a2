//! `queries`: segments of the ray that were put to the intersector.
//!
//! ```bhs
//! Film "rgb" "string layers" "queries"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "queries", summary: "segments that were put to the intersector", build };

struct Queries;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Queries))
}

impl Layer for Queries {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["queries"], "")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        Some(scalar(f64::from(seen.end.cost.queries)))
    }
}
