//! A built scene as light transport sees it: vertices with their observers and its lights.

use crate::integrator::Integrator;
use crate::light_sampling::{Emitter, LightSample, LightSampler};
use crate::shading_frame::oriented;
use crate::world::World;
use bhs_core::camera::{CameraRay, Viewpoint};
use bhs_core::geometry::{Geometry, SurfaceGeometry};
use bhs_core::light::Emission;
use bhs_core::material::{Material, Shading, Tangents};
use bhs_core::motion::Motion;
use bhs_core::observer::Observer;
use bhs_core::ray::{Ray, SurfaceHit};
use bhs_core::spacetime::{Place, Side};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;

/// What a geometry is made of.
#[derive(Clone)]
pub struct ShapeBinding {
    /// Its material.
    pub material: Arc<dyn Material>,
    /// Index of its emission in [`LightSampler::emitters`].
    pub emitter: Option<u32>,
    /// How it moves; `None`: at rest.
    pub motion: Option<Arc<dyn Motion>>,
    /// Number of the `Shape` directive in the scene, counted from 0.
    pub index: u32,
    /// What the material says of [`Material::is_oriented`].
    is_oriented: bool,
}

impl ShapeBinding {
    /// A geometry at rest that emits nothing, of the `Shape` directive number `index`.
    pub fn new(material: Arc<dyn Material>, index: u32) -> Self {
        Self { is_oriented: material.is_oriented(), material, emitter: None, motion: None, index }
    }
}

/// Everything that light transport needs.
pub struct Scene {
    /// Geometry, intersector and hole.
    pub world: World,
    /// How light travels.
    pub integrator: Box<dyn Integrator>,
    /// What each geometry is made of, by geometry index.
    pub shapes: Vec<ShapeBinding>,
    /// Its lights.
    pub light_sampler: LightSampler,
    /// How finely rays are told from their neighbours.
    pub footprints: Footprints,
    /// Whether the picture draws the points of its lights ([`bhs_core::light::Light::points`]): rays of the camera do not see these.
    pub draws_points: bool,
    /// Whether a texture asks for the patch of a surface that a pixel sees ([`crate::patch`]).
    pub wants_patches: bool,
}

/// Footprints of rays (scene units): see [`Ray::footprint`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprints {
    /// Of camera rays, and of what they become in mirrors and glass: one pixel, at the scene's distance from the camera.
    pub camera: f64,
    /// Of rays that leave a rough surface, where every picture is a mean over many directions.
    pub rough: f64,
}

/// Footprint of rays that leave a rough surface, relative to the diagonal of the box around all surfaces. A light that BSDF
/// sampling finds loses a strip of a tenth of it along one edge; where that was 1e-2, rooms lit so were 0.2 % too dark (docs/accuracy.md).
const ROUGH_FOOTPRINT: f64 = 1e-3;

/// Density of the reflected direction (1/sr) from which on a rough surface is nearly a mirror: most of what it reflects comes from within some
/// two degrees.
const NEARLY_SPECULAR: f32 = 200.0;

impl Footprints {
    /// Footprints in a scene of the given diagonal (scene units), the middle of which is `distance` from a camera; `pixel_width` is
    /// [`bhs_core::camera::Camera::pixel_width`]. A camera within the scene sees it from half the diagonal.
    pub fn new(diagonal: f64, distance: f64, pixel_width: impl Fn(f64) -> f64) -> Self {
        Self { camera: pixel_width(distance.max(0.5 * diagonal)), rough: ROUGH_FOOTPRINT * diagonal }
    }
}

/// Time that light takes along the rays of a path, from where the last one ends to the camera. It is found when it is needed.
#[derive(Clone, Debug, Default)]
pub struct Travelled {
    /// Along those that have been measured (scene units).
    time: f64,
    /// The others.
    unmeasured: Vec<Ray>,
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
    /// Texture coordinates that count for its emission: see [`Emission::uv`].
    emission_uv: Vec2,
    /// When the light leaves here: see [`Emission::time`].
    emission_time: f64,
    axes: [DVec3; 3],
    /// See [`World::step_off`].
    step_off: f64,
}

