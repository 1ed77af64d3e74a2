//! A built scene as light transport sees it: vertices with their observers (for lights to sample: `light_sampling.rs`).

use crate::camera::{CameraRay, Viewpoint};
use crate::geometry::SurfaceGeometry;
use crate::integrator::{Integrator, Ray, SurfaceHit};
use crate::light::{Emission, Light};
use crate::light_sampling::Emitter;
use crate::material::{Material, Shading};
use crate::observer::Observer;
use crate::sampling::Discrete;
use crate::spacetime::{Place, Side};
use crate::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use crate::world::World;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// What a geometry is made of.
#[derive(Clone)]
pub struct ShapeBinding {
    /// Its material.
    pub material: Arc<dyn Material>,
    /// Index of its emission in [`Scene::emitters`].
    pub emitter: Option<u32>,
    /// Number of the `Shape` directive in the scene, counted from 0.
    pub index: u32,
}

/// Everything that light transport needs.
pub struct Scene {
    /// Geometry, intersector and hole.
    pub world: World,
    /// How light travels.
    pub integrator: Box<dyn Integrator>,
    /// What each geometry is made of, by geometry index.
    pub shapes: Vec<ShapeBinding>,
    /// The surfaces that emit.
    pub emitters: Vec<Emitter>,
    /// Lights that are not surfaces.
    pub lights: Vec<Arc<dyn Light>>,
    /// The side of a wormhole that each of `lights` is on.
    pub light_sides: Vec<Side>,
    /// Choice by power of what light sampling aims at: first the emitters, then all of `lights` (whose power is 0 if they are left to
    /// chance).
    pub light_choice: Discrete,
    /// How finely rays are told from their neighbours.
    pub footprints: Footprints,
}

/// Footprints of rays (scene units): see [`Ray::footprint`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprints {
    /// Of camera rays, and of what they become in mirrors and glass: one pixel, at the scene's distance from the camera.
    pub camera: f64,
    /// Of rays that leave a rough surface, where every picture is a mean over many directions.
    pub rough: f64,
}

/// Footprint of rays that leave a rough surface, relative to the diagonal of the box around all surfaces. A lamp that is found by
/// chance loses a strip of a tenth of it along one edge; where that was 1e-2, rooms lit so were 0.2 % too dark (docs/accuracy.md).
const ROUGH_FOOTPRINT: f64 = 1e-3;

impl Footprints {
    /// Footprints in a scene of the given diagonal (scene units), the middle of which is `distance` from a camera; `pixel_width` is
    /// [`crate::camera::Camera::pixel_width`]. A camera within the scene sees it from half the diagonal.
    pub fn new(diagonal: f64, distance: f64, pixel_width: impl Fn(f64) -> f64) -> Self {
        Self { camera: pixel_width(distance.max(0.5 * diagonal)), rough: ROUGH_FOOTPRINT * diagonal }
    }
}

/// A surface point on a path, with the observer who measures there.
pub struct Vertex<'s> {
    /// Where the path arrived.
    pub hit: SurfaceHit,
    /// Outer unit normal of the surface itself, chart.
    pub normal: DVec3,
    /// Who measures here.
    pub observer: Observer,
    /// Wavelength here over wavelength at E = 1, of the light that goes back along the path.
    pub ratio: f64,
    /// Radiance at E = 1 over radiance here, of that light.
    pub radiance_factor: f32,
    /// What the material may know.
    pub shading: Shading,
    /// The material.
    pub material: &'s dyn Material,
    /// The emission of the surface, if any.
    pub emitter: Option<&'s Emitter>,
    /// Unit direction back along the path, in the shading frame.
    pub wo: Vec3,
    /// Outer unit normal of the surface itself, in the shading frame.
    pub wn: Vec3,
    axes: [DVec3; 3],
    /// See [`World::step_off`].
    step_off: f64,
}

impl Vertex<'_> {
    /// The unit chart direction of a direction in the shading frame.
    #[inline]
    pub fn chart_direction(&self, w: Vec3) -> DVec3 {
        let w = w.as_dvec3();
        let local = self.axes[0] * w.x + self.axes[1] * w.y + self.axes[2] * w.z;
        self.observer.chart_direction(local)
    }

    /// The axes of the shading frame, as the observer measures them.
    #[inline]
    pub fn axes(&self) -> [DVec3; 3] {
        self.axes
    }

    /// The direction in the shading frame of a unit chart direction.
    #[inline]
    pub fn shading_direction(&self, chart: DVec3) -> Vec3 {
        let local = self.observer.local_direction(chart);
        DVec3::from_array(self.axes.map(|a| a.dot(local))).as_vec3()
    }

    /// Whether the surface and its shading normal agree on which side of it `wi` lies, relative to `wo`. Where they do not,
    /// light would leak through the surface.
    #[inline]
    pub fn is_consistent(&self, wi: Vec3) -> bool {
        (self.wo.z * wi.z > 0.0) == (self.wn.dot(self.wo) * self.wn.dot(wi) > 0.0)
    }

    /// The light that the surface itself sends back along the path, at E = 1.
    #[inline]
    pub fn emitted(&self) -> SampledSpectrum {
        match self.emitter {
            Some(emitter) => {
                let cos_theta = self.wn.dot(self.wo);
                let clock_rate = self.observer.clock_rate() as f32;
                let at = Emission { uv: self.shading.uv, cos_theta, lambda_nm: self.shading.lambda_nm, clock_rate };
                emitter.light.radiance(&at) * self.radiance_factor
            }
            None => SampledSpectrum::ZERO,
        }
    }

    /// The ray of the given footprint that leaves in the shading direction `wi`.
    pub fn spawn(&self, world: &World, wi: Vec3, footprint: f64) -> Ray {
        self.leave(world, self.chart_direction(wi), footprint)
    }

    /// The ray of the given footprint that leaves in the unit chart direction `direction`.
    #[inline]
    pub fn leave(&self, world: &World, direction: DVec3, footprint: f64) -> Ray {
        Ray { footprint, ..world.leave(&self.hit, self.normal, direction, self.step_off) }
    }
}

