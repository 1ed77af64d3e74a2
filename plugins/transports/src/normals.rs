//! `normals`: shading normals as colours, (n + 1)/2 in world space. To look at geometry, and the light transport to copy.
//!
//! It takes no parameters.
//!
//! ```bhs
//! LightTransport "normals"
//! WorldBegin
//! ```

use arrayvec::ArrayVec;
use bhs_core::Plugin;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spectrum::SampledSpectrum;
use bhs_engine::path_log::PathEvent;
use bhs_engine::scene::Scene;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, LightTransport, PathSample};
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "normals", summary: "shading normals as colours", build: |_| Some(Box::new(Normals)) };

struct Normals;

impl LightTransport for Normals {
    fn shows_light(&self) -> bool {
        false
    }

    fn follow(&self, scene: &Scene, path: &mut PathSample, log: &mut PathLog) {
        self.follow_all(scene, std::slice::from_mut(path), log);
    }

    fn follow_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut PathLog) {
        for paths in paths.chunks_mut(BATCH) {
            let rays: ArrayVec<Ray, BATCH> = paths.iter().map(|path| path.ray).collect();
            let mut ends = [RayEnd::NONE; BATCH];
            scene.integrator.trace_all(&scene.world, &rays, &mut ends[..rays.len()]);
            for (path, end) in paths.iter_mut().zip(&ends) {
                show(scene, path, end, log);
            }
        }
    }
}

/// Writes what `path` finds whose ray has come to `end`: black where it meets nothing.
fn show(scene: &Scene, path: &mut PathSample, end: &RayEnd, log: &mut PathLog) {
    let (ray, throughput, lambda_nm) = (path.ray, SampledSpectrum::ONE, path.lambda.lambda_nm);
    log.counters.add_ray(end);
    log.note(|| PathEvent::Traced { ray, end: *end, throughput, lambda_nm });
    path.first = *end;
    path.radiance = match end.arrival {
        Arrival::Surface(hit) => {
            let normal = scene.shading_normal(&hit);
            let colour = 0.5 * (normal + DVec3::ONE);
            // The light that a film shows as this colour.
            bhs_spectra::rgb_emission(colour.as_vec3().to_array(), lambda_nm)
        }
        _ => SampledSpectrum::ZERO,
    };
}
