//! Photons on their way: from a light over specular surfaces to rough ones.

use super::photon_map::Photon;
use super::source::{Emitted, PhotonSource, mean};
use super::spectrum::{COUNT, Range};
use arrayvec::ArrayVec;
use bhs_core::material::{BsdfSample, Shading};
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::sampling::{ONE_MINUS_EPSILON, SampleStream, Sampler};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use bhs_engine::scene::{Scene, Vertex};
use bhs_engine::transport::BATCH;
use glam::Vec2;
use rayon::prelude::*;
use std::ops::Range as Numbers;
use std::sync::Arc;

/// The first specular surface at which a photon may end by roulette.
const ROULETTE: u32 = 3;
/// Directions are the same that differ by no more than rounding.
const SAME: f32 = 1e-5;

/// A photon that has arrived, and what it comes of.
pub struct Landed {
    pub photon: Photon,
    /// The light, and the cell of its aim.
    pub light: usize,
    pub cell: usize,
}

/// What photons are followed with.
#[derive(Clone)]
pub struct Tracer<'a> {
    pub scene: &'a Scene,
    pub source: &'a PhotonSource,
    pub range: Range,
    pub sampler: &'a dyn Sampler,
    /// Specular surfaces that a photon meets at most.
    pub most_bounces: u32,
    /// [`RenderSetting::is_stopped`](bhs_engine::transport::RenderSetting::is_stopped).
    pub is_stopped: Arc<dyn Fn() -> bool + Send + Sync + 'a>,
}

/// A photon under way.
struct Flight<'a> {
    emitted: Emitted,
    stream: SampleStream<'a>,
    ray: Ray,
    /// [`Scene::etendue`] where the ray leaves.
    etendue: f64,
    flux: [f32; COUNT],
    /// Wavelength at E = 1 over that where it left the light.
    scale: f64,
    bounces: u32,
    is_single: bool,
}

impl<'a> Tracer<'a> {
    /// Draws the photons with these numbers and follows them: those that have landed, in the order of their numbers. `stage` tells them from those of
    /// other waves with the same numbers. Some of them if the render is to end.
    pub fn follow(&self, stage: u32, numbers: Numbers<u32>) -> Vec<Landed> {
        let batch = BATCH as u32;
        let batches = (numbers.len() as u32).div_ceil(batch);
        let landed: Vec<Vec<Landed>> = (0..batches)
            .into_par_iter()
            .take_any_while(|_| !(self.is_stopped)())
            .map(|b| {
                let start = numbers.start + b * batch;
                self.follow_batch(stage, start..(start + batch).min(numbers.end))
            })
            .collect();
        landed.into_iter().flatten().collect()
    }

    fn follow_batch(&self, stage: u32, numbers: Numbers<u32>) -> Vec<Landed> {
        let mut flights: ArrayVec<Flight, BATCH> = numbers
            .filter_map(|number| {
                let mut stream = SampleStream::new(self.sampler, [u32::MAX, stage], number);
                let emitted = self.source.emit(self.scene, &mut stream)?;
                let (ray, etendue, flux) = (emitted.ray, emitted.etendue, emitted.flux);
                Some(Flight { emitted, stream, ray, etendue, flux, scale: 1.0, bounces: 0, is_single: false })
            })
            .collect();
        let mut landed: Vec<(u32, Landed)> = Vec::new();
        let mut ends = [RayEnd::NONE; BATCH];
        let mut underway: ArrayVec<usize, BATCH> = (0..flights.len()).collect();
        while !underway.is_empty() {
            let rays: ArrayVec<Ray, BATCH> = underway.iter().map(|i| flights[*i].ray).collect();
            self.scene.integrator.trace_forwards(&self.scene.world, &rays, &mut ends[..rays.len()]);
            let going: ArrayVec<usize, BATCH> = underway
                .iter()
                .zip(&ends)
                .filter(|(i, end)| self.arrive(&mut flights[**i], end, |l| landed.push((**i as u32, l))))
                .map(|(i, _)| *i)
                .collect();
            underway = going;
        }
        landed.sort_by_key(|(i, _)| *i);
        landed.into_iter().map(|(_, landed)| landed).collect()
    }

