//! `samples`: the number of samples of a pixel, which differs from pixel to pixel where a sampler is given a `noise`.
//!
//! ```bhs
//! Film "rgb" "string layers" "samples"
//! Sampler "sobol" "float noise" 0.02
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Statistic, Value, VisibleSurface, scalar};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "samples", summary: "samples of the pixel", build };

struct Samples;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Samples))
}

impl Layer for Samples {
    fn format(&self) -> LayerFormat {
        LayerFormat { statistic: Statistic::Sum, ..LayerFormat::new(&["samples"], "") }
    }

    fn value(&self, _: &VisibleSurface) -> Option<Value> {
        Some(scalar(1.0))
    }
}
