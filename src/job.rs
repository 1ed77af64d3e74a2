//! What a render needs, and the rays of its camera.

use crate::adaptive::NoiseGoal;
use crate::lang::BuiltScene;
use bhs_core::camera::{Camera, Film, Filter, Viewpoint};
use bhs_core::ray::Ray;
use bhs_core::sampling::Sampler;
use bhs_engine::layer::NamedLayer;
use bhs_engine::scene::Scene;
use bhs_engine::transport::{LightTransport, RenderSetting};
use glam::{DVec2, Vec2};
use std::sync::Arc;

/// Rows and columns of camera rays that are asked how they shift wavelengths.
const SHIFTS: u32 = 9;

/// Everything that a render needs.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where it is seen from.
    pub camera: &'a dyn Camera,
    /// How that stands there.
    pub viewpoint: &'a Viewpoint,
    /// What records it.
    pub film: &'a dyn Film,
    /// What it records besides colour.
    pub layers: &'a [NamedLayer],
    /// Where samples of a pixel go.
    pub filter: &'a dyn Filter,
    /// Random numbers.
    pub sampler: &'a dyn Sampler,
    /// The method.
    pub transport: &'a dyn LightTransport,
    /// When a pixel has samples enough, if not all get as many.
    pub noise: Option<NoiseGoal>,
    /// The first sample of each pixel: not 0 in parts of pictures.
    pub first_sample: u32,
}

impl<'a> Job<'a> {
    /// The render that a built scene describes.
    pub fn of(built: &'a BuiltScene) -> Self {
        Self {
            scene: &built.scene,
            camera: &*built.camera,
            viewpoint: &built.viewpoint,
            film: &*built.film,
            layers: &built.layers,
            filter: &*built.filter,
            sampler: &*built.sampler,
            transport: &*built.transport,
            noise: built.sampler.noise_target().map(|target| NoiseGoal { target, look: built.look }),
            first_sample: 0,
        }
    }
}

impl<'a> Job<'a> {
    /// What its light transport may know before the first sample.
    pub fn setting(&self) -> RenderSetting<'a> {
        let [width, height] = self.film.resolution();
        let [lo, hi] = self.film.lambda_range();
        // Wavelengths at E = 1 are those of the camera over its ratio, which depends on the direction where it moves.
        let points =
            (0..SHIFTS * SHIFTS).map(|i| DVec2::new(f64::from(i % SHIFTS), f64::from(i / SHIFTS)) / f64::from(SHIFTS - 1));
        let size = DVec2::new(f64::from(width), f64::from(height));
        let ratios = points.filter_map(|p| self.camera_ray(p * size, Vec2::splat(0.5)).1);
        let [least, most] = ratios.fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], r| [least.min(r), most.max(r)]);
        let [least, most] = if most > 0.0 { [least, most] } else { [1.0, 1.0] };
        let lambda_range = [(f64::from(lo) / most) as f32, (f64::from(hi) / least) as f32];
        let job = *self;
        RenderSetting {
            scene: self.scene,
            sampler: self.sampler,
            lambda_range,
            resolution: [width, height],
            pixels: u64::from(width) * u64::from(height),
            camera_ray: Arc::new(move |film, lens| job.camera_ray(film.as_dvec2() * size, lens).0),
            is_stopped: Arc::new(|| false),
        }
    }

    /// The ray along which the camera sees the point `raster` of its picture (pixels) through the point `lens` of its lens ([0,1)^2), and the
    /// wavelength of its light there over that at E = 1: see [`bhs_engine::scene::Scene::camera_ray`]. All camera rays are made here.
    #[inline]
    pub fn camera_ray(&self, raster: DVec2, lens: Vec2) -> (Ray, Option<f64>) {
        self.scene.camera_ray(&self.camera.ray(raster, lens), self.viewpoint)
    }
}
