//! `shadingnormal`: the unit normal that shading uses, in world space, of the chart.
//!
//! ```bhs
//! Film "rgb" "string layers" "shadingnormal"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Display, Layer, LayerFormat, Statistic, Value, VisibleSurface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "shadingnormal", summary: "the unit normal that shading uses, in world space, of the chart", build };

struct ShadingNormal;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(ShadingNormal))
}

impl Layer for ShadingNormal {
    fn format(&self) -> LayerFormat {
        let format = LayerFormat::new(&["Ns.X", "Ns.Y", "Ns.Z"], "").shown(Display::Range([-1.0, 1.0]));
        LayerFormat { statistic: Statistic::MeanDirection, ..format }
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        seen.hit().map(|hit| seen.scene.shading_normal(hit).to_array())
    }
}
