//! Caustics: light that has come to a rough surface over mirrors and through glass.
//!
//! Such light is found by chance only where it is followed back. So it is followed forwards too: photons leave the lights, towards surfaces that are
//! specular, and where they land on rough ones they count for all paths that come by within a small disc (photon mapping; Jensen 1996). Paths
//! whose own directions find the light over the same surfaces are weighted against that, as in vertex merging (Georgiev et al. 2012, Hachisuka et
//! al. 2012): with the density `p` of a direction per solid angle, and `N` photons of the density `d` per étendue, a disc of the area `A` would
//! have brought `N d A |cos theta|` photons per solid angle (Liouville's theorem; [`source`]), and the weights of the two techniques are as `p` to
//! that. Nothing is found that neither could find, and nothing twice, whatever bends the light in between.
//!
//! The disc is as wide as the light is dense there where caustics are, and about a pixel at least: a focus has many photons, and what is around it few. It gets smaller from wave to wave: its radius goes with the number of samples to the
//! power of -1/6, so that error by noise and error by blur fall together (Knaus and Zwicker 2011). Pictures are not unbiased, but consistent.
//!
//! Each wave of samples has photons of its own, as many for each of its samples; they are a function of seed, scene and wave alone. Those that are
//! sent before the first wave learn where in the light specular surfaces are that throw it to places which the picture sees, how wide discs are, and whether
//! there are caustics at all.

mod aim;
mod follow;
mod photon_map;
mod seen;
mod source;
mod spectrum;

use bhs_core::geometry::Aabb;
use bhs_core::observer::Observer;
use bhs_core::sampling::{Discrete, balance_heuristic};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use bhs_elementary::Elementary;
use bhs_engine::scene::{Scene, Vertex};
use bhs_engine::transport::RenderSetting;
use follow::{Landed, Tracer};
use glam::{DVec3, Vec3};
use photon_map::{Photon, PhotonMap};
use seen::Seen;
use source::{PhotonSource, mean};
use spectrum::Range;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;
use std::ops::Range as Numbers;
use std::sync::Arc;

/// Pixels of the picture for each photon of a sample.
const PIXELS_PER_PHOTON: u64 = 8;
/// Least and greatest number of photons for each sample of all pixels.
const PHOTONS: [u64; 2] = [256, 1 << 16];
/// By how much the photons of a sample are fewer at most in waves of adaptive sampling.
const FEWER: u64 = 4;
/// Greatest number of photons of a wave: those that land take about 250 bytes each while they are sorted. As many as the longest wave has in the largest picture.
const MOST: u64 = 1 << 21;
/// Photons that are sent before the first wave, in units of those of a sample; and how many at least and at most.
const SCOUTS: u64 = 4;
const SCOUT_RANGE: [u64; 2] = [1 << 13, 1 << 16];
/// Photons of one sample of all pixels within the disc around one that has landed, in the median.
const NEIGHBOURS: f64 = 1.0;
/// Photons whose neighbours are counted to find that out.
const ASKED: usize = 256;
/// Discs are larger (scene units): squares of distances within are single precision's, also after a billion samples.
const SMALLEST: f64 = 1e-16;
/// The stage of the first scouts; the second ones have that before: no wave begins with either.
const FIRST_SCOUTS: u32 = u32::MAX;
/// Light of one wavelength counts for others that are nearer than half of this (nm).
const BAND_NM: f32 = 10.0;
/// Cosine of the angle up to which surfaces that a disc reaches are one.
const SAME_SURFACE: f32 = 0.7;

/// How a path left its last rough surface, to be weighted against photons that land there.
#[derive(Clone, Copy)]
pub struct Departure {
    /// Density of its direction, per solid angle and area of the surface across it (chart): what photons have in `N d A`.
    density: f64,
    /// Whether its colours have parted since.
    is_single: bool,
}

