//! `side`: the side of a wormhole on which the ray ends, on a surface or far away: 0 the near one, 1 the far one.
//!
//! ```bhs
//! Film "rgb" "string layers" "side"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::Arrival;
use bhs_engine::layer::{Display, Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "side", summary: "side of a wormhole on which the ray ends: 0 near, 1 far", build };

struct SideOfWormhole;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(SideOfWormhole))
}

impl Layer for SideOfWormhole {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["side"], "").shown(Display::Range([0.0, 1.0]))
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let side = match &seen.end.arrival {
            Arrival::Surface(hit) => seen.scene.world.side_of(hit.geometry),
            Arrival::Sky(_, side) => *side,
            Arrival::Captured | Arrival::OutOfSteps => return None,
        };
        Some(scalar(f64::from(side as u8)))
    }
}
