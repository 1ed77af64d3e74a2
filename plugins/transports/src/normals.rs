//! `normals`: shading normals as colours, (n + 1)/2 in world space. To look at geometry, and the light transport to copy.
//!
//! It takes no parameters.
//!
//! ```bhs
//! LightTransport "normals"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Ray, Traced};
use bhs_core::path_log::PathEvent;
use bhs_core::sampling::SampleStream;
use bhs_core::scene::Scene;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::LightTransport;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "normals", summary: "shading normals as colours", build: |_| Some(Box::new(Normals)) };

struct Normals;

impl LightTransport for Normals {
    fn radiance(
        &self,
        scene: &Scene,
        ray: Ray,
        lambda: &SampledWavelengths,
        _: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum {
        // Black where the ray meets nothing.
        let arrival = scene.integrator.trace(&scene.world, &ray, log);
        let end = Traced { arrival, phi: log.phi };
        log.note(|| PathEvent::Traced { ray, end, throughput: SampledSpectrum::ONE, lambda_nm: lambda.lambda_nm });
        let Arrival::Surface(hit) = arrival else { return SampledSpectrum::ZERO };
        let normal = scene.world.surface(&hit).shading_normal;
        let colour = 0.5 * (normal + DVec3::ONE);
        // The light that a film shows as this colour.
        bhs_spectra::rgb_emission(colour.as_vec3().to_array(), lambda.lambda_nm)
    }
}