impl Departure {
    /// That from `vertex` in the looked direction `looked`, which has the density `pdf` per local solid angle.
    pub fn new(vertex: &Vertex, looked: DVec3, pdf: f32) -> Self {
        Self { density: f64::from(pdf) / across(&vertex.observer, vertex.normal, looked), is_single: false }
    }

    /// The same after a surface at which colours part if `drops_wavelengths` says so.
    pub fn further(self, drops_wavelengths: bool) -> Self {
        Self { is_single: self.is_single || drops_wavelengths, ..self }
    }
}

/// Area across light of the looked direction `looked`, as the observer measures it, per chart area of a surface with the given chart normal.
fn across(observer: &Observer, normal: DVec3, looked: DVec3) -> f64 {
    looked.dot(normal).abs() * observer.bundle_area_factor(looked)
}

/// What a surface does with light of any direction.
enum Scattered {
    /// As Lambert's law says: the light that it scatters of what comes in at right angles.
    Matt(SampledSpectrum),
    Other,
}

impl Scattered {
    fn at(vertex: &Vertex) -> Self {
        if !vertex.material.is_matt() {
            return Self::Other;
        }
        let across = Vec3::Z * vertex.wo.z.signum();
        Self::Matt(vertex.material.evaluate(&vertex.shading, vertex.wo, across))
    }

    /// The BSDF times the cosine, and the density, of `wi`.
    #[inline]
    fn into(&self, vertex: &Vertex, wi: Vec3) -> (SampledSpectrum, f32) {
        match self {
            Self::Matt(across) if wi.z * vertex.wo.z > 0.0 => (*across * wi.z.abs(), wi.z.abs() * FRAC_1_PI),
            Self::Matt(_) => (SampledSpectrum::ZERO, 0.0),
            Self::Other => {
                let Vertex { material, shading, wo, .. } = vertex;
                (material.evaluate(shading, *wo, wi), material.pdf(shading, *wo, wi))
            }
        }
    }
}

/// The caustics of a scene, in one render.
pub struct Caustics {
    source: PhotonSource,
    range: Range,
    most_bounces: u32,
    /// Radius of the disc after one sample (scene units).
    radius: f64,
    /// Photons for each sample of all pixels.
    per_sample: u64,
    /// The photons of the wave.
    photons: PhotonMap,
    /// How many were sent.
    sent: f64,
}

impl Caustics {
    /// Those of a render whose paths have up to `max_depth` bounces; `None` if it has none.
    pub fn new(setting: &RenderSetting, max_depth: u32) -> Option<Self> {
        let &RenderSetting { scene, pixels, lambda_range: [lo, hi], .. } = setting;
        let is_specular = |geometry: &usize| scene.shapes[*geometry].material.chooses_directions();
        let bounds = (0..scene.world.geometries.len()).filter(is_specular).map(|g| scene.world.geometries[g].bounds());
        let specular = bounds.fold(Aabb::EMPTY, Aabb::union);
        if specular.is_empty() || max_depth < 2 || !scene.is_followed_forwards() {
            return None;
        }
        let range = Range { lo, hi };
        let source = PhotonSource::new(scene, range, specular);
        let per_sample = (pixels / PIXELS_PER_PHOTON).clamp(PHOTONS[0], PHOTONS[1]);
        let photons = PhotonMap::new(&[], 1.0);
        Self { source, range, most_bounces: max_depth - 1, radius: 0.0, per_sample, photons, sent: 0.0 }.scout(setting)
    }

