//! `impactparameter`: b = L/E of the orbit; the critical one of a plain hole is 2.598 rs. Around a hole that spins, the same of L about all axes,
//! `b = sqrt(Q + L^2)`: that of light from far away on the equator, and 0 for light so near to the axis that the root has none.
//!
//! ```bhs
//! Film "rgb" "string layers" "impactparameter"
//! WorldBegin
//! ```

use crate::orbit::impact_parameter;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "impactparameter", summary: "impact parameter of the orbit", build };

struct ImpactParameter;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(ImpactParameter))
}

impl Layer for ImpactParameter {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["impactparameter"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        impact_parameter(seen).map(scalar)
    }
}
