//! `angularmomentum`: L of the light that arrives, at energy 1, about the axis of the hole's spin; +y, if it has none. Above 0 for light that moves along
//! `axis x x`, as space is dragged around a hole of positive spin.
//!
//! ```bhs
//! Film "rgb" "string layers" "angularmomentum"
//! WorldBegin
//! ```

use crate::orbit::Constants;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "angularmomentum", summary: "angular momentum of the light about the axis", build };

struct AngularMomentum;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(AngularMomentum))
}

impl Layer for AngularMomentum {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["angularmomentum"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        Constants::of(seen).map(|constants| scalar(constants.angular_momentum))
    }
}
