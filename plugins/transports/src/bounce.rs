//! What a path does where a ray of it ends: what it finds there, and where it goes on.

use crate::caustics::{Caustics, Departure};
use crate::guide::GuidedHemisphere;
use crate::guide::pilot::Lessons;
use crate::path_state::{Chosen, State, clamped};
use bhs_core::ray::{Arrival, RayEnd};
use bhs_engine::connections::Connections;
use bhs_engine::path_log::PathEvent;
use bhs_engine::scene::{Scene, Vertex};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::PathSample;

/// A path at the end of a ray.
pub struct Bounce<'a, 'p, 's> {
    /// Where all is.
    pub scene: &'s Scene,
    /// How lights are sampled, if they are.
    pub connections: Option<&'a dyn Connections>,
    /// Photons, if there are any.
    pub caustics: Option<&'a Caustics>,
    /// The path.
    pub path: &'a mut PathSample<'p>,
    /// What is known of it.
    pub state: &'a mut State,
    /// What it teaches, and its number there, if it is followed for that.
    pub lessons: Option<(&'a mut Lessons, usize)>,
}

impl<'s> Bounce<'_, '_, 's> {
    /// What the ray that ended at `end` has found; the vertex there, if it is one. `of_camera`: whether it is the camera's own ray.
    #[inline(always)]
    pub fn arrive(self, end: &RayEnd, of_camera: bool, log: &mut PathLog) -> Option<Vertex<'s>> {
        let Self { scene, connections, caustics, path, state, lessons } = self;
        if let Some((lessons, number)) = lessons {
            lessons.arrive(number, path.radiance.mean());
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
    pub fn scatter(self, vertex: &Vertex, place: Option<&GuidedHemisphere>, roulette: bool, log: &mut PathLog) -> bool {
        let Self { scene, caustics, path, state, lessons, .. } = self;
        let stream = &mut path.stream;
        let (choice, u) = (stream.next_1d(), stream.next_2d());
        let guided = place.filter(|place| place.guides());
        let sample = match guided {
            Some(place) => state.guide(place, vertex, choice, u),
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
        if let (Some((lessons, number)), Some(place)) = (lessons, place)
            && !sample.specular
            && let Some(lesson) = place.lesson(sample.wi, sample.pdf)
        {
            lessons.begin(number, lesson, state.throughput.mean());
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
