//! Light followed from where it leaves to where it arrives.
//!
//! Rays of this program go back in time: [`Integrator`](crate::integrator::Integrator) follows what is seen to where it comes from, and the directions of observers are those in
//! which one looks. Light that is followed forwards moves against them: a tangent of its way is the negative of a looked direction. Where nothing
//! drags space along, both ways are the same curves; around a hole that spins, light goes forwards where it would go back around one that spins the
//! other way ([`Integrator::trace_forwards`](crate::integrator::Integrator::trace_forwards)).

use crate::scene::{Scene, Vertex};
use bhs_core::observer::Observer;
use bhs_core::ray::{Ray, SurfaceHit};
use bhs_core::spacetime::Place;
use bhs_core::spectrum::SampledWavelengths;
use glam::{DVec3, Vec3};

impl Scene {
    /// Whether it is known how light goes forwards.
    pub fn is_followed_forwards(&self) -> bool {
        !self.bends() || !self.world.spacetime().drags() || self.world.spacetime().reversed().is_some()
    }

    /// The vertex where light arrives that was followed forwards to `hit` and has the wavelengths `lambda` at E = 1: its `wo` is the direction that it
    /// comes from, its `hit.direction` the chart direction in which one looks to see it. `None` where there is no observer.
    pub fn lit_vertex(&self, hit: &SurfaceHit, lambda: &SampledWavelengths) -> Option<Vertex<'_>> {
        self.vertex_seen(SurfaceHit { direction: -hit.direction, ..*hit }, lambda, 1.0)
    }

    /// What light of the looked direction `looked` carries through a place is conserved but for this factor: area times solid angle as `observer`
    /// measures them, over the same as one at rest does at wavelength 1 (Liouville's theorem: with the square of the frequency it is the same all along
    /// a ray, for all observers).
    pub fn etendue(&self, place: Place, observer: &Observer, looked: DVec3) -> f64 {
        let of = |o: &Observer| o.solid_angle_factor(looked) * o.bundle_area_factor(looked);
        let natural = match self.bends() {
            false if !observer.moves() => return 1.0,
            false => Some(Observer::FLAT),
            true => {
                let spacetime = self.world.spacetime();
                let at_rest = spacetime.at(place).map(|here| Observer::at_rest(&here));
                at_rest.or_else(|| spacetime.normal(place).map(|here| Observer::dragged(&here)))
            }
        };
        natural.map_or(0.0, |natural| {
            let ratio = natural.ratio(looked);
            of(observer) * ratio * ratio / of(&natural)
        })
    }
}

impl Vertex<'_> {
    /// The chart direction in which one looks along light that leaves in the shading direction `w`.
    pub fn looked_from(&self, w: Vec3) -> DVec3 {
        self.chart_direction(-w)
    }

    /// The ray of light that leaves in the looked direction `looked`, to be followed forwards.
    pub fn send(&self, scene: &Scene, looked: DVec3) -> Ray {
        self.leave(&scene.world, -looked, scene.footprints.rough)
    }
}
