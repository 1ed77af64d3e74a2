//! A built scene as light transport sees it: vertices with their observers, and lights to sample.

use crate::blackhole::Observer;
use crate::geometry::{Geometry, sample_triangle};
use crate::integrator::{Integrator, Ray, SurfaceHit};
use crate::light::{AreaLight, Light};
use crate::material::{Material, Shading};
use crate::sampling::Discrete;
use crate::spectrum::{SampledSpectrum, SampledWavelengths};
use crate::world::World;
use glam::{DVec3, Vec2, Vec3};
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
        let triangles = match geometry {
            Geometry::Mesh(mesh) => Discrete::new((0..mesh.triangles.len() as u32).map(|t| mesh.triangle_area(t))),
            Geometry::Analytic(_) => Discrete::default(),
        };
        Self { geometry: index, light, triangles }
    }

    /// Area of the surface, chart measure.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        match geometry {
            Geometry::Mesh(_) => self.triangles.total(),
            Geometry::Analytic(surface) => surface.area(),
        }
    }
}

/// A point of an emitter drawn for light sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Index in [`Scene::emitters`].
    pub emitter: u32,
    /// The point, render space.
    pub point: DVec3,
    /// Outer unit normal, chart.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Density with respect to chart area, choice of the emitter included.
    pub pdf: f64,
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
    /// Choice of an emitter by power.
    pub emitter_choice: Discrete,
    /// Lights that are not surfaces.
    pub lights: Vec<Arc<dyn Light>>,
    /// The observer at the camera.
    pub camera: Observer,
}

/// A surface point on a path, with the observer who measures there.
pub struct Vertex<'s> {
    /// Where the path arrived.
    pub hit: SurfaceHit,
    /// Outer unit normal of the surface itself, chart.
    pub normal: DVec3,
    /// Who measures here.
    pub observer: Observer,
    /// Wavelength here over wavelength at the camera.
    pub shift: f64,
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
}

impl Vertex<'_> {
    /// The unit chart direction of a direction in the shading frame.
    #[inline]
    pub fn chart_direction(&self, w: Vec3) -> DVec3 {
        let w = w.as_dvec3();
        let local = self.axes[0] * w.x + self.axes[1] * w.y + self.axes[2] * w.z;
        self.observer.frame.chart_direction(local)
    }

    /// The direction in the shading frame of a unit chart direction.
    #[inline]
    pub fn shading_direction(&self, chart: DVec3) -> Vec3 {
        let local = self.observer.frame.local_direction(chart);
        DVec3::from_array(self.axes.map(|a| a.dot(local))).as_vec3()
    }

    /// Whether the surface and its shading normal agree on which side of it `wi` lies, relative to `wo`. Where they do not,
    /// light would leak through the surface.
    #[inline]
    pub fn is_consistent(&self, wi: Vec3) -> bool {
        (self.wo.z * wi.z > 0.0) == (self.wn.dot(self.wo) * self.wn.dot(wi) > 0.0)
    }

    /// The light that the surface itself sends back along the path, as the camera receives it.
    #[inline]
    pub fn emitted(&self) -> SampledSpectrum {
        match self.emitter {
            Some(emitter) => {
                let l = emitter.light.radiance(self.shading.uv, self.wn.dot(self.wo), self.shading.lambda_nm);
                l * radiance_shift(self.shift)
            }
            None => SampledSpectrum::ZERO,
        }
    }

    /// The ray that leaves in the shading direction `wi`.
    pub fn spawn(&self, world: &World, wi: Vec3) -> Ray {
        world.spawn(&self.hit, self.normal, self.chart_direction(wi))
    }
}

/// What the spectral radiance per wavelength is multiplied with on the way to a camera that receives its wavelength divided
/// by `shift`: `L lambda^5` is constant along a ray (Liouville; I_nu/nu^3 is invariant).
#[inline]
pub fn radiance_shift(shift: f64) -> f32 {
    if shift == 1.0 { 1.0 } else { shift.powi(5) as f32 }
}

