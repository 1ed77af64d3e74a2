//! `variance`: the variance of the samples of a pixel's colour; that of the pixel is this over their number.
//!
//! What samples bring is no matter of the camera's ray: the frame, which has their colours, finds it ([`Statistic::ColorVariance`]).
//!
//! ```bhs
//! Film "rgb" "string layers" "variance"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_engine::layer::{Layer, LayerFormat, Statistic, Value, VisibleSurface};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "variance", summary: "variance of the samples of the colour", build };

struct Variance;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Variance))
}

impl Layer for Variance {
    fn format(&self) -> LayerFormat {
        let format = LayerFormat::new(&["Variance.R", "Variance.G", "Variance.B"], "");
        LayerFormat { statistic: Statistic::ColorVariance, ..format }
    }

    fn value(&self, _: &VisibleSurface) -> Option<Value> {
        None
    }
}
