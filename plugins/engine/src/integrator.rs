//! How light travels: the contract of the integrators of light rays.

use crate::connections::Connections;
use crate::world::World;
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd};
use bhs_core::spacetime::{Side, Spacetime};
use glam::DVec3;

/// Follows light in the spacetime that it was built for, in any scene.
pub trait Integrator: Send + Sync {
    /// Follows each of `rays` and writes what became of it to its place in `ends`. What becomes of a ray does not depend on the others.
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]);

    /// Follows one ray: what becomes of it is to the bit what [`Integrator::trace_all`] says.
    fn trace(&self, world: &World, ray: &Ray) -> RayEnd {
        let mut end = RayEnd::NONE;
        self.trace_all(world, std::slice::from_ref(ray), std::slice::from_mut(&mut end));
        end
    }

    /// The same, and the points of its way (render space): those between which it was put to the intersector, and as many where free space was
    /// passed over.
    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>);

    /// Whether each of `rays` leaves the scene on the side `sides`, written to the places of `escaped`; and what that took, all of them together.
    fn escape_all(&self, world: &World, rays: &[(Ray, Side)], escaped: &mut [bool]) -> Cost {
        let mut cost = Cost::default();
        for ((ray, side), escaped) in rays.iter().zip(escaped) {
            let end = self.trace(world, ray);
            cost += end.cost;
            *escaped = matches!(end.arrival, Arrival::Sky(_, on) if on == *side);
        }
        cost
    }

    /// The geodesics between two points, if this integrator can find them; where it cannot, light transport relies on
    /// BSDF sampling.
    fn connections(&self) -> Option<&dyn Connections>;
}

/// Makes integrators for spacetimes, as it was asked to in a scene. One implementation, one plugin.
pub trait IntegratorBuilder: Send + Sync {
    /// The integrator that follows light in `spacetime`.
    ///
    /// # Errors
    /// What kinds of spacetimes the method needs, if it cannot follow rays of this one.
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String>;

    /// Whether light bends under the method where there is something that bends it.
    fn is_curved(&self) -> bool {
        true
    }
}
