//! A round hole, with or without charge.

use crate::Minkowski;
use crate::placement::in_range;
use bhs_core::params::Params;
use bhs_core::spacetime::{Spacetime, Spherical};

/// The spacetime of `hole` (`docs/physics.md`, sections 3 and 4), if its coordinates can be computed with; without mass it is flat.
pub fn spacetime_of(p: &Params, hole: Spherical) -> Option<Box<dyn Spacetime>> {
    if !in_range(p, &[hole.center], &[hole.rs]) {
        return None;
    }
    Some(if hole.rs == 0.0 { Box::new(Minkowski::default()) } else { Box::new(hole) })
}
