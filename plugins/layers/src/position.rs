//! `position`: the point of the surface, in world space.
//!
//! ```bhs
//! Film "rgb" "string layers" "position"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "position", summary: "point of the surface, world space", build };

struct Position;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Position))
}

impl Layer for Position {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["P.X", "P.Y", "P.Z"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        seen.hit().map(|hit| (hit.point + seen.scene.world.origin).to_array())
    }
}
