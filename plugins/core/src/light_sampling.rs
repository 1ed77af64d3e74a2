//! Light sampling: points of the lights, chosen by power, and what arrives from them along a geodesic.

use crate::geometry::{Geometry, sample_triangle, triangle_area};
use crate::integrator::Connection;
use crate::intersector::Primitive;
use crate::light::{AreaLight, Emission};
use crate::observer::Observer;
use crate::sampling::Discrete;
use crate::scene::{Scene, Vertex};
use crate::spacetime::{Place, Side};
use crate::spectrum::{SampledSpectrum, SampledWavelengths};
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
}

impl Emitter {
    /// The emission `light` of `geometry`, which is number `index`.
    pub fn new(index: u32, geometry: &Geometry, light: Arc<dyn AreaLight>) -> Self {
        let areas = (0..geometry.triangle_count() as u32).filter_map(|t| geometry.corners(t)).map(triangle_area);
        let triangles = match geometry {
            Geometry::Analytic(_) => Discrete::default(),
            _ => Discrete::new(areas),
        };
        Self { geometry: index, light, triangles }
    }

    /// Area of the surface, chart measure.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        match geometry {
            Geometry::Analytic(surface) => surface.area(),
            _ => self.triangles.total(),
        }
    }
}

/// What a light sample is a point of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// A surface that emits.
    Surface {
        /// Index in [`Scene::emitters`].
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
        /// Index in [`Scene::lights`].
        light: u32,
    },
    /// A light infinitely far away.
    Sky {
        /// Index in [`Scene::lights`].
        light: u32,
        /// Whether it shines from one direction.
        is_parallel: bool,
    },
}

impl LightSource {
    /// Number of the light in [`Scene::light_choice`], in a scene of so many surfaces that emit.
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

impl Scene {
    /// Draws a point of a light: the light by power, the point by chart area. `None` if there is no light to aim at, or if
    /// nobody can stand at the point.
    pub fn sample_light(&self, choice: f32, u: Vec2) -> Option<LightSample> {
        let (index, rest) = self.light_choice.sample(choice)?;
        let chosen = self.light_choice.probability(index);
        let (source, point, pdf) = match self.emitters.get(index) {
            None => {
                let index = index - self.emitters.len();
                let (light, side, number) = (&self.lights[index], self.light_sides[index], index as u32);
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
                let (primitive, point, pdf, s) = match &self.world.geometries[emitter.geometry as usize] {
                    Geometry::Analytic(surface) => {
                        let s = surface.sample(u);
                        (0, s.point, chosen * s.pdf, (s.normal, s.uv))
                    }
                    mesh => {
                        let (triangle, _) = emitter.triangles.sample(rest)?;
                        let (point, b) = sample_triangle(mesh.corners(triangle as u32)?, u);
                        let s = mesh.surface(point, triangle as u32, b);
                        (triangle as u32, point, chosen / emitter.triangles.total(), (s.normal, s.uv))
                    }
                };
                let point = Place { x: point, side: self.world.side_of(emitter.geometry) };
                let primitive = Primitive { geometry: emitter.geometry, primitive };
                (LightSource::Surface { emitter: index as u32, primitive, normal: s.0, uv: s.1 }, point, pdf)
            }
        };
        let observer = self.world.static_observer(point)?;
        Some(LightSample { source, point: point.x, side: point.side, pdf, observer })
    }

    /// The density with which [`Scene::sample_light`] draws the surface point of `vertex`, with respect to chart area.
    pub fn light_pdf(&self, vertex: &Vertex) -> f64 {
        let Some(index) = self.shapes[vertex.hit.geometry as usize].emitter else { return 0.0 };
        let emitter = &self.emitters[index as usize];
        let within = match &self.world.geometries[emitter.geometry as usize] {
            Geometry::Analytic(surface) => surface.pdf(vertex.hit.point),
            _ => 1.0 / emitter.triangles.total(),
        };
        self.light_choice.probability(index as usize) * within
    }

    /// What arrives at `receiver` from `sample` along `connection`, which leads from the receiver to the light.
    pub fn arriving(
        &self,
        sample: &LightSample,
        connection: &Connection,
        receiver: &Observer,
        lambda: &SampledWavelengths,
    ) -> Arriving {
        let at_light = &sample.observer;
        let ratio = at_light.ratio(connection.arrival);
        let (lambda_nm, factor) = (lambda.at(ratio as f32), self.radiance_factor(ratio));
        let leaving = -at_light.local_direction(connection.arrival);
        let per_solid_angle = sample.pdf * connection.spread / receiver.solid_angle_factor(connection.launch);
        match sample.source {
            LightSource::Surface { emitter, normal, uv, .. } => {
                let cos_theta = at_light.local_normal(normal).dot(leaving) as f32;
                let at = Emission { uv, cos_theta, lambda_nm, clock_rate: at_light.clock_rate() as f32 };
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
