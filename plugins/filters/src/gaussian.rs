//! `gaussian`: a bell that is moved down to reach zero at the radius. The default of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xradius` | float | 1.5 | pixels | half width |
//! | `yradius` | float | 1.5 | pixels | half height |
//! | `sigma` | float | 0.5 | pixels | standard deviation of the bell |
//!
//! ```bhs
//! PixelFilter "gaussian" "float sigma" 0.4
//! WorldBegin
//! ```

use crate::radii;
use crate::separable::Separable;
use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;
use bhs_elementary::Elementary;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Filter> =
    Plugin { name: "gaussian", summary: "a bell that is moved down to reach zero at the radius", build };

fn build(p: &Params) -> Option<Box<dyn Filter>> {
    let radii = radii(p, 1.5);
    let sigma = p.get_in("sigma", 0.5, 1e-3..=64.0, "pixels", "standard deviation of the bell");
    let bell = move |x: f64| (-0.5 * (x / sigma) * (x / sigma)).exponential();
    Some(Box::new(Separable::new(radii, |radius| move |x| (bell(x) - bell(radius)).max(0.0))))
}