    /// What a photon does at the end of its ray; whether it goes on.
    fn arrive(&self, flight: &mut Flight, end: &RayEnd, land: impl FnOnce(Landed)) -> bool {
        let Arrival::Surface(hit) = end.arrival else { return false };
        let lambda = |flight: &Flight, k: usize| {
            let lambda_nm = self.range.set(flight.emitted.first, k).map(|l| l * flight.scale as f32);
            SampledWavelengths { lambda_nm, pdf: [1.0; _] }
        };
        let Some(vertex) = self.scene.lit_vertex(&hit, &lambda(flight, 0)) else { return false };
        let place = self.scene.world.place_of(&vertex.hit);
        let looked = vertex.hit.direction;
        let carried = self.scene.etendue(place, &vertex.observer, looked) / flight.etendue;
        flight.flux = flight.flux.map(|f| (f64::from(f) * carried) as f32);
        if flight.bounces > 0 && !vertex.material.is_specular() {
            land(flight.landed(&vertex));
        }
        if flight.bounces >= self.most_bounces {
            return false;
        }
        let (choice, u) = (flight.stream.next_1d(), flight.stream.next_2d());
        let shading = |k| Shading { lambda_nm: lambda(flight, k).at(vertex.ratio as f32), ..vertex.shading };
        let Some(sample) = vertex.material.sample(&shading(0), vertex.wo, choice, u).filter(|s| s.specular) else { return false };
        if !vertex.is_consistent(sample.wi) {
            return false;
        }
        let weights = Range::of_sets(|k| match k {
            0 => sample.weight,
            _ => same_lobe(&vertex, &shading(k), (choice, u), &sample),
        });
        // Power and radiance are scattered alike but for the index, and for normals that are not the surface's own (Veach 1997, section 5.3.2).
        let ns = vertex.material.normal(&vertex.shading, vertex.wo);
        let adjoint = (vertex.wo.dot(ns) * sample.wi.dot(vertex.wn) / (vertex.wo.dot(vertex.wn) * sample.wi.dot(ns))).abs();
        let away = vertex.looked_from(sample.wi);
        let ratio = vertex.observer.ratio(away);
        let shift = ratio / vertex.ratio;
        let factor = sample.eta * sample.eta * adjoint * if shift == 1.0 { 1.0 } else { self.scene.radiance_factor(shift) };
        let before = mean(&flight.flux);
        flight.flux = std::array::from_fn(|j| flight.flux[j] * weights[j] * factor);
        flight.is_single |= sample.drops_wavelengths;
        flight.scale *= vertex.ratio / ratio;
        flight.bounces += 1;
        flight.ray = vertex.send(self.scene, away);
        flight.etendue = self.scene.etendue(place, &vertex.observer, away);
        let left = mean(&flight.flux);
        if !left.is_finite() || left <= 0.0 {
            return false;
        }
        if flight.bounces > ROULETTE {
            let survive = (left / before).min(1.0) as f32;
            if flight.stream.next_1d() >= survive {
                return false;
            }
            flight.flux = flight.flux.map(|f| f / survive);
        }
        true
    }
}

impl Flight<'_> {
    fn landed(&self, vertex: &Vertex) -> Landed {
        let Emitted { first, density, light, cell, .. } = self.emitted;
        let photon = Photon {
            point: vertex.hit.point.as_vec3(),
            looked: vertex.hit.direction.as_vec3(),
            normal: vertex.normal.as_vec3(),
            flux: self.flux,
            first,
            scale: self.scale as f32,
            density: density as f32,
            bounces: self.bounces,
            is_single: self.is_single,
        };
        Landed { photon, light, cell }
    }
}

/// The weights at other wavelengths of the direction that `chosen` has at those of the path: lobes may be chosen by wavelengths, but the light of a
/// lobe does not depend on that.
fn same_lobe(vertex: &Vertex, shading: &Shading, (choice, u): (f32, Vec2), chosen: &BsdfSample) -> SampledSpectrum {
    let lobes = [choice, 0.0, ONE_MINUS_EPSILON];
    let samples = lobes.into_iter().filter_map(|choice| vertex.material.sample(shading, vertex.wo, choice, u));
    let same = samples.into_iter().find(|s| s.specular && (s.wi - chosen.wi).abs().max_element() <= SAME);
    // Where colours part, the first wavelength alone goes on.
    same.map_or(chosen.weight, |s| s.weight * (s.pdf / chosen.pdf))
}
