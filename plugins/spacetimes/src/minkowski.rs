//! `minkowski`: flat space, where light moves along straight lines.

use bhs_core::Plugin;
use bhs_core::dual::Dual;
use bhs_core::params::Params;
use bhs_core::spacetime::{Ball, Class, Fields, Metric, Place, Side, Spacetime, Stationary};
use glam::DVec3;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> =
    Plugin { name: "minkowski", summary: "flat space, where light moves along straight lines", build };

fn build(_: &Params) -> Option<Box<dyn Spacetime>> {
    Some(Box::new(Minkowski::default()))
}

/// Flat space, or two of them that are not connected.
#[derive(Clone, Copy, Debug, Default)]
pub struct Minkowski {
    /// Whether there is a far side, to which no light comes: what a wormhole without a throat leaves.
    pub far_side: bool,
}

impl Spacetime for Minkowski {
    fn at(&self, place: Place) -> Option<Stationary> {
        (place.side == Side::Near || self.far_side).then_some(Stationary::FLAT)
    }

    fn captures(&self) -> Vec<Ball> {
        Vec::new()
    }

    fn class(&self) -> Class<'_> {
        Class::Flat
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn has_far_side(&self) -> bool {
        self.far_side
    }

    fn moved(&self, _: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(*self)
    }
}

impl Metric for Minkowski {
    fn fields(&self, _: [Dual; 3]) -> Fields {
        Fields::isotropic(Dual::constant(1.0), Dual::constant(1.0))
    }
}
