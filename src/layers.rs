//! The values of a picture's layers: a camera ray is followed once more, apart from what the light transport does with it.
//!
//! Transports know nothing of it, and a picture without layers pays nothing for it. Where nothing bends light (no hole, or an
//! integrator of straight rays) the lengths and angles of the orbit are 0, and `g` is 1.

mod picture;

pub use picture::LayerPicture;

use bhs_core::blackhole::BlackHole;
use bhs_core::camera::Film;
use bhs_core::integrator::{Arrival, Ray, SurfaceHit};
use bhs_core::layer::Layer;
use bhs_core::material::Shading;
use bhs_core::scene::{Scene, Vertex};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use bhs_core::stats::TraceLog;
use glam::DVec3;
use std::f64::consts::TAU;

/// A layer's value for one ray; a layer of one channel uses the first number.
pub type Value = [f64; 3];

/// Computes the layers that a film asks for.
pub struct LayerCollector<'a> {
    scene: &'a Scene,
    layers: &'a [Layer],
    albedo: AlbedoColor<'a>,
}

impl<'a> LayerCollector<'a> {
    /// A collector of the film's layers; `None` if it asks for none.
    pub fn new(scene: &'a Scene, film: &'a dyn Film) -> Option<Self> {
        let layers = film.layers();
        let of_rays = layers.iter().any(|l| *l != Layer::Variance);
        of_rays.then(|| Self { scene, layers, albedo: AlbedoColor::new(film) })
    }

    /// The values of all layers, in the film's order, for a camera ray; `None` for what this ray has no value of.
    /// `camera_ratio`: wavelength where the ray starts over that at E = 1, as the camera measures it.
    pub fn values(&self, ray: &Ray, camera_ratio: f64) -> impl Iterator<Item = Option<Value>> {
        // A log of its own: the render's counts are those of the picture.
        let mut log = TraceLog::default();
        let arrival = self.scene.integrator.trace(&self.scene.world, ray, &mut log);
        let queries = log.counters.queries;
        let seen = Seen { scene: self.scene, ray: *ray, camera_ratio, arrival, phi: log.phi, queries };
        self.layers.iter().map(move |layer| seen.value(*layer, &self.albedo))
    }
}

/// A camera ray that has been followed.
struct Seen<'s> {
    scene: &'s Scene,
    ray: Ray,
    camera_ratio: f64,
    arrival: Arrival,
    phi: f64,
    queries: u64,
}

