//! `path`: path tracing with light sampling (next-event estimation) along the geodesics that join a surface and a light.
//!
//! Directions follow the material (BSDF sampling); paths end by Russian roulette once they carry little. At every rough surface
//! also a point of a light is drawn, and shadow rays are traced along all geodesics that the integrator finds to it: in flat space one, around a
//! hole the direct one and the one that goes round the other side (and more, if the integrator is asked for them). Both techniques
//! are weighted by multiple importance sampling (balance heuristic; Veach and Guibas 1995). A point drawn with density p per
//! chart area is one drawn with density `p spread / |cos theta_y|` per chart solid angle, whatever way the light travels in between.
//!
//! Shadow rays cost most, and the light that went round the hole is mostly faint, as is much of what later bounces find: where a geodesic
//! carries less than a share `FAINT` of what all to the same point carry, or of what the path has found already, its shadow ray is traced with
//! a probability in proportion to what it carries, and counts the more (Russian roulette). That changes no mean. Where geodesics themselves are
//! dear, around a hole that spins, they are looked for likewise, by what those around the hole without spin would carry.
//!
//! With `guiding`, a render learns where light comes from while it goes on, and matt surfaces choose part of their directions by that
//! ([`Guide`]): where only light from elsewhere arrives, in shadows and on ceilings, noise falls most. No sample's mean depends on what
//! was learned, for those that follow have numbers of their own. Weights then say little about what a path is worth, for they
//! are small where much light is expected; roulette ends paths by what surfaces reflect.
//!
//! `clampindirect` limits what one path may bring of light that two or more rough surfaces have scattered, as renderers for films do: less noise, and
//! a picture that is too dark where such light is rare and strong (caustics). What is seen in mirrors and through glass, and light straight from a
//! lamp, is never clamped.
//!
//! Paths are followed together, bounce by bounce: all their rays, then all shadow rays; for integrators that follow several at once.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `maxdepth` | integer | 5 | bounces | longest path |
//! | `rrdepth` | integer | 3 | bounces | first bounce at which a path may end by roulette |
//! | `lightsampling` | bool | true | | whether lights are sampled too (next-event estimation), or directions by the material alone |
//! | `guiding` | bool | false | | whether directions follow what was learned of the light |
//! | `caustics` | bool | true | | whether light that comes over mirrors and through glass is looked for from the lights too ([`Caustics`]); where it is not said, if lights are sampled and there may be any |
//! | `clampindirect` | float | 0 | W m^-2 sr^-1 nm^-1 | most that one contribution of indirect light may be, in the mean over its wavelengths, at energy 1; 0: any (biased) |
//!
//! ```bhs
//! LightTransport "path" "integer maxdepth" 8
//! WorldBegin
//! ```

use crate::caustics::{Caustics, Departure};
use crate::guide::{Guide, GuidedHemisphere};
use crate::path_state::{Chosen, State, clamped};
use crate::shadow_rays::{BatchConnections, LightSampleAt, PendingShadowRays};
use arrayvec::ArrayVec;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spectrum::SampledSpectrum;
use bhs_engine::connections::Connections;
use bhs_engine::light_sampling::LightSample;
use bhs_engine::path_log::PathEvent;
use bhs_engine::scene::{Scene, Vertex};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, Behind, LightTransport, PathSample, RenderSetting};
use std::ops::Range;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn LightTransport> =
    Plugin { name: "path", summary: "path tracing, with light sampling where the integrator can join two points", build };

struct Path {
    max_depth: u32,
    roulette_depth: u32,
    light_sampling: bool,
    guiding: bool,
    /// Whether light that comes over specular surfaces is looked for from the lights; `None`: where there may be any.
    wants_caustics: Option<bool>,
    /// Most that one contribution of indirect light may be, in the mean over its wavelengths.
    most_indirect: f32,
    /// Photons, in a render that has caustics.
    caustics: Option<Caustics>,
    /// What a render with guiding has learned; `None` outside of one.
    guide: Option<Guide>,
}

