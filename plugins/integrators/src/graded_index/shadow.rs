//! Shadow rays along the rays of a refractive index.

use crate::graded_index::course::GradedSetup;
use crate::tracing::shadow::{ERROR, Sought, close};
use crate::tracing::surfaces::Surfaces;
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::ray::Cost;
use bhs_core::spacetime::Class;
use bhs_engine::connections::ShadowRay;
use bhs_engine::world::World;

/// Whether nothing stands between the start of `shadow_ray` and the point of its ray at the parameter `sigma_end`, which is about where it ends;
/// chords stray from the ray by at most `tolerance` (scene units). `false` in spacetimes that have no refractive index.
///
/// Makes what is told of the world anew: [`occluded_in`] is for several.
pub fn reaches(world: &World, shadow_ray: &ShadowRay, sigma_end: f64, tolerance: f64) -> bool {
    let Class::Index(index) = world.spacetime().class() else { return false };
    let setting = GradedSetup::new(world, world.spacetime(), index);
    let mut occluded = [true];
    occluded_in(&setting, world, std::slice::from_ref(shadow_ray), |_| (sigma_end, tolerance), &mut occluded);
    !occluded[0]
}

/// Whether each of `shadow_rays` is occluded, with what is told of the world once. `ends` says of each the parameter of its end,
/// and how far chords may stray (scene units).
pub fn occluded_in(
    setting: &GradedSetup<'_>,
    world: &World,
    shadow_rays: &[ShadowRay],
    ends: impl Fn(&ShadowRay) -> (f64, f64),
    occluded: &mut [bool],
) -> Cost {
    let surfaces = Surfaces::of(world);
    let mut cost = Cost::default();
    for (rays, occluded) in shadow_rays.chunks(LANES).zip(occluded.chunks_mut(LANES)) {
        let sought = Sought::<Lanes>::new(rays, |ray| {
            let (sigma_end, gap) = ends(ray);
            let n = setting.medium.at::<f64>(ray.to.x.into()).0.sqrt();
            // The last chord ends just before the end: |dx/dsigma| = n.
            ((sigma_end - close(ray) / n).max(0.0), gap)
        });
        let mut course = setting.rays(sought.x, sought.d, sought.far, Lanes::splat(ERROR));
        cost += sought.occluded((world, &surfaces), rays, &mut course, occluded);
    }
    cost
}
