//! `path`: path tracing with light sampling along the geodesics that join a surface and a lamp.
//!
//! Directions follow the material (BSDF sampling); paths end by Russian roulette once they carry little. At every rough surface
//! also a point of a lamp is drawn, and all geodesics that the integrator finds to it are followed: in flat space one, around a
//! hole the direct one and the one that goes round the other side (and more, if the integrator is asked for them). Both techniques
//! are weighted by multiple importance sampling (balance heuristic; Veach and Guibas 1995). A point drawn with density p per
//! chart area is one drawn with density `p spread / |cos theta_y|` per chart solid angle, whatever way the light travels in between.
//!
//! What stands in the way of a geodesic costs most to find out, and the light that went round the hole is mostly faint, as is much of
//! what later bounces find: a geodesic that carries less than a share [`FAINT`] of what all to the same point carry, or of what the path
//! has found already, is looked along with a probability in proportion to what it carries, and counts the more. That changes no
//! mean.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `maxdepth` | integer | 5 | bounces | longest path |
//! | `rrdepth` | integer | 3 | bounces | first bounce at which a path may end by roulette |
//! | `lightsampling` | bool | true | | whether lamps are aimed at; if not, they are found by chance alone |
//!
//! ```bhs
//! LightTransport "path" "integer maxdepth" 8
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connection, Connections, MOST_TURNS, Ray};
use bhs_core::light_sampling::LightSample;
use bhs_core::params::Params;
use bhs_core::sampling::{SampleStream, balance_heuristic};
use bhs_core::scene::{Scene, Vertex};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::LightTransport;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "path", summary: "path tracing, with light sampling where the integrator can join two points", build };

struct Path {
    max_depth: u32,
    roulette_depth: u32,
    light_sampling: bool,
}

fn build(p: &Params) -> Option<Box<dyn LightTransport>> {
    let max_depth = p.get_in("maxdepth", 5, 0..=1_000_000, "bounces", "longest path") as u32;
    let roulette_depth =
        p.get_in("rrdepth", 3, 0..=1_000_000, "bounces", "first bounce at which a path may end by roulette") as u32;
    let light_sampling = p.get("lightsampling", true, "", "whether lamps are aimed at; if not, they are found by chance alone");
    Some(Box::new(Path { max_depth, roulette_depth, light_sampling }))
}

/// Share of other light below which the light of a geodesic is left to chance. Measured in a room with a hole: with 0.05 to 0.5 noise grows
/// by 2 %, time shrinks by 7 %.
const FAINT: f32 = 0.5;

/// How the ray under way was chosen: what a lamp that it finds is weighted against.
struct Chosen {
    /// Where it left: the point of the surface itself.
    from: DVec3,
    /// Density of its direction per local solid angle.
    pdf: f32,
    /// Local over chart solid angle where it left.
    solid_angle_factor: f64,
}

impl Chosen {
    /// The weight of this technique for the emission that `ray` has found at `vertex` after sweeping `phi`.
    fn weight(&self, scene: &Scene, connections: &dyn Connections, ray: &Ray, vertex: &Vertex, phi: f64) -> f32 {
        let Some(spread) = connections.spread(&scene.world, self.from, ray.direction, vertex.hit.point, phi) else { return 1.0 };
        let per_area = spread / vertex.hit.direction.dot(vertex.normal).abs();
        balance_heuristic(self.pdf, (scene.light_pdf(vertex) * per_area / self.solid_angle_factor) as f32)
    }

    /// The light of the sky that `ray` has found in the direction `direction` after sweeping `phi`, weighted likewise.
    fn sky(
        &self,
        scene: &Scene,
        connections: &dyn Connections,
        ray: &Ray,
        direction: DVec3,
        phi: f64,
        lambda: &SampledWavelengths,
    ) -> SampledSpectrum {
        scene.sky_weighted(direction, lambda, |pdf| {
            match connections.spread_sky(&scene.world, self.from, ray.direction, direction, phi) {
                Some(spread) => balance_heuristic(self.pdf, (pdf * spread / self.solid_angle_factor) as f32),
                None => 1.0,
            }
        })
    }
}