fn build(p: &Params) -> Option<Box<dyn LightTransport>> {
    let max_depth = p.get_in("maxdepth", 5, 0..=1_000_000, "bounces", "longest path") as u32;
    let roulette_depth =
        p.get_in("rrdepth", 3, 0..=1_000_000, "bounces", "first bounce at which a path may end by roulette") as u32;
    let light_sampling = p.get(
        "lightsampling",
        true,
        "",
        "whether lights are sampled too (next-event estimation), or directions by the material alone",
    );
    let guiding = p.get("guiding", false, "", "whether directions follow what was learned of the light");
    let most_indirect = p.get_in(
        "clampindirect",
        0.0,
        0.0..=f64::from(f32::MAX),
        "W m^-2 sr^-1 nm^-1",
        "most that one contribution of indirect light may be, in the mean over its wavelengths, at energy 1; 0: any (biased)",
    );
    let most_indirect = if most_indirect > 0.0 { (most_indirect as f32).max(f32::MIN_POSITIVE) } else { f32::INFINITY };
    let caustics = p.get(
        "caustics",
        true,
        "",
        "whether light that comes over mirrors and through glass is looked for from the lights too; where it is not said, if lights are sampled and there may be any",
    );
    let wants_caustics = p.is_given("caustics").then_some(caustics);
    Some(Box::new(Path {
        max_depth,
        roulette_depth,
        light_sampling,
        guiding,
        wants_caustics,
        most_indirect,
        caustics: None,
        guide: None,
    }))
}

impl LightTransport for Path {
    fn follow(&self, scene: &Scene, path: &mut PathSample, log: &mut PathLog) {
        self.follow_batch(scene, std::slice::from_mut(path), log);
    }

    fn follow_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut PathLog) {
        for paths in paths.chunks_mut(BATCH) {
            self.follow_batch(scene, paths, log);
        }
    }

    fn for_render(&self, setting: &RenderSetting) -> Option<Box<dyn LightTransport>> {
        let guide = self.guiding.then(|| Guide::new(setting.scene.world.bounds));
        let wants_caustics = self.wants_caustics.unwrap_or(self.light_sampling);
        let caustics = if wants_caustics { Caustics::new(setting, self.max_depth) } else { None };
        (guide.is_some() || caustics.is_some()).then(|| Box::new(Self { guide, caustics, ..*self }) as _)
    }

    fn begin_wave(&mut self, setting: &RenderSetting, samples: Range<u32>) {
        if let Some(caustics) = &mut self.caustics {
            caustics.begin_wave(setting, samples);
        }
    }

    fn learns(&self) -> bool {
        self.guiding
    }

    fn end_wave(&mut self) {
        if let Some(guide) = &mut self.guide {
            guide.end_wave();
        }
    }

    fn save(&self) -> Vec<u8> {
        self.guide.as_ref().map_or_else(Vec::new, Guide::save)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), String> {
        match &mut self.guide {
            Some(guide) => guide.restore(saved),
            None if saved.is_empty() => Ok(()),
            None => Err("`guiding` is off, and a guide was saved".to_owned()),
        }
    }

    fn samples_lights(&self) -> bool {
        self.light_sampling
    }
}

