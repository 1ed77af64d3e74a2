//! Rays of a picture's whole frame, followed for what they meet.

use crate::render::Job;
use bhs_core::camera::CameraRay;
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::spectrum::{SampledWavelengths, VisibleWavelengths};
use glam::{DVec2, Vec2};

/// Rays across and down the frame, also of a picture with few pixels; an odd number, so that one goes through the middle.
const GRID: u32 = 25;

/// A ray of the camera.
#[derive(Clone, Copy)]
pub struct ProbeRay {
    /// As the camera sees it.
    pub seen: CameraRay,
    /// In the chart; `None` where nothing can stand still.
    pub ray: Option<Ray>,
}

/// Rays evenly spread over the whole frame, through the middle of the lens.
pub fn rays(job: &Job) -> Vec<ProbeRay> {
    let [width, height] = job.film.resolution().map(f64::from);
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
    let mut rays = Vec::new();
    for y in 0..GRID {
        for x in 0..GRID {
            let raster = DVec2::new(at(x) * width, at(y) * height);
            let seen = job.camera.ray(raster, Vec2::splat(0.5));
            rays.push(ProbeRay { seen, ray: chart_ray(job, &seen) });
        }
    }
    rays
}

/// The ray in the chart along which an observer at the camera's viewpoint sees what `seen` shows.
pub fn chart_ray(job: &Job, seen: &CameraRay) -> Option<Ray> {
    let (ray, ratio) = job.scene.camera_ray(seen, job.viewpoint);
    ratio.map(|_| ray)
}

/// What becomes of rays.
pub fn trace(job: &Job, rays: &[Ray]) -> Vec<RayEnd> {
    let mut ends = vec![RayEnd::NONE; rays.len()];
    for (rays, ends) in rays.chunks(64).zip(ends.chunks_mut(64)) {
        job.scene.integrator.trace_all(&job.scene.world, rays, ends);
    }
    ends
}

/// Wavelengths in the middle of the film's range, as a path has them.
pub fn wavelengths(job: &Job) -> SampledWavelengths {
    let [lo, hi] = job.film.lambda_range();
    VisibleWavelengths::new(lo, hi).sample(0.5)
}

/// Whether the render has all of the frame.
pub fn is_whole(job: &Job) -> bool {
    let [width, height] = job.film.resolution();
    job.film.crop() == [0, width, 0, height]
}