impl Vertex<'_> {
    /// The unit chart direction of a direction in the shading frame.
    #[inline]
    pub fn chart_direction(&self, w: Vec3) -> DVec3 {
        self.observer.chart_direction(self.local(w))
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
            && (!self.observer.moves() || self.observer.has_positive_energy(self.local(wi)))
    }

    /// Whether what is seen here is what arrives from one direction, or two: a mirror, smooth glass, or what is so nearly.
    #[inline]
    pub fn shows_others(&self) -> bool {
        let material = self.material;
        material.is_specular()
            || !material.is_matt() && !material.chooses_directions() && {
                let mirrored = Vec3::new(-self.wo.x, -self.wo.y, self.wo.z);
                material.pdf(&self.shading, self.wo, mirrored) >= NEARLY_SPECULAR
            }
    }

    /// The direction that the observer measures, of a direction in the shading frame.
    #[inline]
    fn local(&self, w: Vec3) -> DVec3 {
        let w = w.as_dvec3();
        self.axes[0] * w.x + self.axes[1] * w.y + self.axes[2] * w.z
    }

    /// Wavelength at E = 1 of light that arrives from the unit chart direction `from`, over that of the light that it is scattered into, which goes
    /// back along the path; `None` where that is 1, as at all surfaces at rest.
    #[inline]
    pub fn shift(&self, from: DVec3) -> Option<f64> {
        self.observer.moves().then(|| self.ratio / self.observer.ratio(from))
    }

    /// The light that the surface itself sends back along the path, at E = 1.
    #[inline]
    pub fn emitted(&self) -> SampledSpectrum {
        match self.emitter {
            Some(emitter) => {
                let cos_theta = self.wn.dot(self.wo);
                let clock_rate = self.observer.clock_rate() as f32;
                let at = Emission {
                    uv: self.emission_uv,
                    point: self.hit.point,
                    time: self.emission_time,
                    cos_theta,
                    lambda_nm: self.shading.lambda_nm,
                    clock_rate,
                };
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
    view_from(-observer.local_direction(hit.direction), observer, surface)
}

/// The same of the direction `wo` back along the ray.
#[inline]
fn view_from(wo: DVec3, observer: &Observer, surface: &SurfaceGeometry) -> [DVec3; 3] {
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
        self.vertex_seen(hit, lambda, -1.0)
    }

    /// The same, with `back` times the looked direction of the hit for the direction back along the ray.
    #[inline]
    pub(crate) fn vertex_seen(&self, hit: SurfaceHit, lambda: &SampledWavelengths, back: f64) -> Option<Vertex<'_>> {
        let binding = &self.shapes[hit.geometry as usize];
        let observer = match &binding.motion {
            None => self.world.static_observer(self.world.place_of(&hit))?,
            Some(motion) => self.world.moving_observer(motion.as_ref(), self.world.place_of(&hit))?,
        };
        let surface = self.world.surface(&hit);
        let ratio = observer.ratio(hit.direction);

        let [wo, ng, ns] = view_from(observer.local_direction(hit.direction) * back, &observer, &surface);
        let (axes, tangents) = if binding.is_oriented {
            oriented(&observer, &self.world.tangents(&hit), ns)
        } else {
            let (s, t) = ns.any_orthonormal_pair();
            ([s, t, ns], Tangents::OF_AXES)
        };
        let to_shading = |v: DVec3| DVec3::from_array(axes.map(|a| a.dot(v))).as_vec3();
        Some(Vertex {
            hit,
            normal: surface.normal,
            observer,
            ratio,
            radiance_factor: self.radiance_factor(ratio),
            shading: Shading {
                uv: surface.uv,
                second_uv: surface.second_uv.unwrap_or(surface.uv),
                colour: surface.colour,
                lambda_nm: lambda.at(ratio as f32),
                point: hit.point + self.world.origin,
                normal: surface.normal.as_vec3(),
                tangents,
                beside: [Vec3::ZERO; 2],
            },
            material: &*binding.material,
            emitter: binding.emitter.map(|e| &self.light_sampler.emitters[e as usize]),
            wo: to_shading(wo),
            wn: to_shading(ng),
            emission_uv: surface.uv,
            emission_time: 0.0,
            axes,
            step_off: self.world.step_off(&hit),
        })
    }

    /// Notes that light comes along `ray`, which ended at `vertex`, and shows the emission of the vertex as it was when it left there; nothing where no
    /// emission depends on it.
    #[inline]
    pub fn date(&self, vertex: &mut Vertex, ray: &Ray, travelled: &mut Travelled) {
        if self.light_sampler.depends_on_time {
            self.dated(vertex, ray, travelled);
        }
    }

    #[cold]
    fn dated(&self, vertex: &mut Vertex, ray: &Ray, travelled: &mut Travelled) {
        travelled.unmeasured.push(*ray);
        let Some(light) = vertex.emitter.map(|e| &e.light).filter(|light| light.depends_on_time()) else { return };
        for ray in travelled.unmeasured.drain(..) {
            travelled.time += self.integrator.travel_time_roughly(&self.world, &ray).unwrap_or(0.0);
        }
        vertex.emission_time = -travelled.time;
        // Of triangles the point alone says nothing: their patterns stay.
        if let Geometry::Analytic(surface) = &self.world.geometries[vertex.hit.geometry as usize] {
            vertex.emission_uv = surface.surface(light.at_time_zero(vertex.hit.point, -travelled.time)).uv;
        }
    }

    /// What [`Vertex::wo`] has along the shading normal, at a hit of which surface and observer are known.
    #[inline]
    pub fn cos_to_viewer(observer: &Observer, hit: &SurfaceHit, surface: &SurfaceGeometry) -> f32 {
        let [wo, _, ns] = view(observer, hit, surface);
        ns.dot(wo) as f32
    }

    /// The unit normal about which the material at `hit` scatters (chart): that of the surface where nothing is measured.
    pub fn shading_normal(&self, hit: &SurfaceHit) -> DVec3 {
        let bare = self.world.surface(hit).shading_normal;
        if !self.shapes[hit.geometry as usize].is_oriented {
            return bare;
        }
        // No material looks at wavelengths for its normal.
        let lambda = SampledWavelengths::visible(0.5, 360.0, 830.0);
        self.vertex(*hit, &lambda).map_or(bare, |vertex| {
            let local = vertex.local(vertex.material.normal(&vertex.shading, vertex.wo));
            vertex.observer.frame.apply(local).normalize()
        })
    }

    /// Whether light bends in this scene.
    #[inline]
    pub fn bends(&self) -> bool {
        self.world.bends()
    }

    /// Who moves with the surface at `hit`; `None` where nothing can move so.
    pub fn surface_observer(&self, hit: &SurfaceHit) -> Option<Observer> {
        let place = self.world.place_of(hit);
        match &self.shapes[hit.geometry as usize].motion {
            None => self.world.static_observer(place),
            Some(motion) => self.world.moving_observer(motion.as_ref(), place),
        }
    }

    /// The static observer at `place` (render space); `None` where nothing can stand still.
    #[inline]
    pub fn observer(&self, place: Place) -> Option<Observer> {
        self.world.static_observer(place)
    }

    /// The observer at `viewpoint` in the place `origin` (render space); `None` where nothing can be or move so.
    #[inline]
    pub fn camera_observer(&self, origin: DVec3, viewpoint: &Viewpoint) -> Option<Observer> {
        let place = Place { x: origin, side: viewpoint.side };
        match &viewpoint.motion {
            Some(motion) => self.world.moving_observer(motion.as_ref(), place),
            None => self.observer(place),
        }
    }

    /// The light of the sky that a ray finds in the direction `sky.0` on the side `sky.1`, at the wavelengths `lambda` at E = 1; `of_camera`: the
    /// ray is the camera's own, which does not see what the picture draws.
    #[inline]
    pub fn sky(&self, sky: (DVec3, Side), lambda: &SampledWavelengths, of_camera: bool) -> SampledSpectrum {
        match of_camera && self.draws_points {
            true => self.light_sampler.sky_without_points(sky, lambda),
            false => self.light_sampler.sky(sky, lambda),
        }
    }

    /// The ray along which an observer at `viewpoint` sees what `seen` shows, and the wavelength of its light there over that at E = 1; `None`, and
    /// some ray, where nothing can stand still or move so, and where no light can come from.
    #[inline]
    pub fn camera_ray(&self, seen: &CameraRay, viewpoint: &Viewpoint) -> (Ray, Option<f64>) {
        let side = viewpoint.side;
        let (direction, ratio) = match &self.camera_observer(seen.origin, viewpoint) {
            // Light without energy far away comes from nowhere outside.
            Some(observer) if observer.moves() && !observer.has_positive_energy(seen.direction) => (seen.direction, None),
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
        self.world.conventions.radiance_factor(ratio)
    }

    /// Draws a point of a light: see [`LightSampler::sample`].
    pub fn sample_light(&self, receiver: Option<Place>, choice: f32, u: Vec2) -> Option<LightSample> {
        self.light_sampler.sample(&self.world, receiver, choice, u)
    }

    /// The density with which [`Scene::sample_light`] draws the surface point of `vertex` for the same `receiver`, with respect to chart area.
    pub fn light_pdf(&self, receiver: Option<Place>, vertex: &Vertex) -> f64 {
        let emitter = self.shapes[vertex.hit.geometry as usize].emitter;
        emitter.map_or(0.0, |emitter| self.light_sampler.pdf(&self.world, receiver, emitter, &vertex.hit))
    }
}
