//! `path`: path tracing with light sampling (next-event estimation) along the geodesics that join a surface and a light.
//!
//! Directions follow the material (BSDF sampling); paths end by Russian roulette once they carry little. At every rough surface
//! also a point of a light is drawn, and shadow rays are traced along all geodesics that the integrator finds to it: in flat space one, around a
//! hole the direct one and the one that goes round the other side (and more, if the integrator is asked for them). Both techniques
//! are weighted by multiple importance sampling (balance heuristic; Veach and Guibas 1995). A point drawn with density p per
//! chart area is one drawn with density `p spread / |cos theta_y|` per chart solid angle, whatever way the light travels in between. Where it goes straight, a
//! sphere is drawn by the cone of directions in which it is seen (Shirley, Wang and Zimmerman 1996), any other light by area.
//!
//! Shadow rays cost most, and the light that went round the hole is mostly faint, as is much of what later bounces find: where a geodesic
//! carries less than a share `FAINT` of what all to the same point carry, or of what the path has found already, its shadow ray is traced with
//! a probability in proportion to what it carries, and counts the more (Russian roulette). That changes no mean. Where geodesics themselves are
//! dear, around a hole that spins, they are looked for likewise, by what those around the hole without spin would carry.
//!
//! With `guiding`, paths that belong to no pixel learn where light comes from, and rough surfaces choose part of their directions by that
//! ([`Guide`]): where only light from elsewhere arrives, in shadows and on ceilings, noise falls most. No sample's mean depends on what
//! was learned. Where it is not said whether to guide, that is found out after 16 samples of each pixel: some blocks of pixels are rendered both ways, and
//! what leaves less noise in as many rays goes on. Weights then say little about what a path is worth, for they are small where much light is expected; roulette ends paths by what surfaces
//! reflect.
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
//! | `guiding` | bool | true | | whether directions follow what was learned of the light; where it is not said, from sample 16 on if a trial shows that it pays |
//! | `caustics` | bool | true | | whether light that comes over mirrors and through glass is looked for from the lights too ([`Caustics`]); where it is not said, if lights are sampled and there may be any |
//! | `clampindirect` | float | 0 | W m^-2 sr^-1 nm^-1 | most that one contribution of indirect light may be, in the mean over its wavelengths, at energy 1; 0: any (biased) |
//!
//! ```bhs
//! LightTransport "path" "integer maxdepth" 8
//! WorldBegin
//! ```

use crate::bounce::Bounce;
use crate::caustics::Caustics;
use crate::guide::pilot::{Lessons, Pilots, TRIED_WAVE};
use crate::guide::{Guide, GuidedHemisphere};
use crate::path_state::{State, clamped};
use crate::shadow_rays::{BatchConnections, LightSampleAt, PendingShadowRays};
use arrayvec::ArrayVec;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::{Ray, RayEnd};
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
    /// Whether directions follow what was learned; `None`: where that pays.
    wants_guiding: Option<bool>,
    /// Whether light that comes over specular surfaces is looked for from the lights; `None`: where there may be any.
    wants_caustics: Option<bool>,
    /// Most that one contribution of indirect light may be, in the mean over its wavelengths.
    most_indirect: f32,
    /// Photons, in a render that has caustics.
    caustics: Option<Caustics>,
    /// What a render learns of its light.
    pilots: Option<Pilots>,
}

/// Whether the scene wants what the parameter `name` says; `None`: it does not say.
fn wanted(p: &Params, name: &'static str, meaning: &'static str) -> Option<bool> {
    let wanted = p.get(name, true, "", meaning);
    p.is_given(name).then_some(wanted)
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
    let wants_guiding = wanted(
        p,
        "guiding",
        "whether directions follow what was learned of the light; where it is not said, from sample 16 on if a trial shows that it pays",
    );
    let most_indirect = p.get_in(
        "clampindirect",
        0.0,
        0.0..=f64::from(f32::MAX),
        "W m^-2 sr^-1 nm^-1",
        "most that one contribution of indirect light may be, in the mean over its wavelengths, at energy 1; 0: any (biased)",
    );
    let most_indirect = if most_indirect > 0.0 { (most_indirect as f32).max(f32::MIN_POSITIVE) } else { f32::INFINITY };
    let wants_caustics = wanted(
        p,
        "caustics",
        "whether light that comes over mirrors and through glass is looked for from the lights too; where it is not said, if lights are sampled and there may be any",
    );
    Some(Box::new(Path {
        max_depth,
        roulette_depth,
        light_sampling,
        wants_guiding,
        wants_caustics,
        most_indirect,
        caustics: None,
        pilots: None,
    }))
}