impl LightTransport for Path {
    fn radiance(
        &self,
        scene: &Scene,
        mut ray: Ray,
        lambda: &SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum {
        let aims = self.light_sampling && scene.light_choice.total() > 0.0;
        let connections = scene.integrator.connections().filter(|_| aims);
        let mut radiance = SampledSpectrum::ZERO;
        let mut throughput = SampledSpectrum::ONE;
        // Those that the path still has.
        let mut lambda = *lambda;
        // `None` after the camera and after specular bounces: nothing but chance finds lamps there.
        let mut chosen: Option<Chosen> = None;
        for depth in 0..=self.max_depth {
            let hit = match scene.integrator.trace(&scene.world, &ray, log) {
                Arrival::Surface(hit) => hit,
                Arrival::Sky(direction) => {
                    let sky = match (connections, &chosen) {
                        (Some(c), Some(chosen)) => chosen.sky(scene, c, &ray, direction, log.phi, &lambda),
                        _ => scene.sky(direction, &lambda),
                    };
                    radiance += throughput * sky;
                    break;
                }
                Arrival::Hole | Arrival::OutOfSteps => break,
            };
            let Some(vertex) = scene.vertex(hit, &lambda) else {
                log.counters.inside_horizon += 1;
                break;
            };

            // ---- Emission found by the ray
            if vertex.emitter.is_some() {
                let weight = match (connections, &chosen) {
                    (Some(c), Some(chosen)) => chosen.weight(scene, c, &ray, &vertex, log.phi),
                    _ => 1.0,
                };
                radiance += throughput * vertex.emitted() * weight;
            }
            if depth == self.max_depth {
                break;
            }

            // ---- Emission found by sampling a lamp
            if let Some(c) = connections
                && !vertex.material.is_specular()
            {
                let (choice, u) = (stream.next_1d(), stream.next_2d());
                if let Some(light) = scene.sample_light(choice, u) {
                    let sought = Sought { scene, connections: c, vertex: &vertex, light: &light, lambda: &lambda };
                    // Along straight lines it costs so little to look that leaving light to chance only adds noise.
                    radiance += throughput
                        * match (scene.bends(), c.turns()) {
                            (false, _) => sought.straight(log),
                            (true, 1) => sought.bent::<2>(radiance.max() / throughput.max(), stream.next_1d(), log),
                            (true, _) => {
                                sought.bent::<{ 2 * MOST_TURNS }>(radiance.max() / throughput.max(), stream.next_1d(), log)
                            }
                        };
                }
            }

            // ---- The next direction
            let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, stream.next_1d(), stream.next_2d()) else {
                break;
            };
            throughput *= sample.weight;
            if sample.drops_wavelengths {
                lambda.drop_secondary(&mut throughput);
            }
            if throughput.is_zero() || !vertex.is_consistent(sample.wi) {
                break;
            }
            let footprint = if sample.specular { ray.footprint } else { scene.footprints.rough };
            ray = vertex.spawn(&scene.world, sample.wi, footprint);
            chosen = (!sample.specular).then(|| Chosen {
                from: vertex.hit.point,
                pdf: sample.pdf,
                solid_angle_factor: vertex.observer.frame.solid_angle_factor(ray.direction),
            });

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

    fn samples_lights(&self) -> bool {
        self.light_sampling
    }
}

/// A point of a lamp whose light is looked for at a vertex.
struct Sought<'a> {
    scene: &'a Scene,
    connections: &'a dyn Connections,
    vertex: &'a Vertex<'a>,
    light: &'a LightSample,
    lambda: &'a SampledWavelengths,
}

impl Sought<'_> {
    /// What arrives along a straight line, scattered back along the path.
    fn straight(&self, log: &mut TraceLog) -> SampledSpectrum {
        let [connection, _] = self.scene.connect(self.connections, self.vertex.hit.point, self.light, 0);
        let Some(connection) = connection else { return SampledSpectrum::ZERO };
        log.counters.connections += 1;
        let carried = self.carried(&connection);
        if carried.is_zero() {
            log.counters.connections_dark += 1;
            return carried;
        }
        if self.is_visible(&connection, log) { carried } else { SampledSpectrum::ZERO }
    }

    /// What arrives along all of up to `N` geodesics, scattered back along the path. `found`: the light of the path so far, as it would have to
    /// leave the vertex. `spare` is a number in [0,1) that nothing else depends on.
    fn bent<const N: usize>(&self, found: f32, spare: f32, log: &mut TraceLog) -> SampledSpectrum {
        let mut images = [None; N];
        for (turn, images) in (0..self.connections.turns()).zip(images.chunks_exact_mut(2)) {
            let pair = self.scene.connect(self.connections, self.vertex.hit.point, self.light, turn);
            for (image, connection) in images.iter_mut().zip(pair) {
                *image = connection.map(|c| (c, self.carried(&c)));
            }
        }
        let images = images.iter().flatten();
        let all: f32 = images.clone().map(|(_, light)| light.max()).sum();
        let mut sum = SampledSpectrum::ZERO;
        for (connection, carried) in images {
            log.counters.connections += 1;
            let looked_at = (carried.max() / (FAINT * all.max(found))).min(1.0);
            // One number for all: each image by itself is looked at as often as it should be.
            if carried.is_zero() {
                log.counters.connections_dark += 1;
            } else if spare >= looked_at {
                log.counters.connections_faint += 1;
            } else if self.is_visible(connection, log) {
                sum += *carried * (1.0 / looked_at);
            }
        }
        sum
    }

    /// Whether nothing stands in the way of a geodesic.
    fn is_visible(&self, connection: &Connection, log: &mut TraceLog) -> bool {
        let Self { scene, vertex, .. } = self;
        log.counters.connections_searched += 1;
        let start = Ray { footprint: scene.footprints.rough, ..scene.world.spawn(&vertex.hit, vertex.normal, connection.launch) };
        let queries = log.counters.queries;
        let visible = scene.visible(self.connections, &start, vertex.hit.point, self.light, connection, log);
        log.counters.connection_queries += log.counters.queries - queries;
        log.counters.connections_blocked += u64::from(!visible);
        visible
    }

    /// What the light sample sends back along the path by a geodesic, weighted against BSDF sampling, if nothing stands in its way.
    fn carried(&self, connection: &Connection) -> SampledSpectrum {
        let vertex = self.vertex;
        let wi = vertex.shading_direction(connection.launch);
        let scattered = vertex.material.evaluate(&vertex.shading, vertex.wo, wi);
        if scattered.is_zero() || !vertex.is_consistent(wi) {
            return SampledSpectrum::ZERO;
        }
        let arriving = self.scene.arriving(self.light, connection, &vertex.observer, self.lambda);
        let density = arriving.density as f32;
        // Zero where light of a whole circle of directions meets in the point (a lamp exactly behind the hole): of a surface, the points
        // that are so have no area.
        if arriving.emitted.is_zero() || !(density > 0.0 && density.is_finite()) {
            return SampledSpectrum::ZERO;
        }
        let against = if arriving.is_point { 0.0 } else { vertex.material.pdf(&vertex.shading, vertex.wo, wi) };
        scattered * arriving.emitted * (1.0 / (density + against))
    }
}