impl Seen<'_> {
    fn value(&self, layer: Layer, albedo: &AlbedoColor) -> Option<Value> {
        match layer {
            Layer::ImpactParameter if self.bends_otherwise() => None,
            Layer::ImpactParameter => Some(scalar(self.hole().map_or(0.0, |h| self.impact_parameter(h)))),
            Layer::SweptAngle => self.swept_angle().map(scalar),
            Layer::Winding => self.swept_angle().map(|phi| scalar(phi / TAU)),
            Layer::ClosestApproach => self.closest_approach().map(scalar),
            Layer::Redshift => self.redshift().map(scalar),
            Layer::Queries => Some(scalar(self.queries as f64)),
            Layer::Outcome => match self.arrival {
                Arrival::Surface(_) => Some([1.0, 0.0, 0.0]),
                Arrival::Sky(..) => Some([0.0, 1.0, 0.0]),
                Arrival::Hole => Some([0.0, 0.0, 1.0]),
                Arrival::OutOfSteps => None,
            },
            Layer::Albedo => self.vertex(&albedo.wavelengths[0]).map(|v| albedo.of(&v, v.ratio / self.camera_ratio)),
            Layer::Position => self.hit().map(|h| (h.point + self.scene.world.origin).to_array()),
            Layer::Normal => self.hit().map(|h| self.scene.world.surface(h).normal.to_array()),
            // No straight line of a chart leads to the other side.
            Layer::Depth => self
                .hit()
                .filter(|h| self.scene.world.side_of(h.geometry) == self.ray.side)
                .map(|h| scalar((h.point - self.ray.origin).length())),
            Layer::Side => match self.arrival {
                Arrival::Surface(hit) => Some(scalar(f64::from(self.scene.world.side_of(hit.geometry) as u8))),
                Arrival::Sky(_, side) => Some(scalar(f64::from(side as u8))),
                Arrival::Hole | Arrival::OutOfSteps => None,
            },
            // What samples find is no matter of the ray.
            Layer::Variance => None,
            Layer::ShadingNormal => self.hit().map(|h| self.scene.world.surface(h).shading_normal.to_array()),
        }
    }

    fn hit(&self) -> Option<&SurfaceHit> {
        match &self.arrival {
            Arrival::Surface(hit) => Some(hit),
            _ => None,
        }
    }

    fn vertex(&self, lambda: &SampledWavelengths) -> Option<Vertex<'_>> {
        self.scene.vertex(*self.hit()?, lambda)
    }

    /// The hole, where it bends light.
    fn hole(&self) -> Option<&BlackHole> {
        self.scene.world.hole.as_ref().filter(|h| h.rs > 0.0 && self.scene.integrator.is_curved())
    }

    /// Whether something else bends light than a plain hole, around which all orbits are plane.
    fn bends_otherwise(&self) -> bool {
        self.scene.world.spacetime.is_some() && self.scene.integrator.is_curved()
    }

    /// Angle swept around the hole (rad).
    fn swept_angle(&self) -> Option<f64> {
        match (self.hole(), self.arrival) {
            _ if self.bends_otherwise() => None,
            (None, _) => Some(0.0),
            (Some(_), Arrival::OutOfSteps) => None,
            (Some(_), _) => Some(self.phi),
        }
    }

    /// `b = r sin(alpha) / sqrt(1 - (rs/r) sin^2(alpha))` with the chart angle alpha to the radial direction (scene units): the
    /// orbit's first integral `u'^2 = 1/b^2 - u^2 + rs u^3` with `u' = -cot(alpha)/r`.
    fn impact_parameter(&self, hole: &BlackHole) -> f64 {
        let from_center = self.ray.origin - hole.center;
        let r = from_center.length();
        let sin = from_center.cross(self.ray.direction).length() / r;
        r * sin / (1.0 - hole.rs / r * sin * sin).sqrt()
    }

    /// Smallest distance from the hole's centre on the way (scene units): the periapsis if the ray has passed it, else the
    /// nearer end; the horizon for a ray that falls in.
    fn closest_approach(&self) -> Option<f64> {
        if self.bends_otherwise() {
            return None;
        }
        let Some(hole) = self.hole() else { return Some(0.0) };
        let outward = |point: DVec3, direction: DVec3| (point - hole.center).dot(direction) > 0.0;
        let start = (self.ray.origin - hole.center).length();
        let (end, leaves) = match self.arrival {
            Arrival::Surface(h) => ((h.point - hole.center).length(), outward(h.point, h.direction)),
            Arrival::Sky(..) => (f64::INFINITY, true),
            Arrival::Hole => return Some(hole.rs),
            Arrival::OutOfSteps => return None,
        };
        if leaves && !outward(self.ray.origin, self.ray.direction) {
            let (b, critical) = (self.impact_parameter(hole), hole.critical_impact_parameter());
            // The largest root of r^3 - b^2 r + b^2 rs (Viete); a ray that turns has one, but for rounding near the critical one.
            return Some(2.0 * b / 3f64.sqrt() * ((-critical / b).max(-1.0).acos() / 3.0).cos());
        }
        Some(start.min(end))
    }

    /// `g = nu_observed / nu_emitted`: the clock rate where the light comes from over that at the camera.
    fn redshift(&self) -> Option<f64> {
        let emitted = match self.arrival {
            Arrival::Surface(hit) => self.scene.observer(self.scene.world.place_of(&hit))?.ratio(hit.direction),
            Arrival::Sky(..) => 1.0,
            Arrival::Hole | Arrival::OutOfSteps => return None,
        };
        Some(emitted / self.camera_ratio)
    }
}

fn scalar(x: f64) -> Value {
    [x, 0.0, 0.0]
}

/// Sets of wavelengths that stand for the film's range.
const WAVELENGTH_SETS: usize = 8;

/// Turns reflectances into the film's colours, the same way for every ray: no noise of wavelengths in it.
struct AlbedoColor<'f> {
    film: &'f dyn Film,
    wavelengths: [SampledWavelengths; WAVELENGTH_SETS],
    /// What reflectance 1 adds up to.
    white: Value,
}

impl<'f> AlbedoColor<'f> {
    fn new(film: &'f dyn Film) -> Self {
        let [lo, hi] = film.lambda_range();
        let set = |i| SampledWavelengths::visible((i as f32 + 0.5) / (WAVELENGTH_SETS * N_LAMBDA) as f32, lo, hi);
        let mut color = Self { film, wavelengths: std::array::from_fn(set), white: [1.0; 3] };
        color.white = color.sum(|_| SampledSpectrum::ONE);
        color
    }

    /// The colour under D65 of what reflects as `reflectance` says at the camera's wavelengths (nm).
    fn sum(&self, reflectance: impl Fn(&SampledWavelengths) -> SampledSpectrum) -> Value {
        let mut sums = [0.0; 3];
        for lambda in &self.wavelengths {
            self.film.add(reflectance(lambda) * bhs_spectra::d65().sample(lambda.lambda_nm), lambda, &mut sums);
        }
        sums
    }

    /// The albedo of a surface as its light arrives: reflectance at the wavelengths there, `shift` times those that are seen.
    fn of(&self, vertex: &Vertex, shift: f64) -> Value {
        let sum = self.sum(|lambda| {
            let at = Shading { lambda_nm: lambda.at(shift as f32), ..vertex.shading };
            vertex.material.reflectance(&at, vertex.wo)
        });
        std::array::from_fn(|c| sum[c] / self.white[c])
    }
}