/// The direction back along the ray that arrives at `hit`, the normal and the shading normal there, as `observer` measures them.
#[inline]
fn view(observer: &Observer, hit: &SurfaceHit, surface: &SurfaceGeometry) -> [DVec3; 3] {
    let wo = -observer.local_direction(hit.direction);
    let ng = observer.local_normal(surface.normal);
    let ns = observer.local_normal(surface.shading_normal);
    // A shading normal that sees the viewer on the other side is of no use.
    [wo, ng, if ns.dot(wo) * ng.dot(wo) <= 0.0 { ng } else { ns }]
}

impl Scene {
    // Inlined, for a vertex is large: what is returned would be copied.
    /// The vertex at `hit` of a path with the wavelengths `lambda` at E = 1; `None` where there is no static observer.
    #[inline]
    pub fn vertex(&self, hit: SurfaceHit, lambda: &SampledWavelengths) -> Option<Vertex<'_>> {
        let observer = self.world.static_observer(self.world.place_of(&hit))?;
        let surface = self.world.surface(&hit);
        let binding = &self.shapes[hit.geometry as usize];
        let ratio = observer.ratio(hit.direction);

        let [wo, ng, ns] = view(&observer, &hit, &surface);
        let (s, t) = ns.any_orthonormal_pair();
        let axes = [s, t, ns];
        let to_shading = |v: DVec3| DVec3::from_array(axes.map(|a| a.dot(v))).as_vec3();
        Some(Vertex {
            hit,
            normal: surface.normal,
            observer,
            ratio,
            radiance_factor: self.radiance_factor(ratio),
            shading: Shading { uv: surface.uv, lambda_nm: lambda.at(ratio as f32) },
            material: &*binding.material,
            emitter: binding.emitter.map(|e| &self.emitters[e as usize]),
            wo: to_shading(wo),
            wn: to_shading(ng),
            axes,
            step_off: self.world.step_off(&hit),
        })
    }

    /// What [`Vertex::wo`] has along the shading normal, at a hit of which surface and observer are known.
    #[inline]
    pub fn cos_to_viewer(observer: &Observer, hit: &SurfaceHit, surface: &SurfaceGeometry) -> f32 {
        let [wo, _, ns] = view(observer, hit, surface);
        ns.dot(wo) as f32
    }

    /// Whether light bends in this scene.
    #[inline]
    pub fn bends(&self) -> bool {
        self.world.bends()
    }

    /// The static observer at `place` (render space); `None` where nothing can stand still.
    #[inline]
    pub fn observer(&self, place: Place) -> Option<Observer> {
        self.world.static_observer(place)
    }

    /// The ray along which an observer at `viewpoint` sees what `seen` shows, and the wavelength of its light there over that at E = 1; `None`, and
    /// the ray of flat space, where nothing can stand still.
    #[inline]
    pub fn camera_ray(&self, seen: &CameraRay, viewpoint: &Viewpoint) -> (Ray, Option<f64>) {
        let side = viewpoint.side;
        let mut observer = self.observer(Place { x: seen.origin, side });
        if let Some(motion) = &viewpoint.motion {
            observer = self.world.moving_observer(motion.as_ref(), Place { x: seen.origin, side }, observer);
        }
        let (direction, ratio) = match &observer {
            Some(observer) => {
                let direction = observer.chart_direction(seen.direction);
                (direction, Some(observer.ratio(direction)))
            }
            None => (Observer::FLAT.chart_direction(seen.direction), None),
        };
        (Ray { footprint: self.footprints.camera, side, ..Ray::new(seen.origin, direction) }, ratio)
    }

    /// Spectral radiance per wavelength at E = 1 over that where the wavelength is `ratio` times as long: `L lambda^5` is constant along a
    /// ray (Liouville; I_nu/nu^3 is invariant).
    #[inline]
    pub fn radiance_factor(&self, ratio: f64) -> f32 {
        if ratio == 1.0 || !self.world.conventions.radiance_shift { 1.0 } else { ratio.powi(5) as f32 }
    }

    /// The light from far away on the side `sky.1` along the chart direction `sky.0`, at the wavelengths `lambda` at E = 1.
    pub fn sky(&self, sky: (DVec3, Side), lambda: &SampledWavelengths) -> SampledSpectrum {
        self.sum_of_sky(sky.1, lambda, |_, light, lambda_nm| light.sky_radiance(sky.0, lambda_nm))
    }

    /// The same, each light that [`Scene::sample_light`] aims at multiplied by `weight` of the density with which it draws the direction
    /// (per solid angle far from the hole).
    pub fn sky_weighted(
        &self,
        (direction, side): (DVec3, Side),
        lambda: &SampledWavelengths,
        weight: impl Fn(f64) -> f32,
    ) -> SampledSpectrum {
        self.sum_of_sky(side, lambda, |i, light, lambda_nm| {
            let radiance = light.sky_radiance(direction, lambda_nm);
            let choice = self.light_choice.probability(self.emitters.len() + i);
            let pdf = if choice > 0.0 { choice * light.sky_pdf(direction) } else { 0.0 };
            if pdf > 0.0 { radiance * weight(pdf) } else { radiance }
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
        if self.lights.is_empty() {
            return sum;
        }
        for (i, light) in self.lights.iter().enumerate().filter(|(i, _)| self.light_sides[*i] == side) {
            sum += of(i, light.as_ref(), lambda.lambda_nm);
        }
        sum
    }
}
