//! `traveltime`: the coordinate time that the light has taken from the surface to where the ray starts: in flat space their distance (lengths over c). None
//! of light from the sky, which has taken for ever.
//!
//! ```bhs
//! Film "rgb" "string layers" "traveltime"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "traveltime", summary: "coordinate time that the light has taken from the surface", build };

struct TravelTime;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(TravelTime))
}

impl Layer for TravelTime {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["traveltime"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let scene = seen.scene;
        scene.integrator.travel_time(&scene.world, &seen.ray).map(scalar)
    }
}
