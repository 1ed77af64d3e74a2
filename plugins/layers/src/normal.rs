//! `normal`: the surface's outer unit normal, in world space, of the chart; in mirrors and through smooth glass that of the surface that is seen
//! there.
//!
//! It is followed there as `albedo` is.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `firstsurface` | bool | false | | whether it is that of the first surface, and not of what is seen in mirrors and through smooth glass |
//!
//! ```bhs
//! Film "rgb" "string layers" "normal"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Display, Layer, LayerFormat, Statistic, Value, VisibleSurface, read_first_surface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "normal", summary: "the surface's outer unit normal, in world space, of the chart", build };

struct Normal {
    first_surface: bool,
}

fn build(p: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Normal { first_surface: read_first_surface(p) }))
}

impl Layer for Normal {
    fn format(&self) -> LayerFormat {
        let format = LayerFormat::new(&["N.X", "N.Y", "N.Z"], "").shown(Display::Range([-1.0, 1.0]));
        LayerFormat { statistic: Statistic::MeanDirection, ..format }
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let first = seen.surface()?;
        let behind = if self.first_surface { None } else { seen.behind() };
        let behind = behind.as_ref().and_then(|(behind, _)| behind.surface());
        Some(behind.unwrap_or(first).normal.to_array())
    }
}
