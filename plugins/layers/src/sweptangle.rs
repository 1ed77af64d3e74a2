//! `sweptangle`: the angle around the hole from the camera to where the ray ends.
//!
//! ```bhs
//! Film "rgb" "string layers" "sweptangle"
//! WorldBegin
//! ```

use crate::orbit::swept_angle;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "sweptangle", summary: "angle swept around the hole", build };

struct SweptAngle;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(SweptAngle))
}

impl Layer for SweptAngle {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["sweptangle"], "rad")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        swept_angle(seen).map(scalar)
    }
}
