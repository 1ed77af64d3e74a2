//! `sinc`: the sharpest, with the most ringing: sin(x)/x under the window of Lanczos.
//!
//! Negative lobes count with negative weights, so that noise is larger, and a pixel beside a very bright one may be negative.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xradius` | float | 4 | pixels | half width |
//! | `yradius` | float | 4 | pixels | half height |
//! | `tau` | float | 3 | | half width of the window, in zeros of the curve |
//!
//! ```bhs
//! PixelFilter "sinc"
//! WorldBegin
//! ```

use crate::radii;
use crate::separable::Separable;
use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;
use bhs_elementary::Elementary;
use std::f64::consts::PI;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Filter> =
    Plugin { name: "sinc", summary: "the sharpest, with the most ringing: sin(x)/x under a window", build };

fn build(p: &Params) -> Option<Box<dyn Filter>> {
    let radii = radii(p, 4.0);
    let tau = p.get_in("tau", 3.0, 1e-3..=64.0, "", "half width of the window, in zeros of the curve");
    Some(Box::new(Separable::new(radii, |_| move |x: f64| sinc(x) * sinc(x / tau))))
}

fn sinc(x: f64) -> f64 {
    let x = PI * x;
    // Below, 1 to double precision.
    if x.abs() < 1e-8 { 1.0 } else { x.sine() / x }
}
