//! Light sampling: points of the lights, chosen by power, and what arrives from them along a geodesic.

use crate::connections::Connection;
use crate::world::World;
use bhs_core::geometry::{Geometry, sample_triangle, triangle_area};
use bhs_core::intersector::Primitive;
use bhs_core::light::{AreaLight, Emission, EmissionPoint, Light};
use bhs_core::motion::Motion;
use bhs_core::observer::{Conventions, Observer};
use bhs_core::ray::SurfaceHit;
use bhs_core::sampling::Discrete;
use bhs_core::spacetime::{Place, Side};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use glam::{DVec3, Vec2};
use std::sync::Arc;

/// A surface that emits.
pub struct Emitter {
    /// Index of the geometry.
    pub geometry: u32,
    /// What it emits.
    pub light: Arc<dyn AreaLight>,
    /// Choice of a triangle by chart area; empty for an analytic surface.
    pub triangles: Discrete,
    /// How the surface moves; `None`: at rest.
    pub motion: Option<Arc<dyn Motion>>,
}

impl Emitter {
    /// The emission `light` of `geometry`, which is number `index`.
    pub fn new(index: u32, geometry: &Geometry, light: Arc<dyn AreaLight>) -> Self {
        let areas = (0..geometry.triangle_count() as u32).filter_map(|t| geometry.corners(t)).map(triangle_area);
        let triangles = match geometry {
            Geometry::Analytic(_) => Discrete::default(),
            _ => Discrete::new(areas),
        };
        Self { geometry: index, light, triangles, motion: None }
    }

    /// Area of the surface, chart measure.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        match geometry {
            Geometry::Analytic(surface) => surface.area(),
            _ => self.triangles.total(),
        }
    }

    /// What light sampling chooses it by: its power averaged over `lo..=hi` (nm), by chart area; 0 of one that depends on time, which
    /// light sampling leaves out.
    pub fn power(&self, geometry: &Geometry, lo: f32, hi: f32) -> f64 {
        if self.light.depends_on_time() {
            return 0.0;
        }
        let nowhere = EmissionPoint { uv: Vec2::ZERO, point: DVec3::ZERO };
        if self.light.is_uniform() {
            return self.light.exitance(&nowhere, lo, hi) * self.area(geometry);
        }
        // The mean over points evenly spread over the surface.
        const N: u32 = 32;
        let cell = |i: u32| (i as f32 + 0.5) / N as f32;
        let points =
            (0..N * N).filter_map(|i| self.point(geometry, Vec2::new(cell(i % N), cell(i / N)), (i as f32 * 0.618_034).fract()));
        points.map(|at| self.light.exitance(&at, lo, hi)).sum::<f64>() / f64::from(N * N) * self.area(geometry)
    }

    /// The point of the surface that three numbers in [0,1) stand for, `choice` between triangles.
    pub fn point(&self, geometry: &Geometry, u: Vec2, choice: f32) -> Option<EmissionPoint> {
        if let Geometry::Analytic(surface) = geometry {
            let sample = surface.sample(u);
            return Some(EmissionPoint { uv: sample.uv, point: sample.point });
        }
        let (triangle, _) = self.triangles.sample(choice)?;
        let (point, weights) = sample_triangle(geometry.corners(triangle as u32)?, u);
        Some(EmissionPoint { uv: geometry.surface(point, triangle as u32, weights).uv, point })
    }
}

/// What a light sample is a point of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// A surface that emits.
    Surface {
        /// Index in [`LightSampler::emitters`].
        emitter: u32,
        /// The triangle or analytic surface.
        primitive: Primitive,
        /// Outer unit normal, chart.
        normal: DVec3,
        /// Texture coordinates.
        uv: Vec2,
    },
    /// A light that shines from a point.
    Point {
        /// Index in [`LightSampler::lights`].
        light: u32,
    },
    /// A light infinitely far away.
    Sky {
        /// Index in [`LightSampler::lights`].
        light: u32,
        /// Whether it shines from one direction.
        is_parallel: bool,
    },
}

impl LightSource {
    /// Number of the light in [`LightSampler::choice`], in a scene of so many surfaces that emit.
    #[inline]
    pub fn number(&self, emitters: usize) -> u32 {
        match self {
            Self::Surface { emitter, .. } => *emitter,
            Self::Point { light } | Self::Sky { light, .. } => emitters as u32 + light,
        }
    }
}

/// A point of a light drawn for light sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// What it is a point of.
    pub source: LightSource,
    /// The point, render space; for a light of the sky, the unit chart direction towards it.
    pub point: DVec3,
    /// The side that it is on.
    pub side: Side,
    /// Density with respect to chart area, choice of the light included; with respect to solid angle for a light of the sky; of a
    /// light that shines from a point or from one direction, the probability of its choice.
    pub pdf: f64,
    /// The observer there.
    pub observer: Observer,
}

