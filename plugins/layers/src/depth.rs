//! `depth`: the distance of the surface's point from where the ray starts, in a straight line of the chart. None of what is on the other side of a
//! wormhole: no straight line of a chart leads there.
//!
//! ```bhs
//! Film "rgb" "string layers" "depth"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "depth", summary: "distance of the surface from where the ray starts, in the chart", build };

struct Depth;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Depth))
}

impl Layer for Depth {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["depth"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let hit = seen.hit().filter(|hit| seen.scene.world.side_of(hit.geometry) == seen.ray.side)?;
        Some(scalar((hit.point - seen.ray.origin).length()))
    }
}