impl Path {
    /// Follows up to [`BATCH`] paths to their ends.
    fn follow_batch(&self, scene: &Scene, paths: &mut [PathSample], log: &mut PathLog) {
        let (guide, caustics) = (self.guide.as_ref(), self.caustics.as_ref());
        let samples_lights = self.light_sampling && scene.light_sampler.can_sample();
        let connections = scene.integrator.connections().filter(|_| samples_lights);
        let mut states: ArrayVec<State, BATCH> = paths.iter().map(|path| State::new(path, self.most_indirect)).collect();
        let (mut found, mut pending) = (BatchConnections::default(), PendingShadowRays::default());
        for path in &mut *paths {
            path.radiance = SampledSpectrum::ZERO;
            path.behind = None;
        }
        let mut ends = [RayEnd::NONE; BATCH];
        // The paths that go on.
        let mut underway: ArrayVec<usize, BATCH> = (0..paths.len()).collect();
        for depth in 0..=self.max_depth {
            let rays: ArrayVec<Ray, BATCH> = underway.iter().map(|i| states[*i].ray).collect();
            scene.integrator.trace_all(&scene.world, &rays, &mut ends[..rays.len()]);
            // Where they have arrived, if they may go on from there.
            let mut met: ArrayVec<Met, BATCH> = ArrayVec::new();
            for (i, end) in underway.iter().zip(&ends) {
                log.counters.add_ray(end);
                let State { ray, throughput, lambda, scattered, .. } = &states[*i];
                if depth == 0 {
                    paths[*i].first = *end;
                } else if *scattered == 0 {
                    paths[*i].behind = Some(Behind { ray: *ray, end: *end, share: throughput.mean() });
                }
                log.note(|| PathEvent::Traced { ray: *ray, end: *end, throughput: *throughput, lambda_nm: lambda.lambda_nm });
                let at = Bounce { scene, connections, caustics, path: &mut paths[*i], state: &mut states[*i] };
                if let Some(vertex) = at.arrive(end, depth == 0, log)
                    && depth < self.max_depth
                {
                    let place = guide.filter(|_| vertex.material.is_matt()).map(|g| g.place(&vertex));
                    met.push(Met { index: *i, vertex, place });
                }
            }
            if let Some(caustics) = caustics {
                for Met { index, vertex, .. } in met.iter().filter(|m| !m.vertex.material.is_specular()) {
                    let state = &states[*index];
                    let brought = caustics.gather(scene, vertex, &state.lambda, self.max_depth - depth - 1);
                    let found = clamped(state.throughput * brought, state.most(state.scattered + 1));
                    if !found.is_zero() {
                        log.note(|| PathEvent::Found(found));
                        paths[*index].radiance += found;
                    }
                }
            }
            if let Some(connections) = connections {
                Self::sample_lights(scene, connections, &met, (&mut *paths, &states), (&mut found, &mut pending), log);
            }
            underway.clear();
            for Met { index, vertex, place } in &met {
                let at = Bounce { scene, connections, caustics, path: &mut paths[*index], state: &mut states[*index] };
                if at.scatter(vertex, guide.zip(place.as_ref()), depth >= self.roulette_depth, log) {
                    underway.push(*index);
                }
            }
            if let Some(connections) = connections {
                pending.trace(scene, connections, paths, log);
            }
            if underway.is_empty() {
                break;
            }
        }
        if let Some(guide) = guide {
            for (state, path) in states.iter().zip(paths) {
                state.records.iter().for_each(|record| guide.learn(record, path.radiance.mean()));
            }
        }
    }

    /// Draws a point of a light for every rough one of the vertices `met` and adds the shadow rays that lead there to `pending`.
    fn sample_lights(
        scene: &Scene,
        connections: &dyn Connections,
        met: &[Met],
        (paths, states): (&mut [PathSample], &[State]),
        (found, pending): (&mut BatchConnections, &mut PendingShadowRays),
        log: &mut PathLog,
    ) {
        let mut drawn: ArrayVec<(&Met, LightSample), BATCH> = ArrayVec::new();
        for met in met.iter().filter(|m| !m.vertex.material.is_specular()) {
            let stream = &mut paths[met.index].stream;
            let (choice, u) = (stream.next_1d(), stream.next_2d());
            if let Some(light) = scene.sample_light(choice, u) {
                drawn.push((met, light));
            }
        }
        let samples: ArrayVec<LightSampleAt<'_>, BATCH> = drawn
            .iter()
            .map(|(Met { index, vertex, place }, light)| {
                let state = &states[*index];
                // From here to the light it is scattered once more.
                let (lambda, throughput, most) = (&state.lambda, state.throughput, state.most(state.scattered + 1));
                LightSampleAt { scene, vertex, light, lambda, throughput, most, path: *index, place: place.as_ref() }
            })
            .collect();
        // What a path has found so far, as it would have to leave its vertex, and a random number.
        let roulette = |sample: &LightSampleAt<'_>| {
            let path = &mut paths[sample.path];
            (path.radiance.max() / sample.throughput.max(), path.stream.next_1d())
        };
        found.sample(connections, &samples, roulette, pending, log);
    }
}

/// Where a path has arrived.
struct Met<'a> {
    /// Number of the path among those that are followed together.
    index: usize,
    vertex: Vertex<'a>,
    /// What was learned about the light there.
    place: Option<GuidedHemisphere<'a>>,
}

/// A path at the end of a ray.
struct Bounce<'a, 'p, 's> {
    scene: &'s Scene,
    connections: Option<&'a dyn Connections>,
    caustics: Option<&'a Caustics>,
    path: &'a mut PathSample<'p>,
    state: &'a mut State,
}

