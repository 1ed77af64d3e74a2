//! A scene's own rays, and how far from the truth an integrator follows them.

use crate::film::tile_side;
use crate::lang::BuiltScene;
use crate::render::Job;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::sampling::{SampleStream, cosine_hemisphere};
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::integrator::Integrator;
use bhs_engine::stats::Counters;
use bhs_engine::transport::BATCH;
use bhs_engine::world::World;
use bhs_integrators::Exact;
use bhs_integrators::Tolerance;
use glam::DVec2;

/// Tolerance of the truth, relative to the scene's diagonal.
const TRUTH: f64 = 1e-7;

/// A hit this far from the true one, relative to the scene's diagonal, is somewhere else.
const ELSEWHERE: f64 = 1e-2;

/// More steps than any ray takes.
pub const MOST_STEPS: u64 = 1_000_000;

/// The scene's diagonal (scene units).
pub fn diagonal(world: &World) -> f64 {
    (world.bounds.max - world.bounds.min).length()
}

/// The truth: closed orbits, very short chords, exact facets.
pub fn truth(world: &World) -> Exact {
    Exact::new(Tolerance::Absolute(TRUTH * diagonal(world)), MOST_STEPS)
}

/// `count` camera rays through random places of the picture, in the order in which a render follows such: tile by tile, row by row.
pub fn camera_rays(built: &BuiltScene, count: usize) -> Vec<Ray> {
    let [width, height] = built.film.resolution().map(f64::from);
    let (job, side) = (Job::of(built), tile_side(built.film.resolution()));
    let ray = |i: usize| {
        let mut stream = SampleStream::new(&*built.sampler, [0, 0], i as u32);
        let at = stream.next_2d().as_dvec2() * DVec2::new(width, height);
        let [x, y] = at.to_array().map(|c| c as u32);
        let place = (y / side, x / side, y, x);
        (place, job.camera_ray(at, stream.next_2d()).0)
    };
    let mut rays: Vec<_> = (0..count).map(ray).collect();
    rays.sort_by_key(|(place, _)| *place);
    rays.into_iter().map(|(_, ray)| ray).collect()
}

/// The rays that leave the surfaces which `from` arrive at, as light leaves a white wall.
pub fn bounce_rays(built: &BuiltScene, from: &[Ray]) -> Vec<Ray> {
    let (scene, integrator) = (&built.scene, truth(&built.scene.world));
    let lambda = SampledWavelengths::visible(0.5, 360.0, 830.0);
    let bounce = |(i, ray): (usize, &Ray)| {
        let Arrival::Surface(hit) = integrator.trace(&scene.world, ray).arrival else { return None };
        let vertex = scene.vertex(hit, &lambda)?;
        let mut stream = SampleStream::new(&*built.sampler, [1, 0], i as u32);
        let wi = cosine_hemisphere(stream.next_2d());
        let wi = if vertex.wo.z < 0.0 { -wi } else { wi };
        vertex.is_consistent(wi).then(|| vertex.spawn(&scene.world, wi, scene.footprints.rough))
    };
    from.iter().enumerate().filter_map(bounce).collect()
}

/// Where rays arrive under `integrator`, and what that took to find out. They are followed in batches, as light transport does.
pub fn arrivals(world: &World, integrator: &dyn Integrator, rays: &[Ray]) -> (Vec<Arrival>, Counters) {
    let mut ends = vec![RayEnd::NONE; rays.len()];
    for (rays, ends) in rays.chunks(BATCH).zip(ends.chunks_mut(BATCH)) {
        integrator.trace_all(world, rays, ends);
    }
    let mut counters = Counters::default();
    ends.iter().for_each(|end| counters.add_ray(end));
    (ends.into_iter().map(|end| end.arrival).collect(), counters)
}

/// What is left of many errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Half of them are smaller.
    pub median: f64,
    /// 99 % of them are smaller.
    pub p99: f64,
    /// The largest.
    pub worst: f64,
}

impl Summary {
    /// Of these errors; NaN if there are none.
    pub fn of(mut errors: Vec<f64>) -> Self {
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors.get(((errors.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(f64::NAN);
        Self { median: at(0.5), p99: at(0.99), worst: at(1.0) }
    }

    /// As three cells of a table.
    pub fn cells(&self) -> [String; 3] {
        [self.median, self.p99, self.worst].map(|e| format!("{e:.1e}"))
    }
}

/// How arrivals differ from the true ones. Distances are relative to the scene's diagonal.
#[derive(Clone, Copy, Debug)]
pub struct Differences {
    /// Distance from the true hit, of rays that hit the same triangle.
    pub distance: Summary,
    /// The largest distance between the found hit and the true ray there, of the same rays: what tolerances are about.
    pub worst_across: f64,
    /// Share of all rays that hit another triangle, or end otherwise.
    pub other_triangle: f64,
    /// Share of all rays that end far from the truth, or otherwise.
    pub elsewhere: f64,
}

/// Compares where rays arrived with where they should have.
pub fn differences(world: &World, found: &[Arrival], truth: &[Arrival]) -> Differences {
    let diagonal = diagonal(world);
    let (mut same, mut worst_across, mut other, mut elsewhere) = (Vec::new(), 0.0f64, 0, 0);
    for (t, f) in truth.iter().zip(found) {
        match (t, f) {
            (Arrival::Surface(t), Arrival::Surface(f)) => {
                let distance = (t.point - f.point).length() / diagonal;
                if (t.geometry, t.primitive) == (f.geometry, f.primitive) {
                    same.push(distance);
                    worst_across = worst_across.max((t.point - f.point).cross(t.direction).length() / diagonal);
                } else {
                    other += 1;
                    elsewhere += u32::from(distance > ELSEWHERE);
                }
            }
            (Arrival::Sky(..), Arrival::Sky(..)) | (Arrival::Captured, Arrival::Captured) => {}
            _ => {
                other += 1;
                elsewhere += 1;
            }
        }
    }
    let n = truth.len().max(1) as f64;
    Differences {
        distance: Summary::of(same),
        worst_across,
        other_triangle: f64::from(other) / n,
        elsewhere: f64::from(elsewhere) / n,
    }
}
