//! `path`: path tracing with light sampling wherever the integrator can join two points.
//!
//! Directions follow the material (BSDF sampling); paths end by Russian roulette once they carry little. Where the integrator
//! offers connections, every rough surface also samples a point of a lamp, and both techniques are weighted by multiple
//! importance sampling (balance heuristic; Veach and Guibas 1995). A point drawn with density p per chart area is one drawn
//! with density `p spread / |cos theta_y|` per chart solid angle, whatever way the light travels in between.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `maxdepth` | integer | 5 | bounces | longest path |
//! | `rrdepth` | integer | 3 | bounces | first bounce at which a path may end by roulette |
//!
//! ```bhs
//! LightTransport "path" "integer maxdepth" 8
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, Ray};
use bhs_core::params::Params;
use bhs_core::sampling::{SampleStream, balance_heuristic};
use bhs_core::scene::{Scene, Vertex, radiance_shift};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::LightTransport;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "path", summary: "path tracing, with light sampling where the integrator can join two points", build };

struct Path {
    max_depth: u32,
    roulette_depth: u32,
}

fn build(p: &Params) -> Option<Box<dyn LightTransport>> {
    let max_depth = p.get_in("maxdepth", 5, 0..=1_000_000, "bounces", "longest path") as u32;
    let roulette_depth =
        p.get_in("rrdepth", 3, 0..=1_000_000, "bounces", "first bounce at which a path may end by roulette") as u32;
    Some(Box::new(Path { max_depth, roulette_depth }))
}

/// How the ray under way was chosen: what a lamp that it finds is weighted against.
struct Chosen {
    /// Density of its direction per local solid angle.
    pdf: f32,
    /// Local over chart solid angle where it left.
    solid_angle_factor: f64,
}

impl LightTransport for Path {
    fn radiance(
        &self,
        scene: &Scene,
        mut ray: Ray,
        lambda: &mut SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum {
        let connections = scene.integrator.connections().filter(|_| !scene.emitters.is_empty());
        let mut radiance = SampledSpectrum::ZERO;
        let mut throughput = SampledSpectrum::ONE;
        // `None` after the camera and after specular bounces: nothing but chance finds lamps there.
        let mut chosen: Option<Chosen> = None;
        for depth in 0..=self.max_depth {
            let hit = match scene.integrator.trace(&scene.world, &ray, log) {
                Arrival::Surface(hit) => hit,
                Arrival::Sky(direction) => {
                    radiance += throughput * scene.sky(direction, lambda);
                    break;
                }
                Arrival::Hole | Arrival::OutOfSteps => break,
            };
            let Some(vertex) = scene.vertex(hit, lambda) else { break };

            // ---- Emission found by the ray
            if vertex.emitter.is_some() {
                let weight = match (connections, &chosen) {
                    (Some(c), Some(chosen)) => {
                        let spread = c.spread(&scene.world, &ray, &hit) / hit.direction.dot(vertex.normal).abs();
                        let light = scene.light_pdf(&vertex) * spread / chosen.solid_angle_factor;
                        balance_heuristic(chosen.pdf, light as f32)
                    }
                    _ => 1.0,
                };
                radiance += throughput * vertex.emitted() * weight;
            }
            if depth == self.max_depth {
                break;
            }

            // ---- Emission found by sampling a lamp
            let specular = vertex.material.is_specular();
            if let Some(c) = connections
                && !specular
            {
                radiance += throughput * sample_light(scene, c, &vertex, lambda, stream, log);
            }

            // ---- The next direction
            let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, stream.next_1d(), stream.next_2d()) else {
                break;
            };
            throughput *= sample.weight;
            if throughput.is_zero() || !vertex.is_consistent(sample.wi) {
                break;
            }
            ray = vertex.spawn(&scene.world, sample.wi);
            chosen = (!sample.specular)
                .then(|| Chosen { pdf: sample.pdf, solid_angle_factor: vertex.observer.frame.solid_angle_factor(ray.direction) });

            // ---- Russian roulette
            if depth >= self.roulette_depth {
                let survive = throughput.max().min(0.95);
                if stream.next_1d() >= survive {
                    break;
                }
                throughput *= 1.0 / survive;
            }
        }
        radiance
    }
}

/// The light of one point of one lamp that arrives at `vertex` and is scattered back along the path, per image of the lamp.
fn sample_light(
    scene: &Scene,
    connections: &dyn Connections,
    vertex: &Vertex,
    lambda: &SampledWavelengths,
    stream: &mut SampleStream,
    log: &mut TraceLog,
) -> SampledSpectrum {
    let mut sum = SampledSpectrum::ZERO;
    let Some(light) = scene.sample_light(stream.next_1d(), stream.next_2d()) else { return sum };
    let Some(observer) = scene.integrator.observer(&scene.world, light.point) else { return sum };
    let local_normal = observer.frame.local_normal(light.normal);
    for image in 0..connections.images() {
        log.counters.connections += 1;
        let Some(c) = connections.connect(&scene.world, vertex.hit.point, light.point, image) else { continue };
        let wi = vertex.shading_direction(c.launch);
        let scattered = vertex.material.evaluate(&vertex.shading, vertex.wo, wi);
        if scattered.is_zero() || !vertex.is_consistent(wi) {
            continue;
        }
        let shift = scene.shift(&observer);
        let cos_emitter = local_normal.dot(-observer.frame.local_direction(c.arrival)) as f32;
        let emitter = &scene.emitters[light.emitter as usize];
        let emitted = emitter.light.radiance(light.uv, cos_emitter, lambda.at(shift as f32)) * radiance_shift(shift);
        let cos_chart = c.arrival.dot(light.normal).abs();
        if emitted.is_zero() || cos_chart == 0.0 {
            continue;
        }
        let factor = vertex.observer.frame.solid_angle_factor(c.launch);
        let pdf_light = (light.pdf * c.spread / (cos_chart * factor)) as f32;
        let weight = balance_heuristic(pdf_light, vertex.material.pdf(&vertex.shading, vertex.wo, wi));
        let start = scene.world.spawn(&vertex.hit, vertex.normal, c.launch);
        if pdf_light > 0.0 && connections.visible(&scene.world, &start, light.point, &c, log) {
            sum += scattered * emitted * (weight / pdf_light);
        }
    }
    sum
}
