//! Light as it leaves the lights: photons are drawn here, and whoever finds a light otherwise asks with which density they would have been.
//!
//! Densities are per area across the light and solid angle (étendue), both as the observer at the light measures them; for light of the sky, far from
//! all mass. Étendue times the square of the frequency is the same all along a ray ([`Scene::etendue`]), so that no photon has to be followed to know how
//! dense they are where they arrive: that is the weight of photons against directions chosen there.

use super::across;
use super::aim::Aim;
use super::spectrum::{COUNT, Range};
use bhs_core::equal_area::{equal_area_direction, equal_area_point};
use bhs_core::geometry::Aabb;
use bhs_core::light::Emission;
use bhs_core::ray::{Ray, SurfaceHit};
use bhs_core::sampling::{Discrete, SampleStream, concentric_disk, concentric_square, cosine_hemisphere};
use bhs_core::spacetime::{Ball, Side};
use bhs_engine::light_sampling::{LightSample, LightSource};
use bhs_engine::scene::{Scene, Vertex};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// How far from the scene light of the sky begins where it bends, in radii of the scene: it is straight there but for a millionth.
const FAR: f64 = 1e3;

/// Where photons leave, and how they are aimed.
pub struct PhotonSource {
    range: Range,
    /// Of the lights, in the order of `LightSampler::choice`.
    choice: Discrete,
    aims: Vec<Aim>,
    /// What light of the sky has to pass through; `None` where that is not known.
    target: Option<Target>,
}

/// A disc across any direction, through which all light passes that matters.
#[derive(Clone, Copy)]
struct Target {
    center: DVec3,
    radius: f64,
    /// How far from it light begins; `None` where that is straight: just outside of the scene, for single precision of a long way is coarse.
    distance: Option<f64>,
}

/// Light that leaves.
pub struct Emitted {
    /// Its ray, to be followed forwards.
    pub ray: Ray,
    /// [`Scene::etendue`] there.
    pub etendue: f64,
    /// Its wavelengths: see [`Range::lambda`].
    pub first: f32,
    /// Radiance at E = 1 over the density with which it was drawn.
    pub flux: [f32; COUNT],
    /// That density; infinite for a light that shines from a point or from one direction.
    pub density: f64,
    /// The light, and the cell of its [`Aim`].
    pub light: usize,
    pub cell: usize,
}

impl PhotonSource {
    /// That of a scene of which nothing has been learned; `specular` is a box around the surfaces that are to be hit first.
    pub fn new(scene: &Scene, range: Range, specular: Aabb) -> Self {
        let target = Target::of(scene, specular);
        let lights = scene.light_sampler.emitters.len() + scene.light_sampler.lights.len();
        let source = Self { range, choice: Discrete::default(), aims: Vec::new(), target };
        let power = (0..lights).map(|i| source.power(scene, i)).collect::<Vec<_>>();
        Self { choice: Discrete::new(power), aims: (0..lights).map(|_| Aim::default()).collect(), ..source }
    }

    /// What a light is chosen by before anything is known.
    fn power(&self, scene: &Scene, light: usize) -> f64 {
        let sampler = &scene.light_sampler;
        let of_sky = light.checked_sub(sampler.emitters.len()).filter(|i| sampler.lights[*i].position().is_none());
        match of_sky {
            Some(i) if self.target.is_none() || sampler.sides[i] == Side::Far => 0.0,
            _ if sampler.can_sample() => sampler.choice.probability(light),
            _ => 0.0,
        }
    }

    /// The same, aimed by what photons have brought: of each its light, its cell, and its light.
    pub fn learn(&self, scene: &Scene, brought: &[(usize, usize, f64)]) -> Self {
        /// Share of the lights' choice by their power.
        const BY_POWER: f64 = 0.1;
        let mut cells = vec![vec![0.0; Aim::CELLS]; self.aims.len()];
        let mut of_light = vec![0.0; self.aims.len()];
        for &(light, cell, flux) in brought {
            cells[light][cell] += flux;
            of_light[light] += flux;
        }
        let all: f64 = of_light.iter().sum();
        let [power, all] =
            [(0..self.aims.len()).map(|i| self.power(scene, i)).sum::<f64>(), all].map(|sum| sum.max(f64::MIN_POSITIVE));
        let choice =
            of_light.iter().enumerate().map(|(i, flux)| BY_POWER * self.power(scene, i) / power + (1.0 - BY_POWER) * flux / all);
        let aims = cells.iter().map(|c| Aim::learn(c)).collect();
        Self { range: self.range, choice: Discrete::new(choice), aims, target: self.target }
    }

