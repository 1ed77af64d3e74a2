//! What a picture sees: rough places that its paths come to, so that photons are sent where they count.

use arrayvec::ArrayVec;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::transport::{BATCH, RenderSetting};
use glam::{DVec3, IVec3, Vec2};
use rayon::prelude::*;
use std::collections::HashMap;

/// Paths that are followed.
const PATHS: u32 = 4096;
/// Bounces of each.
const BOUNCES: u32 = 4;
/// Cells along the diagonal of what is seen.
const CELLS: f64 = 48.0;
/// What no path has come to counts for this share of what one has come to: paths are few.
const UNSEEN: f64 = 0.02;
/// The stage whose random numbers these are: no wave has it, nor have scouts.
const STAGE: u32 = u32::MAX - 16;

/// Rough places by how often paths come there.
pub struct Seen {
    cell: f64,
    counts: HashMap<IVec3, u32>,
}

impl Seen {
    /// What the camera of a render sees, itself and by way of others.
    pub fn new(setting: &RenderSetting) -> Self {
        let batches = PATHS / BATCH as u32;
        let points: Vec<Vec<DVec3>> = (0..batches).into_par_iter().map(|b| follow(setting, b)).collect();
        let points = points.concat();
        // Without the few that are far away: a box within which nine tenths are along each axis.
        let extent = |axis: usize| {
            let mut along: Vec<f64> = points.iter().map(|p| p[axis]).collect();
            along.sort_by(f64::total_cmp);
            let at = |share: f64| along.get((share * along.len() as f64) as usize).copied().unwrap_or(0.0);
            at(0.95) - at(0.05)
        };
        let diagonal = DVec3::new(extent(0), extent(1), extent(2)).length();
        let cell = if diagonal > 0.0 { diagonal / CELLS } else { 1.0 };
        let mut seen = Self { cell, counts: HashMap::new() };
        for p in points {
            *seen.counts.entry(seen.cell_of(p)).or_default() += 1;
        }
        seen
    }

    fn cell_of(&self, point: DVec3) -> IVec3 {
        (point / self.cell).floor().as_ivec3()
    }

    /// How much light counts that arrives at `point`.
    pub fn weight(&self, point: DVec3) -> f64 {
        self.counts.get(&self.cell_of(point)).map_or(UNSEEN, |n| f64::from(*n))
    }

    /// The least and the greatest radius of a disc in a picture of so many pixels (scene units): what is smaller than a pixel is not seen but for its noise, and
    /// what is larger than a cell blurs all.
    pub fn radii(&self, pixels: u64) -> [f64; 2] {
        let pixel = self.cell * CELLS / (pixels as f64).sqrt();
        [pixel.min(0.25 * self.cell), self.cell]
    }
}

/// The rough places that the paths of one batch come to.
fn follow(setting: &RenderSetting, batch: u32) -> Vec<DVec3> {
    let RenderSetting { scene, sampler, lambda_range: [lo, hi], camera_ray, .. } = setting;
    let lambda = SampledWavelengths::visible(0.5, *lo, *hi);
    let mut points = Vec::new();
    let mut paths: ArrayVec<(Ray, SampleStream), BATCH> = (0..BATCH as u32)
        .map(|i| {
            let mut stream = SampleStream::new(*sampler, [u32::MAX, STAGE], batch * BATCH as u32 + i);
            let (film, lens) = (stream.next_2d(), stream.next_2d());
            (camera_ray(film, lens), stream)
        })
        .collect();
    let mut ends = [RayEnd::NONE; BATCH];
    for _ in 0..=BOUNCES {
        let rays: ArrayVec<Ray, BATCH> = paths.iter().map(|p| p.0).collect();
        scene.integrator.trace_all(&scene.world, &rays, &mut ends[..rays.len()]);
        let mut on: ArrayVec<(Ray, SampleStream), BATCH> = ArrayVec::new();
        for ((_, mut stream), end) in paths.into_iter().zip(&ends) {
            let Arrival::Surface(hit) = end.arrival else { continue };
            let Some(vertex) = scene.vertex(hit, &lambda) else { continue };
            if !vertex.material.is_specular() {
                points.push(hit.point);
            }
            let (choice, u): (f32, Vec2) = (stream.next_1d(), stream.next_2d());
            let sample = vertex.material.sample(&vertex.shading, vertex.wo, choice, u);
            if let Some(sample) = sample.filter(|s| vertex.is_consistent(s.wi)) {
                on.push((vertex.spawn(&scene.world, sample.wi, scene.footprints.rough), stream));
            }
        }
        paths = on;
    }
    points
}