impl LightSample {
    /// The point with its side.
    #[inline]
    pub fn place(&self) -> Place {
        Place { x: self.point, side: self.side }
    }
}

/// What arrives from a light sample along one geodesic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arriving {
    /// Radiance, intensity of a point light, or irradiance of a parallel one, at E = 1, if all of it is passed on.
    pub emitted: SampledSpectrum,
    /// What that is divided by: the density of the sample per local solid angle of the receiver; for a point light, the area across the
    /// bundle at the light per that solid angle (both in local frames), times the probability of the choice; for a parallel light, the
    /// solid angle far away instead of the area.
    pub density: f64,
    /// Whether light sampling alone can find the light.
    pub is_point: bool,
}

/// The lights of a scene, and how light sampling chooses among them.
#[derive(Default)]
pub struct LightSampler {
    /// The surfaces that emit.
    pub emitters: Vec<Emitter>,
    /// Lights that are not surfaces.
    pub lights: Vec<Arc<dyn Light>>,
    /// The side of a wormhole that each of `lights` is on.
    pub sides: Vec<Side>,
    /// Choice by power: first the emitters, then all of `lights` (whose power is 0 if only BSDF sampling finds them).
    pub choice: Discrete,
    /// Whether an emitter depends on the time at which its light leaves: then paths count the time that their light has taken.
    pub depends_on_time: bool,
}

impl LightSampler {
    /// Whether there is a light that can be sampled.
    #[inline]
    pub fn can_sample(&self) -> bool {
        self.choice.total() > 0.0
    }

    /// Draws a point of a light: the light by power, the point by chart area, or among those that may be seen from `receiver` where that is known and light
    /// does not bend. `None` if there is no light to sample, or no static observer at the point.
    pub fn sample(&self, world: &World, receiver: Option<Place>, choice: f32, u: Vec2) -> Option<LightSample> {
        let (index, rest) = self.choice.sample(choice)?;
        self.sample_of(world, receiver, (index, self.choice.probability(index)), rest, u)
    }

    /// The same of the light `index` of [`LightSampler::choice`], which has been chosen with the probability `chosen`; `rest` is one number in [0,1)
    /// more.
    pub fn sample_of(
        &self,
        world: &World,
        receiver: Option<Place>,
        (index, chosen): (usize, f64),
        rest: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let (source, point, pdf) = match self.emitters.get(index) {
            None => {
                let index = index - self.emitters.len();
                let (light, side, number) = (&self.lights[index], self.sides[index], index as u32);
                match light.position() {
                    Some(point) => (LightSource::Point { light: number }, Place { x: point, side }, chosen),
                    None => {
                        let sky = light.sample_sky(u)?;
                        return Some(LightSample {
                            source: LightSource::Sky { light: number, is_parallel: sky.is_parallel },
                            point: sky.direction,
                            side,
                            pdf: chosen * sky.pdf,
                            observer: Observer::FLAT,
                        });
                    }
                }
            }
            Some(emitter) => {
                let (primitive, point, pdf, s) = match &world.geometries[emitter.geometry as usize] {
                    Geometry::Analytic(surface) => {
                        let s = match seen_from(world, receiver, emitter.geometry) {
                            Some(place) => surface.sample_from(place, u),
                            None => surface.sample(u),
                        };
                        (0, s.point, chosen * s.pdf, (s.normal, s.uv))
                    }
                    mesh => {
                        let (triangle, _) = emitter.triangles.sample(rest)?;
                        let (point, b) = sample_triangle(mesh.corners(triangle as u32)?, u);
                        let s = mesh.surface(point, triangle as u32, b);
                        (triangle as u32, point, chosen / emitter.triangles.total(), (s.normal, s.uv))
                    }
                };
                let point = Place { x: point, side: world.side_of(emitter.geometry) };
                let primitive = Primitive { geometry: emitter.geometry, primitive };
                (LightSource::Surface { emitter: index as u32, primitive, normal: s.0, uv: s.1 }, point, pdf)
            }
        };
        let motion = self.emitters.get(index).and_then(|emitter| emitter.motion.as_ref());
        let observer = match motion {
            None => world.static_observer(point)?,
            Some(motion) => world.moving_observer(motion.as_ref(), point)?,
        };
        Some(LightSample { source, point: point.x, side: point.side, pdf, observer })
    }

    /// The density with which [`LightSampler::sample`] draws the point of `hit` for the same `receiver`, with respect to chart area; the point lies on
    /// emitter number `emitter`.
    pub fn pdf(&self, world: &World, receiver: Option<Place>, emitter: u32, hit: &SurfaceHit) -> f64 {
        let Emitter { geometry, triangles, .. } = &self.emitters[emitter as usize];
        let within = match &world.geometries[*geometry as usize] {
            Geometry::Analytic(surface) => match seen_from(world, receiver, *geometry) {
                Some(place) => surface.pdf_from(place, hit.point),
                None => surface.pdf(hit.point),
            },
            _ => 1.0 / triangles.total(),
        };
        self.choice.probability(emitter as usize) * within
    }

