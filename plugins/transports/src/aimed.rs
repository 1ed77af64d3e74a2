//! What may arrive from lamps that paths aim at: found first, looked for afterwards, all of it together.

use crate::guide::Place;
use arrayvec::ArrayVec;
use bhs_core::integrator::{Connection, ConnectionPair, Connections, MOST_TURNS, Ray, Sight};
use bhs_core::light_sampling::{LightSample, LightSource};
use bhs_core::path_log::{LightPlace, PathEvent};
use bhs_core::scene::{Scene, Vertex};
use bhs_core::spacetime::{self, Side};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use bhs_core::transport::{BATCH, PathSample};
use std::f32::consts::FRAC_1_PI;

/// Geodesics to lamps that may come together at one bounce of a batch of paths.
const MOST: usize = BATCH * 2 * MOST_TURNS;

/// Light that arrives if nothing stands in its way.
#[derive(Clone, Copy)]
struct Gain {
    /// Number of the path that it belongs to.
    path: usize,
    /// As the camera would receive it.
    light: SampledSpectrum,
    /// Number of the light that it comes from, the surfaces that emit first.
    from: u32,
}

impl Gain {
    fn arrive(&self, visible: bool, place: LightPlace, paths: &mut [PathSample], log: &mut TraceLog) {
        log.note(|| PathEvent::Sampled { light: self.from, place, radiance: self.light, visible });
        if visible {
            paths[self.path].radiance += self.light;
        } else {
            log.counters.connections_blocked += 1;
        }
    }
}

/// Light that is on its way along geodesics which nobody has looked along yet.
#[derive(Default)]
pub struct Aimed {
    /// From points.
    sights: ArrayVec<Sight, MOST>,
    gains: ArrayVec<Gain, MOST>,
    /// From infinitely far away.
    skies: ArrayVec<(Ray, Side, Gain), MOST>,
}

impl Aimed {
    /// Looks along all geodesics, adds the light that arrives to the paths, and forgets them.
    pub fn look(&mut self, scene: &Scene, connections: &dyn Connections, paths: &mut [PathSample], log: &mut TraceLog) {
        let queries = log.counters.queries;
        let mut visible = [false; MOST];
        let visible = &mut visible[..self.sights.len()];
        connections.visible_all(&scene.world, &self.sights, visible, log);
        for ((gain, sight), visible) in self.gains.iter().zip(&self.sights).zip(visible) {
            gain.arrive(*visible, LightPlace::Point(sight.to.x), paths, log);
        }
        for (ray, side, gain) in &self.skies {
            let visible = scene.integrator.escapes(&scene.world, ray, *side, log);
            gain.arrive(visible, LightPlace::Sky(ray.direction), paths, log);
        }
        log.counters.connections_searched += (self.sights.len() + self.skies.len()) as u64;
        log.counters.connection_queries += log.counters.queries - queries;
        self.sights.clear();
        self.gains.clear();
        self.skies.clear();
    }
}

/// Share of other light below which the light of a geodesic is left to chance. Measured in a room with a hole: with 0.05 to 0.5 noise grows
/// by 2 %, time shrinks by 7 %.
const FAINT: f32 = 0.5;

/// The geodesics from vertices to points of lamps.
pub struct Images {
    /// For each number of whole turns around the hole, the pair of each vertex.
    turns: [[ConnectionPair; BATCH]; MOST_TURNS],
    /// How many turns there are.
    count: usize,
}

impl Default for Images {
    fn default() -> Self {
        Self { turns: [[[None; 2]; BATCH]; MOST_TURNS], count: 0 }
    }
}

impl Images {
    /// Finds those between `ends`: at most [`BATCH`] of them.
    pub fn find<'a>(
        &mut self,
        scene: &Scene,
        connections: &dyn Connections,
        ends: impl Iterator<Item = (spacetime::Place, &'a LightSample)> + Clone,
    ) {
        let is_sky = |light: &LightSample| matches!(light.source, LightSource::Sky { .. });
        // Nothing joins a point with itself: those of the sky are put in afterwards.
        let pairs: ArrayVec<[spacetime::Place; 2], BATCH> =
            ends.clone().map(|(x, light)| [x, if is_sky(light) { x } else { light.place() }]).collect();
        self.count = connections.turns() as usize;
        let mut rows: ArrayVec<&mut [ConnectionPair], MOST_TURNS> =
            self.turns[..self.count].iter_mut().map(|found| &mut found[..pairs.len()]).collect();
        connections.connect_all(&scene.world, &pairs, &mut rows);
        for (turn, found) in (0..).zip(rows) {
            for (found, (x, light)) in found.iter_mut().zip(ends.clone()).filter(|(_, (_, light))| is_sky(light)) {
                *found = connections.connect_sky(&scene.world, x, (light.point, light.side), turn);
            }
        }
    }

