//! The plain hole of a world as a spacetime.

use bhs_core::spacetime::{Ball, Class, Metric, Place, Side, Spacetime, Spherical, Stationary};
use glam::DVec3;
use std::sync::Arc;

/// A round hole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain(pub Spherical);

impl Spacetime for Plain {
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
