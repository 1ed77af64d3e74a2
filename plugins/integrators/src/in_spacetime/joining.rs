//! An integrator in a spacetime of a refractive index, with the rays between two points for light sampling.

use crate::graded_index::connect::GradedConnections;
use crate::in_spacetime::InSpacetime;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray, Traced};
use bhs_core::observer::Observer;
use bhs_core::spacetime::Place;
use bhs_core::stats::TraceLog;
use bhs_core::world::World;

/// Rays that can be followed, and found.
#[derive(Clone, Copy, Debug)]
pub struct Joining {
    /// Follows them.
    pub follows: InSpacetime,
    /// Finds them.
    pub connections: GradedConnections,
}

impl Integrator for Joining {
    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        self.follows.trace(world, ray, log)
    }

    fn trace_all(&self, world: &World, rays: &[Ray], traced: &mut [Traced], log: &mut TraceLog) {
        self.follows.trace_all(world, rays, traced, log);
    }

    fn observer(&self, world: &World, place: Place) -> Option<Observer> {
        self.follows.observer(world, place)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        Some(&self.connections)
    }

    fn is_curved(&self) -> bool {
        true
    }
}
