//! `winding`: turns around the hole, the swept angle over 2 pi.
//!
//! ```bhs
//! Film "rgb" "string layers" "winding"
//! WorldBegin
//! ```

use crate::orbit::swept_angle;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};
use std::f64::consts::TAU;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "winding", summary: "turns around the hole: the swept angle over 2 pi", build };

struct Winding;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Winding))
}

impl Layer for Winding {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["winding"], "")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        swept_angle(seen).map(|phi| scalar(phi / TAU))
    }
}