    /// Whether there is a light that photons may come from.
    pub fn can_emit(&self) -> bool {
        self.choice.total() > 0.0
    }

    /// Light that leaves, or `None` if this one does not.
    pub fn emit(&self, scene: &Scene, stream: &mut SampleStream) -> Option<Emitted> {
        let (index, rest) = self.choice.sample(stream.next_1d())?;
        let u = stream.next_2d();
        // Nothing is known of where it will arrive.
        let chosen = (index, self.choice.probability(index));
        let point = scene.light_sampler.sample_of(&scene.world, None, chosen, rest, u);
        let by_aim = stream.next_1d();
        let aimed = self.aims[index].sample(by_aim, stream.next_2d());
        let (even, first) = (stream.next_2d(), stream.next_1d());
        let at = At { index, point: point?, aimed, even: even.as_dvec2(), first };
        match at.point.source {
            LightSource::Sky { .. } => self.emit_from_sky(scene, at),
            _ => self.emit_from_place(scene, at),
        }
    }

    /// Light of a surface or of a point.
    fn emit_from_place(&self, scene: &Scene, at: At) -> Option<Emitted> {
        let LightSample { observer, point, side, source, pdf } = at.point;
        let normal = match source {
            LightSource::Surface { normal, .. } => Some(observer.local_normal(normal)),
            _ => None,
        };
        let local = match (at.aimed, normal) {
            (Some(aimed), _) => equal_area_direction(aimed),
            (None, Some(normal)) => {
                let (s, t) = normal.any_orthonormal_pair();
                // Either side: few lights shine on both, and one that does must not be left out.
                let turn = if at.even.x < 0.5 { 1.0 } else { -1.0 };
                let u = DVec2::new((2.0 * at.even.x).fract(), at.even.y);
                let d = cosine_hemisphere(u.as_vec2()).as_dvec3();
                (s * d.x + t * d.y + normal * (d.z * turn)).normalize()
            }
            (None, None) => equal_area_direction(at.even),
        };
        let looked = observer.chart_direction(-local);
        let per_direction = self.direction_density(at.index, local, normal);
        let ratio = observer.ratio(looked);
        let factor = scene.radiance_factor(ratio);
        let lambda_nm = |k| self.range.set(at.first, k).map(|l| l * ratio as f32);
        let (density, flux): (_, [f32; COUNT]) = match source {
            LightSource::Surface { emitter, normal: chart, uv, .. } => {
                let across = across(&observer, chart, looked);
                let light = &scene.light_sampler.emitters[emitter as usize].light;
                let (cos_theta, clock_rate) = (normal?.dot(local) as f32, observer.clock_rate() as f32);
                let radiance =
                    |k| light.radiance(&Emission { uv, point, time: 0.0, cos_theta, lambda_nm: lambda_nm(k), clock_rate });
                (pdf * per_direction / across, Range::of_sets(radiance))
            }
            LightSource::Point { light } => {
                let light = &scene.light_sampler.lights[light as usize];
                (pdf * per_direction, Range::of_sets(|k| light.intensity(local, lambda_nm(k))))
            }
            LightSource::Sky { .. } => return None,
        };
        let ray = match source {
            LightSource::Surface { primitive, normal, .. } => {
                let hit = SurfaceHit {
                    point,
                    direction: -looked,
                    geometry: primitive.geometry,
                    primitive: primitive.primitive,
                    barycentric: DVec2::ZERO,
                    is_crowded: false,
                };
                scene.world.spawn(&hit, normal, -looked)
            }
            _ => Ray { side, ..Ray::new(point, -looked) },
        };
        let etendue = scene.etendue(at.point.place(), &observer, looked);
        let is_point = matches!(source, LightSource::Point { .. });
        let cell = Aim::cell(equal_area_point(local));
        self.emitted(at, (Ray { footprint: scene.footprints.rough, ..ray }, etendue), (flux, factor), (density, is_point), cell)
    }

