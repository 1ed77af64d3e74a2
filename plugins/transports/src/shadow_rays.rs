//! Light sampling along geodesics (next-event estimation): what each may contribute is found first, the shadow rays of all are traced
//! afterwards, together.

use crate::guide::GuidedHemisphere;
use crate::path_state::clamped;
use arrayvec::ArrayVec;
use bhs_core::ray::Ray;
use bhs_core::spacetime::{self, Side};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, End, MOST_TURNS, ShadowRay};
use bhs_engine::light_sampling::{LightSample, LightSource};
use bhs_engine::path_log::{LightPlace, PathEvent};
use bhs_engine::scene::{Scene, Vertex};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample};
use glam::DVec3;

/// Geodesics to lights that may come together at one bounce of a batch of paths.
const MOST: usize = BATCH * 2 * MOST_TURNS;

/// Light that arrives along a shadow ray that is not occluded.
#[derive(Clone, Copy)]
struct Contribution {
    /// Number of the path that it belongs to.
    path: usize,
    /// As the camera would receive it.
    radiance: SampledSpectrum,
    /// Number of the light that it comes from, the surfaces that emit first.
    light: u32,
}

impl Contribution {
    fn add(&self, visible: bool, place: LightPlace, paths: &mut [PathSample], log: &mut PathLog) {
        log.note(|| PathEvent::Sampled { light: self.light, place, radiance: self.radiance, visible });
        if visible {
            paths[self.path].radiance += self.radiance;
        } else {
            log.counters.shadow_rays_occluded += 1;
        }
    }
}

/// Shadow rays that have not been traced, with what they may contribute.
#[derive(Default)]
pub struct PendingShadowRays {
    /// To points, and what may come from there.
    to_points: ArrayVec<ShadowRay, MOST>,
    from_points: ArrayVec<Contribution, MOST>,
    /// To infinitely far away, each with the side that it has to arrive on, and what may come from there.
    to_sky: ArrayVec<(Ray, Side), MOST>,
    from_sky: ArrayVec<Contribution, MOST>,
}

impl PendingShadowRays {
    /// Traces all of them, adds the light that arrives to the paths, and forgets them.
    pub fn trace(&mut self, scene: &Scene, connections: &dyn Connections, paths: &mut [PathSample], log: &mut PathLog) {
        let mut occluded = [false; MOST];
        let occluded = &mut occluded[..self.to_points.len()];
        log.counters.add_shadow_rays(occluded.len(), connections.occluded_all(&scene.world, &self.to_points, occluded));
        for ((contribution, ray), occluded) in self.from_points.iter().zip(&self.to_points).zip(occluded) {
            contribution.add(!*occluded, LightPlace::Point(ray.to.x), paths, log);
        }
        if !self.to_sky.is_empty() {
            let mut escaped = [false; MOST];
            let escaped = &mut escaped[..self.to_sky.len()];
            log.counters.add_shadow_rays(escaped.len(), scene.integrator.escape_all(&scene.world, &self.to_sky, escaped));
            for ((contribution, (ray, _)), escaped) in self.from_sky.iter().zip(&self.to_sky).zip(escaped) {
                contribution.add(*escaped, LightPlace::Sky(ray.direction), paths, log);
            }
        }
        self.to_points.clear();
        self.from_points.clear();
        self.to_sky.clear();
        self.from_sky.clear();
    }
}

/// Share of other light below which the shadow ray of a geodesic is traced by Russian roulette. Measured in a room with a hole: with 0.05 to 0.5 noise grows
/// by 2 %, time shrinks by 7 %.
const FAINT: f32 = 0.5;

/// The least probability with which a geodesic is looked for that is dear and promises little: it may turn out to carry more.
const LEAST_WORTH: f32 = 0.05;

/// How much less worth is light that goes round the other side of the hole, where geodesics are dear: finding it takes some five times as long.
const DEARER: f32 = 2.0;

/// A place, and a direction of the sky of a side.
type Sky = (spacetime::Place, (DVec3, Side));

/// The geodesics from vertices to points of lights, of a batch of paths.
pub struct BatchConnections {
    /// For each number of whole turns around the hole, the pair of each vertex.
    turns: [[ConnectionPair; BATCH]; MOST_TURNS],
    /// How many turns there are.
    count: usize,
    /// Of those that were chosen, one over the probability of that.
    factors: [[f32; 2]; BATCH],
}

