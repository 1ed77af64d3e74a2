//! `hemisphere`: the paper's light transport, and the oracle of every cleverer one.
//!
//! At every bounce a direction is drawn uniformly from the hemisphere above the surface; lamps are found by running into them.
//! Mirrors, glass and varnish, which scatter not only into that hemisphere, choose their own direction. Works under any integrator.
//! Source: Aikawa, Zhou and Wang 2019, section 3.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `maxdepth` | integer | 5 | bounces | longest path |
//!
//! ```bhs
//! LightTransport "hemisphere" "integer maxdepth" 5
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Ray};
use bhs_core::params::Params;
use bhs_core::sampling::{SampleStream, uniform_hemisphere};
use bhs_core::scene::Scene;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::LightTransport;
use std::f32::consts::TAU;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "hemisphere", summary: "uniform hemisphere sampling at every bounce, lamps found by chance", build };

struct Hemisphere {
    max_depth: u32,
}

fn build(p: &Params) -> Option<Box<dyn LightTransport>> {
    let max_depth = p.get_in("maxdepth", 5, 0..=1_000_000, "bounces", "longest path") as u32;
    Some(Box::new(Hemisphere { max_depth }))
}

impl LightTransport for Hemisphere {
    fn radiance(
        &self,
        scene: &Scene,
        mut ray: Ray,
        lambda: &SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum {
        let mut radiance = SampledSpectrum::ZERO;
        let mut throughput = SampledSpectrum::ONE;
        // Those that the path still has.
        let mut lambda = *lambda;
        for depth in 0..=self.max_depth {
            let hit = match scene.integrator.trace(&scene.world, &ray, log) {
                Arrival::Surface(hit) => hit,
                Arrival::Sky(direction) => {
                    radiance += throughput * scene.sky(direction, &lambda);
                    break;
                }
                Arrival::Hole | Arrival::OutOfSteps => break,
            };
            let Some(vertex) = scene.vertex(hit, &lambda) else {
                log.counters.inside_horizon += 1;
                break;
            };
            radiance += throughput * vertex.emitted();
            if depth == self.max_depth {
                break;
            }
            let (choice, u) = (stream.next_1d(), stream.next_2d());
            let mut specular = false;
            let wi = if vertex.material.chooses_directions() {
                let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, choice, u) else { break };
                throughput *= sample.weight;
                if sample.drops_wavelengths {
                    lambda.drop_secondary(&mut throughput);
                }
                specular = sample.specular;
                sample.wi
            } else {
                let up = uniform_hemisphere(u);
                let wi = if vertex.wo.z < 0.0 { -up } else { up };
                throughput *= vertex.material.evaluate(&vertex.shading, vertex.wo, wi) * TAU;
                wi
            };
            if throughput.is_zero() || !vertex.is_consistent(wi) {
                break;
            }
            let footprint = if specular { ray.footprint } else { scene.footprints.rough };
            ray = vertex.spawn(&scene.world, wi, footprint);
        }
        radiance
    }
}