    /// Those of vertex number `k`.
    pub fn of(&self, k: usize) -> impl Iterator<Item = &Connection> {
        self.turns[..self.count].iter().flat_map(move |pairs| pairs[k].iter().flatten())
    }
}

/// A point of a lamp whose light is looked for at a vertex of a path.
pub struct Sought<'a> {
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
    /// Number of the path in its batch.
    pub path: usize,
    /// What draws the path's next direction, if not the material.
    pub place: Option<&'a Place<'a>>,
}

impl Sought<'_> {
    /// Notes what may arrive along straight lines and is scattered back along the path.
    pub fn straight<'c>(&self, images: impl Iterator<Item = &'c Connection>, aimed: &mut Aimed, log: &mut TraceLog) {
        for connection in images {
            log.counters.connections += 1;
            let carried = self.carried(connection);
            if carried.is_zero() {
                log.counters.connections_dark += 1;
            } else {
                self.aim(connection, carried, aimed);
            }
        }
    }

    /// The same along all of some geodesics. `found`: the light of the path so far, as it would have to leave the vertex. `spare` is a number in
    /// [0,1) that nothing else depends on.
    pub fn bent<'c>(
        &self,
        images: impl Iterator<Item = &'c Connection>,
        found: f32,
        spare: f32,
        aimed: &mut Aimed,
        log: &mut TraceLog,
    ) {
        let images: ArrayVec<(&Connection, SampledSpectrum), { 2 * MOST_TURNS }> =
            images.map(|connection| (connection, self.carried(connection))).collect();
        let all: f32 = images.iter().map(|(_, light)| light.max()).sum();
        for (connection, carried) in &images {
            log.counters.connections += 1;
            let looked_at = (carried.max() / (FAINT * all.max(found))).min(1.0);
            // One number for all: each image by itself is looked at as often as it should be.
            if carried.is_zero() {
                log.counters.connections_dark += 1;
            } else if spare >= looked_at {
                log.counters.connections_faint += 1;
            } else {
                self.aim(connection, *carried * (1.0 / looked_at), aimed);
            }
        }
    }

    /// Notes what is `carried` by a geodesic unless something stands in its way.
    fn aim(&self, connection: &Connection, carried: SampledSpectrum, aimed: &mut Aimed) {
        let Self { scene, vertex, .. } = self;
        let start = vertex.leave(&scene.world, connection.launch, scene.footprints.rough);
        let from = self.light.source.number(scene.emitters.len());
        let gain = Gain { path: self.path, light: self.throughput * carried, from };
        if matches!(self.light.source, LightSource::Sky { .. }) {
            aimed.skies.push((start, self.light.side, gain));
        } else {
            let target = match self.light.source {
                LightSource::Surface { primitive, .. } => Some(primitive),
                _ => None,
            };
            aimed.sights.push(Sight { start, from: vertex.hit.point, to: self.light.place(), target, connection: *connection });
            aimed.gains.push(gain);
        }
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
        let density = arriving.density;
        // Zero where light of a whole circle of directions meets in the point (a lamp exactly behind the hole): of a surface, the points
        // that are so have no area.
        if arriving.emitted.is_zero() || !(density > 0.0 && density.is_finite()) {
            return SampledSpectrum::ZERO;
        }
        let against = match &self.place {
            _ if arriving.is_point => 0.0,
            Some(place) => place.density(wi) * (wi.z.abs() * FRAC_1_PI),
            None => vertex.material.pdf(&vertex.shading, vertex.wo, wi),
        };
        let per_density = 1.0 / (density + f64::from(against));
        let (carried, factor) = (scattered * arriving.emitted, per_density as f32);
        if carried.is_finite() && factor.is_normal() {
            return carried * factor;
        }
        // A very bright and very small lamp: its light may be within single precision, though its parts are not.
        scattered.zip(arriving.emitted, |s, e| (f64::from(s) * f64::from(e) * per_density) as f32)
    }
}
