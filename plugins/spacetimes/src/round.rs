//! A round hole, with or without charge.

use crate::Minkowski;
use crate::placement::in_range;
use bhs_core::params::Params;
use bhs_core::spacetime::{Ball, Class, Metric, Place, Side, Spacetime, Spherical, Stationary};
use glam::DVec3;
use std::sync::Arc;

/// A Schwarzschild or Reissner-Nordstroem hole in the areal chart (`docs/physics.md`, sections 3 and 4).
#[derive(Clone, Copy, Debug)]
pub struct Round(pub Spherical);

/// The spacetime of `hole`, if its coordinates can be computed with; without mass it is flat.
pub fn spacetime_of(p: &Params, hole: Spherical) -> Option<Box<dyn Spacetime>> {
    if !in_range(p, &[hole.center], &[hole.rs]) {
        return None;
    }
    Some(if hole.rs == 0.0 { Box::new(Minkowski::default()) } else { Box::new(Round(hole)) })
}

impl Spacetime for Round {
    fn at(&self, place: Place) -> Option<Stationary> {
        if place.side == Side::Far { None } else { self.0.at(place.x) }
    }

    fn captures(&self) -> Vec<Ball> {
        vec![Ball { center: self.0.center, radius: self.0.horizon() }]
    }

    fn class(&self) -> Class<'_> {
        Class::Spherical(self.0)
    }

    fn metric(&self) -> &dyn Metric {
        &self.0
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(Self(Spherical { center: self.0.center - origin, ..self.0 }))
    }
}
