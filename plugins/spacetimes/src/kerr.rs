//! `kerr`: a hole that spins, with or without charge. World space is its Boyer-Lindquist chart drawn as oblate spheroids: spheres of equal radius
//! are ellipsoids with common foci.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `center` | point3 | [0 0 0] | scene | centre, under the current transform |
//! | `rs` | float | required | scene | `2 G M / c^2`, under the current transform: not the horizon |
//! | `spin` | float | required | | angular momentum as a share of the largest, `a / M`, between -1 and 1 |
//! | `charge` | float | 0 | | charge, as a share of the largest that a hole of this mass can have without spin |
//! | `axis` | vector3 | [0 1 0] | | axis of the spin, under the current transform |
//!
//! Space is dragged along `axis x x`, by components: with the axis +y and z into the picture, what is at x > 0 moves towards -z. A transform that
//! mirrors turns the spin around, as it does with everything.

use crate::Minkowski;
use crate::placement::{Placement, center, charge, in_range, length};
use crate::round::spacetime_of;
use bhs_core::Plugin;
use bhs_core::params::{Params, Vector3};
use bhs_core::spacetime::{Kerr, Spacetime, Spherical};
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> = Plugin { name: "kerr", summary: "a black hole that spins", build };

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let center = center(p);
    let rs = length(p, "rs", "2 G M / c^2, under the current transform");
    let spin = p.require::<f64>("spin", "", "angular momentum as a share of the largest, between -1 and 1");
    let charge = charge(p);
    let axis = p.get("axis", Vector3(DVec3::Y), "", "axis of the spin, under the current transform").0;
    let mut right = true;
    if let Some(spin) = spin {
        if !(spin > -1.0 && spin < 1.0) {
            p.reject("spin", "`spin` is out of range", format!("expected a number above -1 and below 1, found {spin}"));
            right = false;
        } else if spin != 0.0 && spin * spin + charge * charge > 1.0 {
            let most = (1.0 - spin * spin).sqrt();
            p.reject("charge", "spin and charge are too large for the mass", format!("with this spin, expected at most {most}"));
            right = false;
        }
    }
    let placement = Placement::of(p)?;
    let axis = placement.axis(axis);
    if axis.is_none() {
        p.reject("axis", "`axis` has no direction", "expected a vector that is not 0");
    }
    let (rs, spin, axis) = (placement.length(rs?), spin?, axis?);
    let center = placement.point(center);
    let q = 0.5 * rs * charge;
    let round = Spherical { center, rs, charge_squared: q * q };
    if spin == 0.0 {
        return spacetime_of(p, round);
    }
    if !right || !in_range(p, &[center], &[rs, 0.5 * rs * spin]) {
        return None;
    }
    Some(if rs == 0.0 { Box::new(Minkowski::default()) } else { Box::new(Kerr::new(round, axis, spin)) })
}
