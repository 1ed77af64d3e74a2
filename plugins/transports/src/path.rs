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
//! Paths are followed together, bounce by bounce: first all their rays, then, at the surfaces, all the geodesics to lamps; for integrators
//! that follow several at once.
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

use crate::aimed::{Aimed, Sought};
use arrayvec::ArrayVec;
use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, MOST_TURNS, Ray, Traced};
use bhs_core::params::Params;
use bhs_core::sampling::{SampleStream, balance_heuristic};
use bhs_core::scene::{Scene, Vertex};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::{BATCH, LightTransport, PathSample};
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

/// A path under way.
struct State {
    /// Where it goes next.
    ray: Ray,
    /// Weight of what it finds there.
    throughput: SampledSpectrum,
    /// The wavelengths that it still has.
    lambda: SampledWavelengths,
    /// `None` after the camera and after specular bounces: nothing but chance finds lamps there.
    chosen: Option<Chosen>,
}

impl State {
    fn new(path: &PathSample) -> Self {
        Self { ray: path.ray, throughput: SampledSpectrum::ONE, lambda: path.lambda, chosen: None }
    }
}

impl LightTransport for Path {
    fn radiance(
        &self,
        scene: &Scene,
        ray: Ray,
        lambda: &SampledWavelengths,
        stream: &mut SampleStream,
        log: &mut TraceLog,
    ) -> SampledSpectrum {
        let mut path = PathSample { ray, lambda: *lambda, stream: stream.clone(), radiance: SampledSpectrum::ZERO };
        self.follow(scene, std::slice::from_mut(&mut path), log);
        *stream = path.stream;
        path.radiance
    }

    fn radiance_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut TraceLog) {
        for paths in paths.chunks_mut(BATCH) {
            self.follow(scene, paths, log);
        }
    }

    fn samples_lights(&self) -> bool {
        self.light_sampling
    }
}

impl Path {
    /// Follows up to [`BATCH`] paths to their ends.
    fn follow(&self, scene: &Scene, paths: &mut [PathSample], log: &mut TraceLog) {
        let aims = self.light_sampling && scene.light_choice.total() > 0.0;
        let connections = scene.integrator.connections().filter(|_| aims);
        let mut states: ArrayVec<State, BATCH> = paths.iter().map(State::new).collect();
        let mut aimed = Aimed::default();
        for path in &mut *paths {
            path.radiance = SampledSpectrum::ZERO;
        }
        // The paths that go on.
        let mut underway: ArrayVec<usize, BATCH> = (0..paths.len()).collect();
        for depth in 0..=self.max_depth {
            let rays: ArrayVec<Ray, BATCH> = underway.iter().map(|i| states[*i].ray).collect();
            let mut traced = [Traced { arrival: Arrival::Hole, phi: 0.0 }; BATCH];
            scene.integrator.trace_all(&scene.world, &rays, &mut traced[..rays.len()], log);
            let mut ends = traced.iter();
            underway.retain(|i| {
                let Some(end) = ends.next() else { return false };
                let mut bounce =
                    Bounce { scene, connections, index: *i, path: &mut paths[*i], state: &mut states[*i], aimed: &mut aimed };
                self.bounce(depth, end, &mut bounce, log)
            });
            if let Some(connections) = connections {
                aimed.look(scene, connections, paths, log);
            }
            if underway.is_empty() {
                break;
            }
        }
    }

    /// What happens where a path has arrived at the end of its ray number `depth`; whether it goes on from there.
    fn bounce(&self, depth: u32, end: &Traced, at: &mut Bounce, log: &mut TraceLog) -> bool {
        let connections = at.connections;
        let Bounce { scene, path, state, .. } = at;
        let hit = match end.arrival {
            Arrival::Surface(hit) => hit,
            Arrival::Sky(direction) => {
                let sky = match (connections, &state.chosen) {
                    (Some(c), Some(chosen)) => chosen.sky(scene, c, &state.ray, direction, end.phi, &state.lambda),
                    _ => scene.sky(direction, &state.lambda),
                };
                path.radiance += state.throughput * sky;
                return false;
            }
            Arrival::Hole | Arrival::OutOfSteps => return false,
        };
        let Some(vertex) = scene.vertex(hit, &state.lambda) else {
            log.counters.inside_horizon += 1;
            return false;
        };

        // ---- Emission found by the ray
        if vertex.emitter.is_some() {
            let weight = match (connections, &state.chosen) {
                (Some(c), Some(chosen)) => chosen.weight(scene, c, &state.ray, &vertex, end.phi),
                _ => 1.0,
            };
            path.radiance += state.throughput * vertex.emitted() * weight;
        }
        if depth == self.max_depth {
            return false;
        }

        // ---- Emission found by sampling a lamp
        if connections.is_some() && !vertex.material.is_specular() {
            at.aim(&vertex, log);
        }

        // ---- The next direction
        let Bounce { scene, path, state, .. } = at;
        let stream = &mut path.stream;
        let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, stream.next_1d(), stream.next_2d()) else {
            return false;
        };
        state.throughput *= sample.weight;
        if sample.drops_wavelengths {
            state.lambda.drop_secondary(&mut state.throughput);
        }
        if state.throughput.is_zero() || !vertex.is_consistent(sample.wi) {
            return false;
        }
        let footprint = if sample.specular { state.ray.footprint } else { scene.footprints.rough };
        state.ray = vertex.spawn(&scene.world, sample.wi, footprint);
        state.chosen = (!sample.specular).then(|| Chosen {
            from: vertex.hit.point,
            pdf: sample.pdf,
            solid_angle_factor: vertex.observer.frame.solid_angle_factor(state.ray.direction),
        });

        // ---- Russian roulette
        if depth >= self.roulette_depth {
            let survive = state.throughput.max().min(0.95);
            if stream.next_1d() >= survive {
                return false;
            }
            state.throughput *= 1.0 / survive;
        }
        true
    }
}

/// A path where it has arrived.
struct Bounce<'a, 'p> {
    scene: &'a Scene,
    connections: Option<&'a dyn Connections>,
    /// Number of the path among those that are followed together.
    index: usize,
    path: &'a mut PathSample<'p>,
    state: &'a mut State,
    aimed: &'a mut Aimed,
}

impl Bounce<'_, '_> {
    /// Draws a point of a lamp and notes what may arrive from there at `vertex`.
    fn aim(&mut self, vertex: &Vertex, log: &mut TraceLog) {
        let Self { scene, connections: Some(connections), index, path, state, aimed } = self else { return };
        let stream = &mut path.stream;
        let (choice, u) = (stream.next_1d(), stream.next_2d());
        let Some(light) = scene.sample_light(choice, u) else { return };
        let State { throughput, lambda, .. } = &**state;
        let sought =
            Sought { scene, connections: *connections, vertex, light: &light, lambda, throughput: *throughput, path: *index };
        let found = path.radiance.max() / throughput.max();
        // Along straight lines it costs so little to look that leaving light to chance only adds noise.
        match (scene.bends(), connections.turns()) {
            (false, _) => sought.straight(aimed, log),
            (true, 1) => sought.bent::<2>(found, stream.next_1d(), aimed, log),
            (true, _) => sought.bent::<{ 2 * MOST_TURNS }>(found, stream.next_1d(), aimed, log),
        }
    }
}