    /// Sends the first photons and learns from them; whether there are caustics.
    fn scout(mut self, setting: &RenderSetting) -> Option<Self> {
        let scouts = (self.per_sample * SCOUTS).clamp(SCOUT_RANGE[0], SCOUT_RANGE[1]) as u32;
        let mut seen: Option<Seen> = None;
        let mut landed: Vec<Landed> = Vec::new();
        let mut counts: Vec<f64> = Vec::new();
        for stage in 0..2 {
            if !self.source.can_emit() {
                return None;
            }
            landed = self.tracer(setting).follow(FIRST_SCOUTS - stage, 0..scouts);
            if landed.is_empty() {
                return None;
            }
            // Asked where there is something to be seen.
            let seen = seen.get_or_insert_with(|| Seen::new(setting));
            counts = landed.iter().map(|l| mean(&l.photon.flux) * seen.weight(l.photon.point.as_dvec3())).collect();
            let brought: Vec<_> = landed.iter().zip(&counts).map(|(l, count)| (l.light, l.cell, *count)).collect();
            self.source = self.source.learn(setting.scene, &brought);
        }
        let neighbours = NEIGHBOURS * f64::from(scouts) / self.per_sample as f64;
        let photons: Vec<Photon> = landed.into_iter().map(|l| l.photon).collect();
        let [least, most] = seen?.radii(setting.pixels);
        let radius = radius_of(&photons, &counts, neighbours.round().max(1.0) as usize)?.max(least).min(most);
        (radius > SMALLEST).then_some(Self { radius, ..self })
    }

    fn tracer<'a>(&'a self, setting: &RenderSetting<'a>) -> Tracer<'a> {
        let &RenderSetting { scene, sampler, .. } = setting;
        let (source, is_stopped) = (&self.source, Arc::clone(&setting.is_stopped));
        Tracer { scene, source, range: self.range, sampler, most_bounces: self.most_bounces, is_stopped }
    }

    /// Makes the photons of the samples with these numbers.
    pub fn begin_wave(&mut self, setting: &RenderSetting, samples: Numbers<u32>) {
        // Where few pixels take part, as many photons as for all of them would be most of the time.
        let per_sample = (setting.pixels / PIXELS_PER_PHOTON).clamp(self.per_sample.div_ceil(FEWER), self.per_sample);
        let sent = (per_sample * samples.len() as u64).min(MOST);
        // Those of the wave before are not held besides.
        self.photons = PhotonMap::new(&[], 1.0);
        let landed = self.tracer(setting).follow(samples.start, 0..sent as u32);
        let share = 1.0 / sent as f32;
        let photons: Vec<Photon> =
            landed.into_iter().map(|Landed { photon, .. }| Photon { flux: photon.flux.map(|f| f * share), ..photon }).collect();
        self.photons = PhotonMap::new(&photons, self.radius * f64::from(samples.end).power(-1.0 / 6.0));
        self.sent = sent as f64;
    }

    /// What photons near `vertex` bring to a path of the wavelengths `lambda` at E = 1, which may meet so many specular surfaces more.
    pub fn gather(&self, scene: &Scene, vertex: &Vertex, lambda: &SampledWavelengths, most_bounces: u32) -> SampledSpectrum {
        let mut sum = SampledSpectrum::ZERO;
        let normal = vertex.normal.as_vec3();
        let scattered = Scattered::at(vertex);
        self.photons.near(vertex.hit.point, |photon| {
            if photon.bounces <= most_bounces && photon.normal.dot(normal).abs() > SAME_SURFACE {
                sum += self.brought(scene, (vertex, &scattered), lambda, photon);
            }
        });
        sum
    }