    /// Light of the sky.
    fn emit_from_sky(&self, scene: &Scene, at: At) -> Option<Emitted> {
        let LightSource::Sky { light, is_parallel } = at.point.source else { return None };
        let Target { center, radius, distance } = self.target?;
        // Only where all have one direction a place on the disc says where they go.
        let square = at.aimed.filter(|_| is_parallel).unwrap_or(at.even);
        let place = concentric_disk(square.as_vec2()).as_dvec2();
        let looked = at.point.point;
        let (s, t) = looked.any_orthonormal_pair();
        let on_disc = center + (s * place.x + t * place.y) * radius;
        let distance = match distance {
            Some(distance) => distance,
            None => scene.world.bounds.clip(on_disc, looked, f64::NEG_INFINITY, f64::INFINITY)?.1 + radius,
        };
        let origin = on_disc + looked * distance;
        let light = &scene.light_sampler.lights[light as usize];
        let area = PI * radius * radius;
        let (base, learned) = self.aims[at.index].density(square);
        let aimed = if is_parallel { base + learned } else { 1.0 };
        let lambda_nm = |k| self.range.set(at.first, k);
        let flux = Range::of_sets(|k| match is_parallel {
            true => light.irradiance(lambda_nm(k)),
            false => light.sky_radiance(looked, lambda_nm(k)),
        });
        let density = at.point.pdf * aimed / area;
        let cell = Aim::cell(concentric_square(place.as_vec2()).as_dvec2());
        let ray = Ray { side: at.point.side, footprint: scene.footprints.rough, ..Ray::new(origin, -looked) };
        self.emitted(at, (ray, 1.0), (flux, 1.0), (density, is_parallel), cell)
    }

    fn emitted(
        &self,
        at: At,
        (ray, etendue): (Ray, f64),
        (radiance, factor): ([f32; COUNT], f32),
        (density, alone): (f64, bool),
        cell: usize,
    ) -> Option<Emitted> {
        let flux = radiance.map(|r| (f64::from(r * factor) / density) as f32);
        let is_usable = density > 0.0 && etendue > 0.0 && flux.iter().all(|f| f.is_finite()) && flux.iter().any(|f| *f > 0.0);
        let density = if alone { f64::INFINITY } else { density };
        is_usable.then_some(Emitted { ray, etendue, first: at.first, flux, density, light: at.index, cell })
    }

    /// Density of the local direction `local` (1/sr) of a light with the given local normal, if it is a surface.
    fn direction_density(&self, light: usize, local: DVec3, normal: Option<DVec3>) -> f64 {
        let (base, learned) = self.aims[light].density(equal_area_point(local));
        let even = normal.map_or(1.0 / (4.0 * PI), |normal| normal.dot(local).abs() / (2.0 * PI));
        base * even + learned / (4.0 * PI)
    }

    /// The density of the light that leaves the surface of `vertex` back along the path that has found it.
    pub fn density(&self, scene: &Scene, vertex: &Vertex) -> f64 {
        let Some(light) = scene.shapes[vertex.hit.geometry as usize].emitter.map(|e| e as usize) else { return 0.0 };
        let by_power = scene.light_sampler.choice.probability(light);
        if by_power <= 0.0 {
            return 0.0;
        }
        let (observer, looked) = (&vertex.observer, vertex.hit.direction);
        let per_area = scene.light_pdf(None, vertex) / by_power * self.choice.probability(light);
        let across = across(observer, vertex.normal, looked);
        let normal = observer.local_normal(vertex.normal);
        per_area * self.direction_density(light, -observer.local_direction(looked), Some(normal)) / across
    }

    /// The same of light of the sky that was found, of the light `index` which light sampling draws with the density `pdf`, choice included.
    pub fn sky_density(&self, scene: &Scene, index: usize, pdf: f64) -> f64 {
        let Some(Target { radius, .. }) = self.target else { return 0.0 };
        pdf / scene.light_sampler.choice.probability(index) * self.choice.probability(index) / (PI * radius * radius)
    }
}

/// A point of a light with the numbers that decide on its direction.
struct At {
    index: usize,
    point: LightSample,
    /// A point of the square by what was learned, if it is that.
    aimed: Option<DVec2>,
    /// Another.
    even: DVec2,
    first: f32,
}

impl Target {
    fn of(scene: &Scene, specular: Aabb) -> Option<Self> {
        let around = |bounds: &Aabb| (bounds.center(), 0.5 * (bounds.max - bounds.min).length());
        if !scene.bends() {
            let (center, radius) = around(&specular);
            // A little more, for what rounding moves.
            return Some(Self { center, radius: 1.001 * radius, distance: None });
        }
        let (center, radius) = around(&scene.world.bounds);
        let Ball { center, radius } = scene.world.spacetime().aim(Ball { center, radius })?;
        Some(Self { center, radius, distance: Some(FAR * radius) })
    }
}

/// The mean of a photon's light.
pub fn mean(flux: &[f32; COUNT]) -> f64 {
    flux.iter().map(|f| f64::from(*f)).sum::<f64>() / COUNT as f64
}
