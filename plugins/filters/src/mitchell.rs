//! `mitchell`: sharp, with a little ringing: the cubics of Mitchell and Netravali (1988).
//!
//! Negative lobes count with negative weights, so that noise is somewhat larger, and a pixel beside a very bright one may be negative.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xradius` | float | 2 | pixels | half width |
//! | `yradius` | float | 2 | pixels | half height |
//! | `B` | float | 0.3333333333333333 | | blur: 1 is the cubic B-spline |
//! | `C` | float | 0.3333333333333333 | | ringing: B 0, C 0.5 is the Catmull-Rom spline |
//!
//! ```bhs
//! PixelFilter "mitchell"
//! WorldBegin
//! ```

use crate::radii;
use crate::separable::Separable;
use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Filter> =
    Plugin { name: "mitchell", summary: "sharp, with a little ringing: the cubics of Mitchell and Netravali", build };

fn build(p: &Params) -> Option<Box<dyn Filter>> {
    let radii = radii(p, 2.0);
    let b = p.get_in("B", 1.0 / 3.0, -10.0..=10.0, "", "blur: 1 is the cubic B-spline");
    let c = p.get_in("C", 1.0 / 3.0, -10.0..=10.0, "", "ringing: B 0, C 0.5 is the Catmull-Rom spline");
    Some(Box::new(Separable::new(radii, |radius| move |x: f64| cubic(2.0 * x / radius, b, c))))
}

/// The cubic of Mitchell and Netravali, over -2..2 (1988, eq. 8).
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let x = x.abs();
    let [x3, x2, x1, x0] = if x <= 1.0 {
        [12.0 - 9.0 * b - 6.0 * c, -18.0 + 12.0 * b + 6.0 * c, 0.0, 6.0 - 2.0 * b]
    } else if x <= 2.0 {
        [-b - 6.0 * c, 6.0 * b + 30.0 * c, -12.0 * b - 48.0 * c, 8.0 * b + 24.0 * c]
    } else {
        [0.0; 4]
    };
    (((x3 * x + x2) * x + x1) * x + x0) / 6.0
}
