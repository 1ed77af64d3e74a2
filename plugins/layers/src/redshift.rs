//! `redshift`: `g = nu_observed / nu_emitted = lambda_emitted / lambda_observed`: the clock rate where the light comes from, a surface or the sky,
//! over that at the camera. Above 1 for blueshift.
//!
//! ```bhs
//! Film "rgb" "string layers" "redshift"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::Arrival;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "redshift", summary: "g = nu_observed / nu_emitted", build };

struct Redshift;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Redshift))
}

impl Layer for Redshift {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["redshift"], "")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        redshift(seen).map(scalar)
    }
}

/// `nu_observed / nu_emitted` of the light that is seen; `None` of no light, and from where nothing can stand still.
pub fn redshift(seen: &VisibleSurface) -> Option<f64> {
    let emitted = match &seen.end.arrival {
        Arrival::Surface(hit) => seen.observer()?.ratio(hit.direction),
        Arrival::Sky(..) => 1.0,
        Arrival::Captured | Arrival::OutOfSteps => return None,
    };
    Some(emitted / seen.camera_ratio)
}
