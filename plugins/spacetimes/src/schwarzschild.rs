//! `schwarzschild`: a hole that neither spins nor has charge. World space is its areal chart.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `center` | point3 | [0 0 0] | scene | centre, under the current transform |
//! | `rs` | float | required | scene | Schwarzschild radius `2 G M / c^2`, under the current transform |

use crate::placement::{Placement, center, length};
use crate::round::spacetime_of;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::spacetime::{Spacetime, Spherical};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> =
    Plugin { name: "schwarzschild", summary: "a black hole that neither spins nor has charge", build };

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let center = center(p);
    let rs = length(p, "rs", "Schwarzschild radius, under the current transform");
    let placement = Placement::of(p)?;
    spacetime_of(p, Spherical { center: placement.point(center), rs: placement.length(rs?), charge_squared: 0.0 })
}