impl Default for BatchConnections {
    fn default() -> Self {
        Self { turns: [[[None; 2]; BATCH]; MOST_TURNS], count: 0, factors: [[0.0; 2]; BATCH] }
    }
}

impl BatchConnections {
    /// Adds to `pending` the shadow rays to `samples`, at most [`BATCH`] of them. `roulette` tells of each what the path has found so far, as it would
    /// have to leave the vertex, and a random number in [0,1).
    pub fn sample(
        &mut self,
        connections: &dyn Connections,
        samples: &[LightSampleAt<'_>],
        mut roulette: impl FnMut(&LightSampleAt<'_>) -> (f32, f32),
        pending: &mut PendingShadowRays,
        log: &mut PathLog,
    ) {
        let Some(scene) = samples.first().map(|sample| sample.scene) else { return };
        let ends = samples.iter().map(|sample| (scene.world.place_of(&sample.vertex.hit), sample.light));
        if connections.is_dear() {
            let survive = |k: usize, outlines: &ConnectionPair| {
                let (so_far, u) = roulette(&samples[k]);
                (samples[k].worth(outlines, so_far), u)
            };
            self.find_chosen(scene, connections, ends, survive, log);
            for (k, sample) in samples.iter().enumerate() {
                sample.chosen(self.chosen(k), pending, log);
            }
            return;
        }
        self.find(scene, connections, ends, log);
        for (k, sample) in samples.iter().enumerate() {
            // Straight shadow rays cost so little that roulette only adds noise.
            if scene.bends() {
                let (so_far, u) = roulette(sample);
                sample.bent(self.of(k), so_far, u, pending, log);
            } else {
                sample.straight(self.of(k), pending, log);
            }
        }
    }

    /// Finds those between `ends`: at most [`BATCH`] of them.
    fn find<'a>(
        &mut self,
        scene: &Scene,
        connections: &dyn Connections,
        ends: impl Iterator<Item = (spacetime::Place, &'a LightSample)> + Clone,
        log: &mut PathLog,
    ) {
        let is_sky = |light: &LightSample| matches!(light.source, LightSource::Sky { .. });
        // Nothing joins a point with itself: those of the sky are put in afterwards.
        let pairs: ArrayVec<[spacetime::Place; 2], BATCH> =
            ends.clone().map(|(x, light)| [x, if is_sky(light) { x } else { light.place() }]).collect();
        self.count = connections.turns() as usize;
        let mut rows: ArrayVec<&mut [ConnectionPair], MOST_TURNS> =
            self.turns[..self.count].iter_mut().map(|found| &mut found[..pairs.len()]).collect();
        connections.connect_all(&scene.world, &pairs, &mut rows);
        drop(rows);
        let count = pairs.len();
        if ends.clone().any(|(_, light)| is_sky(light)) {
            let of_sky = ends.enumerate().filter(|(_, (_, light))| is_sky(light));
            self.find_in_sky(scene, connections, of_sky.map(|(k, (x, light))| (k, (x, (light.point, light.side)))).collect());
        }
        if scene.bends() {
            self.count_missed(count, connections.images(), log);
        }
    }

    /// Finds those between `ends`, at most [`BATCH`] of them, that are chosen: `survive` says with which probabilities, by the number of the vertex and
    /// what may be found, and which random number in [0,1) decides.
    fn find_chosen<'a>(
        &mut self,
        scene: &Scene,
        connections: &dyn Connections,
        ends: impl Iterator<Item = (spacetime::Place, &'a LightSample)>,
        mut survive: impl FnMut(usize, &ConnectionPair) -> ([f32; 2], f32),
        log: &mut PathLog,
    ) {
        let end = |light: &LightSample| match light.source {
            LightSource::Sky { .. } => End::Sky((light.point, light.side)),
            _ => End::Point(light.place()),
        };
        let ends: ArrayVec<(spacetime::Place, End), BATCH> = ends.map(|(x, light)| (x, end(light))).collect();
        let (factors, found) = (&mut self.factors, &mut self.turns[0][..ends.len()]);
        self.count = 1;
        let mut chosen = [[false; 2]; BATCH];
        let mut choose = |k: usize, outlines: &ConnectionPair| {
            let (survive, u) = survive(k, outlines);
            factors[k] = survive.map(|survive| 1.0 / survive);
            // What is not foretold counts as not found.
            chosen[k] = [0, 1].map(|image| outlines[image].is_none() || u < survive[image]);
            chosen[k]
        };
        connections.connect_chosen(&scene.world, &ends, &mut choose, found);
        let counters = &mut log.counters;
        counters.connections_sought += ends.len() as u64;
        for (pair, chosen) in found.iter().zip(&chosen) {
            for image in (0..2).filter(|image| chosen[*image] && pair[*image].is_none()) {
                *counters.connections_missed()[image] += 1;
            }
            for image in (0..2).filter(|image| !chosen[*image]) {
                *counters.connections_passed_over()[image] += 1;
                counters.connections_ended += 1;
            }
        }
    }

    /// Those of vertex number `k` that were chosen, each with one over the probability of that.
    fn chosen(&self, k: usize) -> impl Iterator<Item = (&Connection, f32)> {
        self.turns[0][k].iter().zip(self.factors[k]).filter_map(|(connection, factor)| Some((connection.as_ref()?, factor)))
    }

    /// Finds those to the sky, each with the number of its vertex.
    #[inline(never)]
    fn find_in_sky(&mut self, scene: &Scene, connections: &dyn Connections, of_sky: ArrayVec<(usize, Sky), BATCH>) {
        let skies: ArrayVec<Sky, BATCH> = of_sky.iter().map(|(_, sky)| *sky).collect();
        let mut pairs = [[[None; 2]; BATCH]; MOST_TURNS];
        let mut rows: ArrayVec<&mut [ConnectionPair], MOST_TURNS> =
            pairs[..self.count].iter_mut().map(|found| &mut found[..skies.len()]).collect();
        connections.connect_sky_all(&scene.world, &skies, &mut rows);
        for (turn, found) in self.turns[..self.count].iter_mut().zip(rows) {
            for ((k, _), pair) in of_sky.iter().zip(found) {
                turn[*k] = *pair;
            }
        }
    }

    /// Counts those of the first `images` of each of `count` vertices that were not found.
    #[inline(never)]
    fn count_missed(&self, count: usize, images: usize, log: &mut PathLog) {
        log.counters.connections_sought += count as u64;
        for (image, missed) in log.counters.connections_missed().into_iter().enumerate().take(images) {
            let found = self.turns[image / 2][..count].iter().filter(|pair| pair[image % 2].is_some()).count();
            *missed += (count - found) as u64;
        }
    }

    /// Those of vertex number `k`.
    fn of(&self, k: usize) -> impl Iterator<Item = &Connection> {
        self.turns[..self.count].iter().flat_map(move |pairs| pairs[k].iter().flatten())
    }
}

/// A sample of a light at a vertex of a path.
pub struct LightSampleAt<'a> {
    /// Where all is.
    pub scene: &'a Scene,
    /// Where the path is.
    pub vertex: &'a Vertex<'a>,
    /// The point.
    pub light: &'a LightSample,
    /// The wavelengths that the path has there.
    pub lambda: &'a SampledWavelengths,
    /// Weight of what it finds there.
    pub throughput: SampledSpectrum,
    /// Most that it may find, in the mean over its wavelengths.
    pub most: f32,
    /// Number of the path in its batch.
    pub path: usize,
    /// What draws the path's next direction, if not the material.
    pub place: Option<&'a GuidedHemisphere<'a>>,
}

impl LightSampleAt<'_> {
    /// Adds shadow rays along straight lines to `pending`, for what may arrive there and is scattered back along the path.
    fn straight<'c>(
        &self,
        connections: impl Iterator<Item = &'c Connection>,
        pending: &mut PendingShadowRays,
        log: &mut PathLog,
    ) {
        self.chosen(connections.map(|connection| (connection, 1.0)), pending, log);
    }

    /// The same along geodesics that were chosen, each with one over the probability of that.
    fn chosen<'c>(
        &self,
        connections: impl Iterator<Item = (&'c Connection, f32)>,
        pending: &mut PendingShadowRays,
        log: &mut PathLog,
    ) {
        for (connection, factor) in connections {
            log.counters.connections += 1;
            let carried = self.carried(connection);
            if carried.is_zero() {
                log.counters.connections_dark += 1;
            } else {
                self.push(connection, carried * factor, pending);
            }
        }
    }

    /// With which probability each of the geodesics is to be looked for, of which the `outlines` are known. `found`: as for [`LightSampleAt::bent`].
    fn worth(&self, outlines: &ConnectionPair, found: f32) -> [f32; 2] {
        let light = outlines.map(|outline| outline.map_or(0.0, |outline| self.carried(&outline).max()));
        let all = (light[0] + light[1]).max(found);
        // Where nothing carries light the share is not a number.
        let shares = [light[0] / (FAINT * all), light[1] / (FAINT * DEARER * all)];
        shares.map(|share| if share >= LEAST_WORTH { share.min(1.0) } else { LEAST_WORTH })
    }

    /// The same along all geodesics to the sample: those that carry little are chosen by Russian roulette, with `u`, a number in [0,1) that
    /// nothing else depends on. `found`: the light of the path so far, as it would have to leave the vertex.
    fn bent<'c>(
        &self,
        connections: impl Iterator<Item = &'c Connection>,
        found: f32,
        u: f32,
        pending: &mut PendingShadowRays,
        log: &mut PathLog,
    ) {
        let connections: ArrayVec<(&Connection, SampledSpectrum), { 2 * MOST_TURNS }> =
            connections.map(|connection| (connection, self.carried(connection))).collect();
        let all: f32 = connections.iter().map(|(_, light)| light.max()).sum();
        for (connection, carried) in &connections {
            log.counters.connections += 1;
            let survives = (carried.max() / (FAINT * all.max(found))).min(1.0);
            // One number for all: each of them by itself is traced as often as it should be.
            if carried.is_zero() {
                log.counters.connections_dark += 1;
            } else if u >= survives {
                log.counters.connections_ended += 1;
            } else {
                self.push(connection, *carried * (1.0 / survives), pending);
            }
        }
    }

    /// Adds the shadow ray along a geodesic that contributes `carried` unless it is occluded.
    fn push(&self, connection: &Connection, carried: SampledSpectrum, pending: &mut PendingShadowRays) {
        let Self { scene, vertex, .. } = self;
        let start = vertex.leave(&scene.world, connection.launch, scene.footprints.rough);
        let light = self.light.source.number(scene.light_sampler.emitters.len());
        let radiance = clamped(self.throughput * carried, self.most);
        let contribution = Contribution { path: self.path, radiance, light };
        if matches!(self.light.source, LightSource::Sky { .. }) {
            pending.to_sky.push((start, self.light.side));
            pending.from_sky.push(contribution);
        } else {
            let target = match self.light.source {
                LightSource::Surface { primitive, .. } => Some(primitive),
                _ => None,
            };
            pending.to_points.push(ShadowRay {
                start,
                from: vertex.hit.point,
                to: self.light.place(),
                target,
                connection: *connection,
            });
            pending.from_points.push(contribution);
        }
    }

    /// What the light sample sends back along the path along a geodesic, weighted against BSDF sampling, if nothing occludes it.
    fn carried(&self, connection: &Connection) -> SampledSpectrum {
        let vertex = self.vertex;
        let wi = vertex.shading_direction(connection.launch);
        let scattered = vertex.material.evaluate(&vertex.shading, vertex.wo, wi);
        if scattered.is_zero() || !vertex.is_consistent(wi) {
            return SampledSpectrum::ZERO;
        }
        let Scene { light_sampler, world, .. } = self.scene;
        let arriving = |lambda| light_sampler.arriving(self.light, connection, &vertex.observer, lambda, &world.conventions);
        // A surface that moves changes wavelengths.
        let (arriving, shifted) = match vertex.shift(connection.launch) {
            None => (arriving(self.lambda), 1.0),
            Some(shift) => (arriving(&self.lambda.shifted(shift)), world.conventions.radiance_factor(shift)),
        };
        let scattered = scattered * shifted;
        let density = arriving.density;
        // Zero where light of a whole circle of directions meets in the point (a light exactly behind the hole): of a surface, the points
        // that are so have no area.
        if arriving.emitted.is_zero() || !(density > 0.0 && density.is_finite()) {
            return SampledSpectrum::ZERO;
        }
        let against = match &self.place {
            _ if arriving.is_point => 0.0,
            Some(place) if place.guides() => place.pdf(vertex, wi),
            _ => vertex.material.pdf(&vertex.shading, vertex.wo, wi),
        };
        let per_density = 1.0 / (density + f64::from(against));
        let (carried, factor) = (scattered * arriving.emitted, per_density as f32);
        if carried.is_finite() && factor.is_normal() {
            return carried * factor;
        }
        // A very bright and very small light: its radiance may be within single precision, though its parts are not.
        scattered.zip(arriving.emitted, |s, e| (f64::from(s) * f64::from(e) * per_density) as f32)
    }
}
