//! `carter`: Carter's constant Q of the light that arrives, at energy 1; around a hole without spin, the square of what of its angular momentum lies across +y.
//!
//! ```bhs
//! Film "rgb" "string layers" "carter"
//! WorldBegin
//! ```

use crate::orbit::Constants;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "carter", summary: "Carter's constant Q of the light", build };

struct Carter;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Carter))
}

impl Layer for Carter {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["carter"], "scene^2")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        Constants::of(seen).map(|constants| scalar(constants.carter))
    }
}
