//! How light travels: the contract of the integrators of light rays.

use crate::connections::Connections;
use crate::way::{SweptAngle, TimedWay, TravelTime, Watch, WayPoint};
use crate::world::World;
use bhs_core::ray::{Arrival, Cost, Ray, RayEnd};
use bhs_core::spacetime::{Side, Spacetime};
use glam::DVec3;

/// Follows light in the spacetime that it was built for, in any scene.
pub trait Integrator: Send + Sync {
    /// Follows each of `rays` and writes what became of it to its place in `ends`. What becomes of a ray does not depend on the others.
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]);

    /// Follows each of `rays` to where light goes that starts along it, in the same way; where space is not dragged along that is where light comes from
    /// along it. For scenes of which [`Scene::is_followed_forwards`](crate::scene::Scene::is_followed_forwards) says that it is known.
    fn trace_forwards(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.trace_all(world, rays, ends);
    }

    /// Follows one ray: what becomes of it is to the bit what [`Integrator::trace_all`] says.
    fn trace(&self, world: &World, ray: &Ray) -> RayEnd {
        let mut end = RayEnd::NONE;
        self.trace_all(world, std::slice::from_ref(ray), std::slice::from_mut(&mut end));
        end
    }

    /// The same, and shows its way to `watch`: the points between which it was put to the intersector, and the curve that it follows.
    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd;

    /// The same, and the points of its way (render space).
    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>) {
        let mut points = Vec::new();
        let end = self.watched(world, ray, &mut points);
        (end, points)
    }

    /// The same points, with the time that light takes from each to the start of the ray.
    fn way(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<WayPoint>) {
        let mut way = TimedWay::new(world);
        let end = self.watched(world, ray, &mut way);
        (end, way.points(ray.side))
    }

    /// Coordinate time that light takes from the surface on which `ray` ends to where it starts (scene units), to rounding along the curve that is
    /// followed (`docs/physics.md`, section 1). It is followed again for that.
    ///
    /// `None` if it ends on no surface: from the sky and from a horizon light takes for ever. Times of light from the sky compare where a sphere around
    /// the scene, or a plane across the light, is put there as a surface.
    fn travel_time(&self, world: &World, ray: &Ray) -> Option<f64> {
        let mut time = TravelTime::new(world);
        let end = self.watched(world, ray, &mut time);
        (matches!(end.arrival, Arrival::Surface(_)) && time.time.is_finite()).then_some(time.time)
    }

    /// [`Integrator::travel_time`] as precise as pictures need it, to some 1e-6 along the curve, in less than half of the time.
    fn travel_time_roughly(&self, world: &World, ray: &Ray) -> Option<f64> {
        let mut time = TravelTime::rough(world);
        let end = self.watched(world, ray, &mut time);
        (matches!(end.arrival, Arrival::Surface(_)) && time.time.is_finite()).then_some(time.time)
    }

    /// Angle that `ray` sweeps around the point `center` (render space; rad) until it meets a surface; `None` if it meets none. It is followed again
    /// for that.
    fn swept_angle(&self, world: &World, ray: &Ray, center: DVec3) -> Option<f64> {
        let mut swept = SweptAngle::new(center);
        let end = self.watched(world, ray, &mut swept);
        (matches!(end.arrival, Arrival::Surface(_)) && swept.angle.is_finite()).then_some(swept.angle)
    }

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
