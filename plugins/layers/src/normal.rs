//! `normal`: the surface's outer unit normal, in world space, of the chart.
//!
//! ```bhs
//! Film "rgb" "string layers" "normal"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Display, Layer, LayerFormat, Statistic, Value, VisibleSurface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "normal", summary: "the surface's outer unit normal, in world space, of the chart", build };

struct Normal;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Normal))
}

impl Layer for Normal {
    fn format(&self) -> LayerFormat {
        let format = LayerFormat::new(&["N.X", "N.Y", "N.Z"], "").shown(Display::Range([-1.0, 1.0]));
        LayerFormat { statistic: Statistic::MeanDirection, ..format }
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        seen.surface().map(|surface| surface.normal.to_array())
    }
}
