//! The patches of surfaces that pixels see: [`bhs_engine::patch`].

use crate::job::Job;
use bhs_core::ray::{Ray, RayEnd};
use bhs_engine::patch::Patch;
use bhs_engine::transport::BATCH;
use glam::{DVec2, Vec2};

/// Places in a pixel through which rays are followed: its middle, and those of two edges.
const PLACES: [[f64; 2]; 3] = [[0.5, 0.5], [1.0, 0.5], [0.5, 1.0]];

/// The patches of the given pixels, through the middle of the lens; `None` of all of them where no texture asks.
pub fn patches(job: &Job, pixels: &[[u32; 2]]) -> Vec<Option<Patch>> {
    if !job.scene.wants_patches {
        return vec![None; pixels.len()];
    }
    let mut found = Vec::with_capacity(pixels.len());
    let mut rays: Vec<Ray> = Vec::with_capacity(BATCH);
    let mut ends = [RayEnd::NONE; BATCH];
    for pixels in pixels.chunks(BATCH / PLACES.len()) {
        rays.clear();
        rays.extend(pixels.iter().flat_map(|[x, y]| {
            let corner = DVec2::new(f64::from(*x), f64::from(*y));
            PLACES.map(|place| job.camera_ray(corner + DVec2::from_array(place), Vec2::splat(0.5)).0)
        }));
        job.scene.integrator.trace_all(&job.scene.world, &rays, &mut ends[..rays.len()]);
        found.extend(ends[..rays.len()].as_chunks().0.iter().map(|ends| Patch::new(job.scene, ends)));
    }
    found
}
