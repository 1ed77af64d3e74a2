//! `hemisphere`: the paper's light transport, and the oracle of every cleverer one.
//!
//! At every bounce a direction is drawn uniformly from the hemisphere above the surface; only directions that run into a light find it.
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
use bhs_core::params::Params;
use bhs_core::ray::Arrival;
use bhs_core::sampling::uniform_hemisphere;
use bhs_core::spectrum::SampledSpectrum;
use bhs_engine::path_log::PathEvent;
use bhs_engine::scene::{Scene, Travelled};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{Behind, LightTransport, PathSample};
use std::f32::consts::TAU;

/// Density of a direction over a hemisphere (1/sr).
const FRAC_1_TAU: f32 = 1.0 / TAU;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "hemisphere", summary: "uniform hemisphere sampling at every bounce, no light sampling", build };

struct Hemisphere {
    max_depth: u32,
}

fn build(p: &Params) -> Option<Box<dyn LightTransport>> {
    let max_depth = p.get_in("maxdepth", 5, 0..=1_000_000, "bounces", "longest path") as u32;
    Some(Box::new(Hemisphere { max_depth }))
}

impl LightTransport for Hemisphere {
    fn follow(&self, scene: &Scene, path: &mut PathSample, log: &mut PathLog) {
        let stream = &mut path.stream;
        let mut ray = path.ray;
        let mut radiance = SampledSpectrum::ZERO;
        let mut throughput = SampledSpectrum::ONE;
        // Those that the path still has.
        let mut lambda = path.lambda;
        let mut travelled = Travelled::default();
        path.behind = None;
        let mut shows_others = true;
        for depth in 0..=self.max_depth {
            let end = scene.integrator.trace(&scene.world, &ray);
            log.counters.add_ray(&end);
            if depth == 0 {
                path.first = end;
            } else if shows_others {
                path.behind = Some(Behind { ray, end, share: throughput.mean() });
            }
            log.note(|| PathEvent::Traced { ray, end, throughput, lambda_nm: lambda.lambda_nm });
            let hit = match end.arrival {
                Arrival::Surface(hit) => hit,
                Arrival::Sky(direction, side) => {
                    let found = throughput * scene.sky((direction, side), &lambda, depth == 0);
                    log.note(|| PathEvent::Found(found));
                    radiance += found;
                    break;
                }
                Arrival::Captured | Arrival::OutOfSteps => break,
            };
            let Some(mut vertex) = scene.vertex(hit, &lambda) else {
                log.counters.no_static_observer += 1;
                break;
            };
            scene.date(&mut vertex, &ray, &mut travelled);
            let found = throughput * vertex.emitted();
            if vertex.emitter.is_some() {
                log.note(|| PathEvent::Found(found));
            }
            radiance += found;
            if depth == self.max_depth {
                break;
            }
            let (choice, u) = (stream.next_1d(), stream.next_2d());
            let (mut specular, mut pdf) = (false, FRAC_1_TAU);
            let weight;
            let wi = if vertex.material.chooses_directions() {
                let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, choice, u) else {
                    log.note(|| PathEvent::Ended("the surface gives it no direction"));
                    break;
                };
                throughput *= sample.weight;
                weight = sample.weight;
                pdf = sample.pdf;
                if sample.drops_wavelengths {
                    lambda.drop_secondary(&mut throughput);
                }
                specular = sample.specular;
                sample.wi
            } else {
                let up = uniform_hemisphere(u);
                let wi = if vertex.wo.z < 0.0 { -up } else { up };
                weight = vertex.material.evaluate(&vertex.shading, vertex.wo, wi) * TAU;
                throughput *= weight;
                wi
            };
            let direction = vertex.chart_direction(wi);
            log.note(|| PathEvent::Scattered { direction, weight, pdf, specular });
            if throughput.is_zero() || !vertex.is_consistent(wi) {
                log.note(|| PathEvent::Ended("nothing is left of it"));
                break;
            }
            if let Some(shift) = vertex.shift(direction) {
                lambda = lambda.shifted(shift);
                throughput *= scene.radiance_factor(shift);
            }
            shows_others &= vertex.shows_others();
            let footprint = if specular { ray.footprint } else { scene.footprints.rough };
            ray = vertex.spawn(&scene.world, wi, footprint);
        }
        path.radiance = radiance;
    }
}
