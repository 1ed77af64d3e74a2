//! A path under way: what `path` knows of it between one bounce and the next.

use crate::caustics::{Caustics, Departure};
use crate::guide::GuidedHemisphere;
use bhs_core::material::BsdfSample;
use bhs_core::ray::Ray;
use bhs_core::sampling::{ONE_MINUS_EPSILON, balance_heuristic};
use bhs_core::spacetime::{self, Side};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_engine::connections::Connections;
use bhs_engine::scene::{Scene, Travelled, Vertex};
use bhs_engine::transport::PathSample;
use glam::{DVec3, Vec2};

/// How the ray under way was chosen: what a light that it finds is weighted against.
pub struct Chosen {
    /// Where it left: the point of the surface itself.
    pub from: spacetime::Place,
    /// Density of its direction per local solid angle.
    pub pdf: f32,
    /// Local over chart solid angle where it left.
    pub solid_angle_factor: f64,
}

impl Chosen {
    /// The weight of this technique for the emission that `ray` has found at `vertex` after sweeping `swept`.
    pub fn weight(&self, scene: &Scene, connections: &dyn Connections, ray: &Ray, vertex: &Vertex, swept: f64) -> f32 {
        let to = scene.world.place_of(&vertex.hit);
        let Some(spread) = connections.spread(&scene.world, self.from, ray.direction, to, swept) else { return 1.0 };
        let density = scene.light_pdf(Some(self.from), vertex);
        // Not drawn by light sampling: at grazing incidence the spread per area may be infinite, and the product no number.
        if density <= 0.0 {
            return 1.0;
        }
        let per_area = spread / vertex.hit.direction.dot(vertex.normal).abs();
        balance_heuristic(self.pdf, (density * per_area / self.solid_angle_factor) as f32)
    }

    /// The light of the sky that the ray of `state` has found in the direction `sky.0` on the side `sky.1` after sweeping `swept`, weighted likewise.
    pub fn sky(
        &self,
        scene: &Scene,
        connections: &dyn Connections,
        state: &State,
        sky: (DVec3, Side),
        swept: f64,
    ) -> SampledSpectrum {
        scene.light_sampler.sky_weighted(sky, &state.lambda, |_, pdf| {
            match connections.spread_sky(&scene.world, self.from, state.ray.direction, sky, swept) {
                Some(spread) => balance_heuristic(self.pdf, (pdf * spread / self.solid_angle_factor) as f32),
                None => 1.0,
            }
        })
    }
}

/// A path under way.
pub struct State {
    /// Where it goes next.
    pub ray: Ray,
    /// Weight of what it finds there.
    pub throughput: SampledSpectrum,
    /// The wavelengths that it still has.
    pub lambda: SampledWavelengths,
    /// `None` after the camera and after specular bounces: only BSDF sampling finds light there.
    pub chosen: Option<Chosen>,
    /// How it left its last rough surface.
    pub departure: Option<Departure>,
    /// How much less it weighs because its directions were more likely than the materials would have made them.
    pub guided: f32,
    /// Most that one contribution of indirect light may be, in the mean over its wavelengths.
    most_indirect: f32,
    /// How often it was scattered, from the first surface on that shows no others.
    pub scattered: u32,
    /// What its light has come along: see [`Scene::date`].
    pub travelled: Travelled,
}

impl State {
    /// A path that begins; of indirect light it takes no more than `most_indirect` at a time.
    pub fn new(path: &PathSample, most_indirect: f32) -> Self {
        let throughput = SampledSpectrum::ONE;
        let (ray, lambda) = (path.ray, path.lambda);
        Self {
            ray,
            throughput,
            lambda,
            chosen: None,
            departure: None,
            guided: 1.0,
            most_indirect,
            scattered: 0,
            travelled: Travelled::default(),
        }
    }

    /// A direction of `vertex` by what was learned at `place`, or, as often as that says, by the material; `choice` and `u`: as for
    /// [`bhs_core::material::Material::sample`].
    pub fn guide(&mut self, place: &GuidedHemisphere, vertex: &Vertex, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let (material, shading, share) = (vertex.material, &vertex.shading, place.share());
        if choice >= share {
            let choice = ((choice - share) / (1.0 - share)).min(ONE_MINUS_EPSILON);
            let sample = material.sample(shading, vertex.wo, choice, u)?;
            if sample.specular {
                return Some(BsdfSample { weight: sample.weight * (1.0 / (1.0 - share)), ..sample });
            }
            let pdf = place.pdf(vertex, sample.wi);
            return (pdf > 0.0).then(|| BsdfSample { weight: sample.weight * (sample.pdf / pdf), pdf, ..sample });
        }
        let drawn = place.sample(u);
        let wi = drawn.wi;
        let pdf = place.pdf(vertex, wi);
        // At grazing angles one of the two cosines can be zero.
        if pdf <= 0.0 || wi.z * vertex.wo.z <= 0.0 {
            return None;
        }
        let weight = material.evaluate(shading, vertex.wo, wi) / pdf;
        self.guided *= if share == 1.0 { drawn.density.max(1.0) } else { (pdf / material.pdf(shading, vertex.wo, wi)).max(1.0) };
        Some(BsdfSample { wi, weight, pdf, specular: false, drops_wavelengths: false, eta: 1.0 })
    }

    /// The weight of the emission that it has found at `vertex` on its way from a rough surface over specular ones.
    pub fn weight_of_caustic(&self, scene: &Scene, caustics: Option<&Caustics>, vertex: &Vertex) -> f32 {
        match (caustics, self.departure, &self.chosen) {
            (Some(caustics), Some(departure), None) => caustics.weight(scene, departure, vertex, &self.lambda),
            _ => 1.0,
        }
    }

    /// The light of the sky that it has found in the direction `sky.0` on the side `sky.1` on such a way, weighted likewise.
    pub fn sky_of_caustic(
        &self,
        scene: &Scene,
        caustics: &Caustics,
        departure: Departure,
        sky: (DVec3, Side),
    ) -> SampledSpectrum {
        let weight = |index, pdf| caustics.sky_weight(scene, departure, (index, pdf), &self.lambda);
        scene.light_sampler.sky_weighted(sky, &self.lambda, weight)
    }

    /// Most that light may be, in the mean over its wavelengths, which is found after it was scattered by so many surfaces that show no others.
    pub fn most(&self, scattered: u32) -> f32 {
        if scattered > 1 { self.most_indirect } else { f32::INFINITY }
    }
}

/// `light`, or as much of it that its mean over the wavelengths is `most`.
#[inline]
pub fn clamped(light: SampledSpectrum, most: f32) -> SampledSpectrum {
    let mean = light.mean();
    if mean > most { light * (most / mean) } else { light }
}