impl<'s> Bounce<'_, '_, 's> {
    /// What the ray that ended at `end` has found; the vertex there, if it is one. `of_camera`: whether it is the camera's own ray.
    #[inline(always)]
    fn arrive(self, end: &RayEnd, of_camera: bool, log: &mut PathLog) -> Option<Vertex<'s>> {
        let Self { scene, connections, caustics, path, state } = self;
        if let Some(record) = state.records.last_mut().filter(|r| r.before.is_none()) {
            record.before = Some(path.radiance.mean());
        }
        let hit = match end.arrival {
            Arrival::Surface(hit) => hit,
            Arrival::Sky(direction, side) => {
                let sky = match (connections, &state.chosen) {
                    (Some(c), Some(chosen)) => chosen.sky(scene, c, state, (direction, side), end.swept),
                    (_, None) if let (Some(caustics), Some(departure)) = (caustics, state.departure) => {
                        state.sky_of_caustic(scene, caustics, departure, (direction, side))
                    }
                    _ => scene.sky((direction, side), &state.lambda, of_camera),
                };
                let found = clamped(state.throughput * sky, state.most(state.scattered));
                log.note(|| PathEvent::Found(found));
                path.radiance += found;
                return None;
            }
            Arrival::Captured | Arrival::OutOfSteps => return None,
        };
        let Some(mut vertex) = scene.vertex(hit, &state.lambda) else {
            log.counters.no_static_observer += 1;
            return None;
        };
        scene.date(&mut vertex, &state.ray, &mut state.travelled);
        if let Some(patch) = path.patch.filter(|_| of_camera) {
            patch.fit(scene, &mut vertex);
        }
        if vertex.emitter.is_some() {
            let weight = match (connections, &state.chosen) {
                (Some(c), Some(chosen)) => chosen.weight(scene, c, &state.ray, &vertex, end.swept),
                _ => state.weight_of_caustic(scene, caustics, &vertex),
            };
            let found = clamped(state.throughput * vertex.emitted() * weight, state.most(state.scattered));
            log.note(|| PathEvent::Found(found));
            path.radiance += found;
        }
        Some(vertex)
    }

    /// The path's next direction from `vertex`: by what was learned, if anything, else by the material. Whether it goes on.
    fn scatter(self, vertex: &Vertex, guided: Option<(&Guide, &GuidedHemisphere)>, roulette: bool, log: &mut PathLog) -> bool {
        let Self { scene, caustics, path, state, .. } = self;
        let stream = &mut path.stream;
        let (choice, u) = (stream.next_1d(), stream.next_2d());
        let sample = match guided {
            Some((guide, place)) => state.guide(place, guide.learns(), vertex, u),
            None => vertex.material.sample(&vertex.shading, vertex.wo, choice, u),
        };
        let Some(sample) = sample else {
            log.note(|| PathEvent::Ended("the surface gives it no direction"));
            return false;
        };
        state.throughput *= sample.weight;
        if sample.drops_wavelengths {
            state.lambda.drop_secondary(&mut state.throughput);
        }
        let direction = vertex.chart_direction(sample.wi);
        log.note(|| PathEvent::Scattered { direction, weight: sample.weight, pdf: sample.pdf, specular: sample.specular });
        if state.throughput.is_zero() || !vertex.is_consistent(sample.wi) {
            log.note(|| PathEvent::Ended("nothing is left of it"));
            return false;
        }
        if let Some(shift) = vertex.shift(direction) {
            state.lambda = state.lambda.shifted(shift);
            state.throughput *= scene.radiance_factor(shift);
        }
        if state.scattered > 0 || !vertex.shows_others() {
            state.scattered += 1;
        }
        let footprint = if sample.specular { state.ray.footprint } else { scene.footprints.rough };
        state.ray = vertex.spawn(&scene.world, sample.wi, footprint);
        if caustics.is_some() {
            state.departure = match sample.specular {
                true => state.departure.map(|d| d.further(sample.drops_wavelengths)),
                // By the material, whatever has chosen: photons know no guide.
                false => {
                    let by_material = || vertex.material.pdf(&vertex.shading, vertex.wo, sample.wi);
                    Some(Departure::new(vertex, direction, guided.map_or(sample.pdf, |_| by_material())))
                }
            };
        }
        state.chosen = (!sample.specular).then(|| Chosen {
            from: scene.world.place_of(&vertex.hit),
            pdf: sample.pdf,
            solid_angle_factor: vertex.observer.solid_angle_factor(state.ray.direction),
        });

        // ---- Russian roulette
        if roulette {
            let survive = (state.throughput.max() * state.guided).min(0.95);
            if stream.next_1d() >= survive {
                log.note(|| PathEvent::Ended("roulette"));
                return false;
            }
            state.throughput *= 1.0 / survive;
        }
        true
    }
}