    /// What one photon brings.
    fn brought(
        &self,
        scene: &Scene,
        (vertex, scattered): (&Vertex, &Scattered),
        lambda: &SampledWavelengths,
        photon: &Photon,
    ) -> SampledSpectrum {
        let looked = photon.looked.as_dvec3();
        let wi = vertex.shading_direction(looked);
        if !vertex.is_consistent(wi) {
            return SampledSpectrum::ZERO;
        }
        let (scattered, pdf) = scattered.into(vertex, wi);
        let across = across(&vertex.observer, vertex.normal, looked);
        if scattered.is_zero() || across <= 0.0 {
            return SampledSpectrum::ZERO;
        }
        let shift = vertex.shift(looked);
        let left_as = lambda.at((shift.unwrap_or(1.0) / f64::from(photon.scale)) as f32);
        if !self.range.has(left_as) {
            return SampledSpectrum::ZERO;
        }
        let light = match photon.is_single {
            false => self.range.interpolate(photon.first, &photon.flux, left_as),
            true => self.single(photon, left_as),
        };
        if light.is_zero() {
            return SampledSpectrum::ZERO;
        }
        let here = f64::from(pdf) / across;
        let weight = 1.0 - self.weight_against_photons(here, photon.density.into(), photon.is_single);
        let factor = shift.map_or(1.0, |shift| scene.radiance_factor(shift));
        scattered * light * (f64::from(factor * weight) / (self.disc() * across)) as f32
    }

    /// The light of a photon of one wavelength at others.
    fn single(&self, photon: &Photon, left_as: [f32; N_LAMBDA]) -> SampledSpectrum {
        let lambda = self.range.lambda(photon.first, 0);
        let light = photon.flux[0] * (self.range.hi - self.range.lo) / BAND_NM;
        SampledSpectrum(left_as.map(|l| if (l - lambda).abs() < 0.5 * BAND_NM { light } else { 0.0 }))
    }

    /// Area of the disc (chart).
    fn disc(&self) -> f64 {
        PI * self.photons.radius() * self.photons.radius()
    }

    /// The weight of a direction of the density `direction` (of [`Departure`]) against photons that left with the density `light`.
    fn weight_against_photons(&self, direction: f64, light: f64, is_single: bool) -> f32 {
        let band = if is_single { f64::from(BAND_NM / (self.range.hi - self.range.lo)) } else { 1.0 };
        let photons = self.sent * light * self.disc() * band;
        if photons > 0.0 { balance_heuristic(direction as f32, photons as f32) } else { 1.0 }
    }

    /// The weight of the emission that a path of the wavelengths `lambda` has found at `vertex` since its departure.
    pub fn weight(&self, scene: &Scene, departure: Departure, vertex: &Vertex, lambda: &SampledWavelengths) -> f32 {
        if !self.range.has(lambda.lambda_nm) {
            return 1.0;
        }
        let light = self.source.density(scene, vertex);
        self.weight_against_photons(departure.density, light, departure.is_single)
    }

    /// The same of light of the sky, of the light `index` that light sampling draws with the density `pdf`.
    pub fn sky_weight(
        &self,
        scene: &Scene,
        departure: Departure,
        (index, pdf): (usize, f64),
        lambda: &SampledWavelengths,
    ) -> f32 {
        if !self.range.has(lambda.lambda_nm) {
            return 1.0;
        }
        let light = self.source.sky_density(scene, index, pdf);
        self.weight_against_photons(departure.density, light, departure.is_single)
    }
}

/// The distance within which one of `photons` has so many neighbours, in the median of what `counts` says of them (scene units); `None` if nothing counts.
fn radius_of(photons: &[Photon], counts: &[f64], neighbours: usize) -> Option<f64> {
    let by_count = Discrete::new(counts.iter().copied());
    let mut distances: Vec<f32> = (0..ASKED)
        .filter_map(|i| Some(photons[by_count.sample((i as f32 + 0.5) / ASKED as f32)?.0]))
        .filter_map(|at| {
            let near = |p: &&Photon| p.normal.dot(at.normal).abs() > SAME_SURFACE;
            let mut others: Vec<f32> = photons.iter().filter(near).map(|p| p.point.distance_squared(at.point)).collect();
            (others.len() > neighbours).then(|| *others.select_nth_unstable_by(neighbours, f32::total_cmp).1)
        })
        .collect();
    distances.sort_by(f32::total_cmp);
    let median = f64::from(*distances.get(distances.len() / 2)?).sqrt();
    (median > 0.0).then_some(median)
}