    /// The light from far away on the side `sky.1` along the chart direction `sky.0`, at the wavelengths `lambda` at E = 1.
    pub fn sky(&self, sky: (DVec3, Side), lambda: &SampledWavelengths) -> SampledSpectrum {
        self.sum_of_sky(sky.1, lambda, |_, light, lambda_nm| light.sky_radiance(sky.0, lambda_nm))
    }

    /// The same without lights that are points, which a picture draws by itself.
    pub fn sky_without_points(&self, sky: (DVec3, Side), lambda: &SampledWavelengths) -> SampledSpectrum {
        self.sum_of_sky(sky.1, lambda, |_, light, lambda_nm| match light.points().is_empty() {
            true => light.sky_radiance(sky.0, lambda_nm),
            false => SampledSpectrum::ZERO,
        })
    }

    /// The light along the way of [`LightSampler::sky`], each light that [`LightSampler::sample`] draws multiplied by `weight` of its index in
    /// [`LightSampler::choice`] and of the density with which that draws the direction, choice included (per solid angle far from all mass).
    pub fn sky_weighted(
        &self,
        (direction, side): (DVec3, Side),
        lambda: &SampledWavelengths,
        weight: impl Fn(usize, f64) -> f32,
    ) -> SampledSpectrum {
        self.sum_of_sky(side, lambda, |i, light, lambda_nm| {
            let radiance = light.sky_radiance(direction, lambda_nm);
            let choice = self.choice.probability(self.emitters.len() + i);
            let pdf = if choice > 0.0 { choice * light.sky_pdf(direction) } else { 0.0 };
            if pdf > 0.0 { radiance * weight(self.emitters.len() + i, pdf) } else { radiance }
        })
    }

    #[inline]
    fn sum_of_sky(
        &self,
        side: Side,
        lambda: &SampledWavelengths,
        of: impl Fn(usize, &dyn Light, [f32; N_LAMBDA]) -> SampledSpectrum,
    ) -> SampledSpectrum {
        let mut sum = SampledSpectrum::ZERO;
        for (i, light) in self.lights.iter().enumerate().filter(|(i, _)| self.sides[*i] == side) {
            sum += of(i, light.as_ref(), lambda.lambda_nm);
        }
        sum
    }

    /// What arrives at `receiver` from `sample` along `connection`, which leads from the receiver to the light.
    pub fn arriving(
        &self,
        sample: &LightSample,
        connection: &Connection,
        receiver: &Observer,
        lambda: &SampledWavelengths,
        conventions: &Conventions,
    ) -> Arriving {
        let at_light = &sample.observer;
        let ratio = at_light.ratio(connection.arrival);
        let (lambda_nm, factor) = (lambda.at(ratio as f32), conventions.radiance_factor(ratio));
        let leaving = -at_light.local_direction(connection.arrival);
        let per_solid_angle = sample.pdf * connection.spread / receiver.solid_angle_factor(connection.launch);
        match sample.source {
            LightSource::Surface { emitter, normal, uv, .. } => {
                let cos_theta = at_light.local_normal(normal).dot(leaving) as f32;
                let clock_rate = at_light.clock_rate() as f32;
                let at = Emission { uv, point: sample.point, time: 0.0, cos_theta, lambda_nm, clock_rate };
                let emitted = self.emitters[emitter as usize].light.radiance(&at) * factor;
                let density = per_solid_angle / connection.arrival.dot(normal).abs();
                Arriving { emitted, density, is_point: false }
            }
            LightSource::Point { light } => {
                let emitted = self.lights[light as usize].intensity(leaving, lambda_nm) * factor;
                let density = per_solid_angle * at_light.bundle_area_factor(connection.arrival);
                Arriving { emitted, density, is_point: true }
            }
            LightSource::Sky { light, is_parallel } => {
                let light = &self.lights[light as usize];
                let emitted = if is_parallel { light.irradiance(lambda_nm) } else { light.sky_radiance(sample.point, lambda_nm) };
                Arriving { emitted: emitted * factor, density: per_solid_angle, is_point: is_parallel }
            }
        }
    }
}

/// Where `geometry` is seen from along straight lines, if it is: bent light comes from the far side of a surface too.
#[inline]
fn seen_from(world: &World, receiver: Option<Place>, geometry: u32) -> Option<DVec3> {
    receiver.filter(|place| !world.bends() && place.side == world.side_of(geometry)).map(|place| place.x)
}
