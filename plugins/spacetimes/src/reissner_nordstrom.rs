//! `reissner-nordstrom`: a hole with charge. World space is its areal chart. Light does not feel the charge but by the metric.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `center` | point3 | [0 0 0] | scene | centre, under the current transform |
//! | `rs` | float | required | scene | `2 G M / c^2`, under the current transform: not the horizon, which is `(rs/2) (1 + sqrt(1 - charge^2))` |
//! | `charge` | float | 0 | | charge, as a share of the largest that a hole of this mass can have |

use crate::placement::{Placement, center, charge, length};
use crate::round::spacetime_of;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::spacetime::{Spacetime, Spherical};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> = Plugin { name: "reissner-nordstrom", summary: "a black hole with charge", build };

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let center = center(p);
    let rs = length(p, "rs", "2 G M / c^2, under the current transform");
    let charge = charge(p);
    let placement = Placement::of(p)?;
    let rs = placement.length(rs?);
    let q = 0.5 * rs * charge;
    spacetime_of(p, Spherical { center: placement.point(center), rs, charge_squared: q * q })
}