impl Scene {
    /// The vertex at `hit`; `None` where nobody can stand.
    pub fn vertex(&self, hit: SurfaceHit, lambda: &SampledWavelengths) -> Option<Vertex<'_>> {
        let observer = self.integrator.observer(&self.world, hit.point)?;
        let surface = self.world.surface(&hit);
        let binding = &self.shapes[hit.geometry as usize];
        let shift = self.shift(&observer);

        let wo = -observer.frame.local_direction(hit.direction);
        let ng = observer.frame.local_normal(surface.normal);
        let mut ns = observer.frame.local_normal(surface.shading_normal);
        // A shading normal that sees the viewer on the other side is of no use.
        if ns.dot(wo) * ng.dot(wo) <= 0.0 {
            ns = ng;
        }
        let (s, t) = ns.any_orthonormal_pair();
        let axes = [s, t, ns];
        let to_shading = |v: DVec3| DVec3::from_array(axes.map(|a| a.dot(v))).as_vec3();
        Some(Vertex {
            hit,
            normal: surface.normal,
            observer,
            shift,
            shading: Shading { uv: surface.uv, lambda_nm: lambda.at(shift as f32) },
            material: &*binding.material,
            emitter: binding.emitter.map(|e| &self.emitters[e as usize]),
            wo: to_shading(wo),
            wn: to_shading(ng),
            axes,
        })
    }

    /// Wavelength at `observer` over wavelength at the camera.
    #[inline]
    pub fn shift(&self, observer: &Observer) -> f64 {
        observer.lapse / self.camera.lapse
    }

    /// The light from far away along the chart direction `direction`, as the camera receives it.
    pub fn sky(&self, direction: DVec3, lambda: &SampledWavelengths) -> SampledSpectrum {
        let mut sum = SampledSpectrum::ZERO;
        if self.lights.is_empty() {
            return sum;
        }
        let shift = self.shift(&Observer::FLAT);
        for light in &self.lights {
            sum += light.sky_radiance(direction, lambda.at(shift as f32));
        }
        sum * radiance_shift(shift)
    }

    /// Draws a point of an emitter: the emitter by power, the point by chart area.
    pub fn sample_light(&self, choice: f32, u: Vec2) -> Option<LightSample> {
        let (index, rest) = self.emitter_choice.sample(choice)?;
        let emitter = &self.emitters[index];
        let chosen = self.emitter_choice.probability(index);
        let emitter_index = index as u32;
        match &self.world.geometries[emitter.geometry as usize] {
            Geometry::Mesh(mesh) => {
                let (triangle, _) = emitter.triangles.sample(rest)?;
                let (point, b) = sample_triangle(mesh, triangle as u32, u);
                let s = mesh.surface(triangle as u32, b);
                let pdf = chosen / emitter.triangles.total();
                Some(LightSample { emitter: emitter_index, point, normal: s.normal, uv: s.uv, pdf })
            }
            Geometry::Analytic(surface) => {
                let s = surface.sample(u);
                Some(LightSample { emitter: emitter_index, point: s.point, normal: s.normal, uv: s.uv, pdf: chosen * s.pdf })
            }
        }
    }

    /// The density with which [`Scene::sample_light`] draws the surface point of `vertex`, with respect to chart area.
    pub fn light_pdf(&self, vertex: &Vertex) -> f64 {
        let Some(index) = self.shapes[vertex.hit.geometry as usize].emitter else { return 0.0 };
        let emitter = &self.emitters[index as usize];
        let within = match &self.world.geometries[emitter.geometry as usize] {
            Geometry::Mesh(_) => 1.0 / emitter.triangles.total(),
            Geometry::Analytic(surface) => surface.pdf(vertex.hit.point),
        };
        self.emitter_choice.probability(index as usize) * within
    }
}