impl LightTransport for Path {
    fn follow(&self, scene: &Scene, path: &mut PathSample, log: &mut PathLog) {
        self.follow_all(scene, std::slice::from_mut(path), log);
    }

    fn follow_all(&self, scene: &Scene, paths: &mut [PathSample], log: &mut PathLog) {
        let how = How { scene, guide: self.pilots.as_ref().and_then(Pilots::guide), caustics: self.caustics.as_ref() };
        for paths in paths.chunks_mut(BATCH) {
            self.follow_batch(&how, paths, log, None);
        }
    }

    fn for_render(&self, setting: &RenderSetting) -> Option<Box<dyn LightTransport>> {
        let pilots = if self.max_depth > 1 { Pilots::new(setting, self.wants_guiding) } else { None };
        let wants_caustics = self.wants_caustics.unwrap_or(self.light_sampling);
        let caustics = if wants_caustics { Caustics::new(setting, self.max_depth) } else { None };
        (pilots.is_some() || caustics.is_some()).then(|| Box::new(Self { pilots, caustics, ..*self }) as _)
    }

    fn begin_wave(&mut self, setting: &RenderSetting, samples: Range<u32>) {
        if let Some(mut pilots) = self.pilots.take() {
            if let Some(caustics) = self.caustics.as_mut().filter(|_| pilots.tries(samples.start)) {
                // With all pixels, whichever take part in this wave: the trial does not depend on these.
                caustics.begin_wave(&RenderSetting { pixels: setting.all_pixels(), ..setting.clone() }, TRIED_WAVE);
            }
            pilots.prepare(setting, samples.start, &|guide, paths, log, lessons| {
                // Nobody learns with photons: those of one wave would be taken for the light.
                let caustics = self.caustics.as_ref().filter(|_| lessons.is_none());
                self.follow_batch(&How { scene: setting.scene, guide, caustics }, paths, log, lessons);
            });
            self.pilots = Some(pilots).filter(|pilots| pilots.may_guide());
        }
        if let Some(caustics) = &mut self.caustics {
            caustics.begin_wave(setting, samples);
        }
    }

    fn samples_lights(&self) -> bool {
        self.light_sampling
    }
}

/// What paths are followed with.
struct How<'a> {
    scene: &'a Scene,
    guide: Option<&'a Guide>,
    caustics: Option<&'a Caustics>,
}

impl Path {
    /// Follows up to [`BATCH`] paths to their ends; what they teach is added to `lessons`, if somebody learns.
    fn follow_batch(&self, how: &How, paths: &mut [PathSample], log: &mut PathLog, mut lessons: Option<&mut Lessons>) {
        let How { scene, guide, caustics } = *how;
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
                let lessons = lessons.as_deref_mut().map(|lessons| (lessons, *i));
                let at = Bounce { scene, connections, caustics, path: &mut paths[*i], state: &mut states[*i], lessons };
                if let Some(vertex) = at.arrive(end, depth == 0, log)
                    && depth < self.max_depth
                {
                    let place = guide.filter(|_| !vertex.material.is_specular()).map(|g| g.place(&vertex));
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
                let lessons = lessons.as_deref_mut().map(|lessons| (lessons, *index));
                let (path, state) = (&mut paths[*index], &mut states[*index]);
                let at = Bounce { scene, connections, caustics, path, state, lessons };
                if at.scatter(vertex, place.as_ref(), depth >= self.roulette_depth, log) {
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
            let receiver = scene.world.place_of(&met.vertex.hit);
            if let Some(light) = scene.sample_light(Some(receiver), choice, u) {
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
