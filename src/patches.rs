//! The patches of surfaces that pixels see: [`bhs_engine::patch`].

use crate::job::Job;
use arrayvec::ArrayVec;
use bhs_core::ray::{Ray, RayEnd};
use bhs_engine::patch::Patch;
use bhs_engine::transport::BATCH;
use glam::{DVec2, Vec2};

/// Places in a pixel through which rays are followed: its middle, and those of two edges.
const PLACES: [[f64; 2]; 3] = [[0.5, 0.5], [1.0, 0.5], [0.5, 1.0]];

/// The patches of some pixels, in their order. Where no texture asks, there are none, and nothing is held.
pub struct Patches(Vec<Option<Patch>>);

impl Patches {
    /// Those of the given pixels, through the middle of the lens.
    pub fn of(job: &Job, pixels: impl Iterator<Item = [u32; 2]>) -> Self {
        if !job.scene.wants_patches {
            return Self(Vec::new());
        }
        let mut rays = pixels.flat_map(|[x, y]| {
            let corner = DVec2::new(f64::from(x), f64::from(y));
            PLACES.map(|place| job.camera_ray(corner + DVec2::from_array(place), Vec2::splat(0.5)).0)
        });
        let mut found = Vec::new();
        let mut ends = [RayEnd::NONE; BATCH];
        loop {
            let batch: ArrayVec<Ray, BATCH> = rays.by_ref().take(BATCH - BATCH % PLACES.len()).collect();
            if batch.is_empty() {
                return Self(found);
            }
            job.scene.integrator.trace_all(&job.scene.world, &batch, &mut ends[..batch.len()]);
            found.extend(ends[..batch.len()].as_chunks().0.iter().map(|ends| Patch::new(job.scene, ends)));
        }
    }

    /// That of the pixel number `i` of those.
    #[inline]
    pub fn get(&self, i: usize) -> Option<Patch> {
        self.0.get(i).copied().flatten()
    }
}
