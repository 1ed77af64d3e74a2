//! Causes between what is seen and the lights: which of them could light it, and what keeps them from it.

use super::{Explanation, NOT_FOUND, light_words, probe, shape_words};
use crate::lang::BuiltScene;
use crate::render::Job;
use bhs_core::light::{EmissionPoint, Light};
use bhs_core::material::{Material, Shading};
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::uniform_hemisphere;
use bhs_core::spectrum::{N_LAMBDA, SampledWavelengths};
use bhs_engine::connections::{Connection, ShadowRay};
use bhs_engine::light_sampling::{LightSample, LightSource};
use bhs_engine::scene::Vertex;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// Surfaces that send light on in one direction which a ray is followed through.
const MIRRORS: u32 = 16;
/// Samples of lights at each point that is seen.
const SAMPLES: u32 = 8;
/// Share of the samples that a shape keeps from what is seen and that would light it, from which on the lights count as enclosed.
const ENCLOSED: f64 = 0.15;

/// What keeps the light of a sample from a point.
#[derive(Clone, Copy, Default)]
struct Obstacles {
    /// The light does not shine in its direction.
    back_of_light: bool,
    /// It is on the other side of the surface.
    behind_surface: bool,
    /// The surface scatters nothing from there.
    dark_surface: bool,
    /// The shape that stands in between, if one does.
    occluder: Option<u32>,
}

impl Obstacles {
    fn none(&self) -> bool {
        !(self.back_of_light || self.behind_surface || self.dark_surface || self.occluder.is_some())
    }
}

/// What was found between what is seen and the lights, of a picture to which none of these brings light.
#[derive(Default)]
pub struct Survey {
    /// Whether the method does not find lights without size.
    misses_points: bool,
    /// How often each shape is seen.
    seen: BTreeMap<u32, u32>,
    /// How often each shape sends light on in one direction before that.
    specular: BTreeMap<u32, u32>,
    /// Samples of lights, by number of the light.
    lights: BTreeMap<u32, u32>,
    /// The shapes that stand before lights.
    occluders: BTreeMap<u32, u32>,
    samples: u32,
    /// Those that nothing stands before, on the lit side of a surface.
    in_sight: u32,
    /// Those that are occluded, and would bring light if they were not.
    occluded_only: u32,
    back_of_light: u32,
    behind_surface: u32,
    dark_surface: u32,
}

/// The key with the greatest count.
fn most(counts: &BTreeMap<u32, u32>) -> Option<(u32, u32)> {
    counts.iter().map(|(key, count)| (*key, *count)).max_by_key(|(_, count)| *count)
}

impl Survey {
    /// Follows some camera rays of the whole frame; `None` if any of them finds light.
    pub fn of(built: &BuiltScene, job: &Job) -> Option<Self> {
        let misses_points = built.warnings.iter().any(|d| d.code == NOT_FOUND);
        let mut survey = Self { misses_points, ..Self::default() };
        let lambda = probe::wavelengths(job);
        for (number, ray) in probe::rays(job).iter().enumerate() {
            let Some(ray) = ray.ray else { continue };
            survey.follow(built, ray, &lambda, number as u32)?;
        }
        Some(survey)
    }

    /// The shape that is seen most, and how often.
    pub fn most_seen(&self) -> Option<(u32, u32)> {
        most(&self.seen)
    }

    /// Whether nothing of any light is in sight of what is seen.
    pub fn no_light_in_sight(&self) -> bool {
        self.in_sight == 0
    }

    /// Follows a ray to the first surface that scatters in many directions; `None` if it finds light.
    fn follow(&mut self, built: &BuiltScene, mut ray: Ray, lambda: &SampledWavelengths, number: u32) -> Option<()> {
        let scene = &built.scene;
        for bounce in 0..MIRRORS {
            match scene.integrator.trace(&scene.world, &ray).arrival {
                Arrival::Sky(direction, side) => {
                    return scene.sky((direction, side), lambda, bounce == 0).is_zero().then_some(());
                }
                Arrival::Captured | Arrival::OutOfSteps => return Some(()),
                Arrival::Surface(hit) => {
                    let Some(vertex) = scene.vertex(hit, lambda) else { return Some(()) };
                    if !vertex.emitted().is_zero() {
                        return None;
                    }
                    if !vertex.material.is_specular() {
                        *self.seen.entry(scene.shapes[hit.geometry as usize].index).or_default() += 1;
                        return self.look_for_lights(built, &vertex, lambda, number);
                    }
                    *self.specular.entry(scene.shapes[hit.geometry as usize].index).or_default() += 1;
                    let u = Vec2::new(0.37, 0.61);
                    let Some(sample) = vertex.material.sample(&vertex.shading, vertex.wo, 0.9, u) else { return Some(()) };
                    ray = vertex.spawn(&scene.world, sample.wi, ray.footprint);
                }
            }
        }
        Some(())
    }

    /// Draws points of lights for a vertex; `None` if one of them lights it.
    fn look_for_lights(&mut self, built: &BuiltScene, vertex: &Vertex, lambda: &SampledWavelengths, number: u32) -> Option<()> {
        let scene = &built.scene;
        let receiver = scene.world.place_of(&vertex.hit);
        for k in 0..SAMPLES {
            let at = f64::from(number * SAMPLES + k);
            let [choice, u, v] = [0.819_172_51, 0.671_043_6, 0.549_700_48].map(|step| (0.5 + at * step).fract() as f32);
            let choice = (choice + k as f32 / SAMPLES as f32).fract();
            let u = Vec2::new(u, v);
            let emitters = scene.light_sampler.emitters.len();
            let is_found = |light: &LightSample| {
                let other = (light.source.number(emitters) as usize).checked_sub(emitters);
                !self.misses_points || other.is_none_or(|other| !is_sizeless(&*scene.light_sampler.lights[other]))
            };
            if let Some(light) = scene.sample_light(Some(receiver), choice, u).filter(is_found) {
                for (connection, is_guess) in connections(built, vertex, &light) {
                    let number = light.source.number(emitters);
                    let obstacles = obstacles(built, vertex, (&light, &connection, is_guess), lambda);
                    self.count(number, obstacles)?;
                }
            }
            self.look_at_the_sky(built, vertex, lambda, u)?;
        }
        Some(())
    }

    /// Looks for light of the sky that is not drawn by light sampling.
    fn look_at_the_sky(&mut self, built: &BuiltScene, vertex: &Vertex, lambda: &SampledWavelengths, u: Vec2) -> Option<()> {
        let scene = &built.scene;
        let sampler = &scene.light_sampler;
        // Without any light to choose there is no probability.
        let is_sampled = |i: usize| sampler.choice.probability(sampler.emitters.len() + i) > 0.0;
        let is_unsampled = |i: usize| !is_sampled(i);
        let shines = |light: &dyn Light| !light.sky_radiance(glam::DVec3::Y, lambda.lambda_nm).is_zero();
        let Some(light) = (0..sampler.lights.len()).find(|i| is_unsampled(*i) && shines(&*sampler.lights[*i])) else {
            return Some(());
        };
        let up = uniform_hemisphere(u);
        let wi = if vertex.wo.z < 0.0 { -up } else { up };
        let ray = vertex.spawn(&scene.world, wi, scene.footprints.rough);
        let scattered = vertex.material.evaluate(&vertex.shading, vertex.wo, wi);
        let dark_surface = scattered.is_zero();
        let obstacles = match scene.integrator.trace(&scene.world, &ray).arrival {
            Arrival::Surface(hit) => {
                Obstacles { occluder: Some(scene.shapes[hit.geometry as usize].index), dark_surface, ..Obstacles::default() }
            }
            Arrival::Sky(..) => Obstacles { dark_surface, ..Obstacles::default() },
            Arrival::Captured | Arrival::OutOfSteps => return Some(()),
        };
        self.count((sampler.emitters.len() + light) as u32, obstacles)
    }

    fn count(&mut self, light: u32, obstacles: Obstacles) -> Option<()> {
        if obstacles.none() {
            return None;
        }
        let Obstacles { back_of_light, behind_surface, dark_surface, occluder } = obstacles;
        self.samples += 1;
        *self.lights.entry(light).or_default() += 1;
        let is_unlit = back_of_light || behind_surface || dark_surface;
        for (count, is) in [
            (&mut self.back_of_light, back_of_light),
            (&mut self.behind_surface, behind_surface && !back_of_light),
            (&mut self.dark_surface, dark_surface && !back_of_light && !behind_surface),
            (&mut self.in_sight, occluder.is_none() && !behind_surface),
            (&mut self.occluded_only, occluder.is_some() && !is_unlit),
        ] {
            *count += u32::from(is);
        }
        if let Some(occluder) = occluder.filter(|_| !is_unlit) {
            *self.occluders.entry(occluder).or_default() += 1;
        }
        Some(())
    }

    /// Of a picture of nothing but mirrors and clear glass, with lights that have no size.
    pub fn specular_only(&self, built: &BuiltScene) -> Option<Explanation> {
        let sampler = &built.scene.light_sampler;
        let (shape, _) = most(&self.specular).filter(|_| self.seen.is_empty())?;
        let is_so = sampler.emitters.is_empty() && sampler.lights.iter().all(|light| is_sizeless(&**light));
        is_so.then(|| {
            let (shape, light) = (shape_words(built, shape), light_words(built, 0));
            Explanation::warning(
                "specular-only",
                format!(
                    "the picture is black: all that is seen mirrors or refracts light in one direction, such as {shape}, and none of it leads to a light \
                     without size, such as {light}; give the material a `roughness`, or the light a size: an `AreaLightSource`"
                ),
            )
        })
    }

    /// What is said of the picture.
    pub fn explain(&self, built: &BuiltScene) -> Option<Explanation> {
        let (light, _) = most(&self.lights)?;
        let light_number = light;
        let light = light_words(built, light);
        if f64::from(self.occluded_only) >= ENCLOSED * f64::from(self.samples) {
            return Some(self.enclosed(built, light_number));
        }
        let unlit = self.back_of_light + self.behind_surface;
        if self.dark_surface > unlit {
            let (shape, _) = self.most_seen()?;
            let shape = shape_words(built, shape);
            let text = format!(
                "the picture is black: all that is seen reflects nothing, such as {shape}; give it another `reflectance`"
            );
            return Some(Explanation::warning("reflects-nothing", text));
        }
        if unlit == 0 {
            return None;
        }
        let spot = is_spot(built, light_number);
        let (why, to_do) = if self.back_of_light < self.behind_surface {
            ("is behind the surfaces that are seen", "move it to the side that the camera sees")
        } else if spot {
            ("shines past all that is seen", "turn its `to`, or give it a larger `coneangle`")
        } else {
            ("shines the other way", "write `ReverseOrientation` before its shape, or \"bool twosided\" true in the area light")
        };
        Some(Explanation::warning(
            "unlit-side",
            format!("the picture is black: every point that is seen is on the unlit side of every light: {light} {why}; {to_do}"),
        ))
    }

    /// What is said of lights that something hides.
    fn enclosed(&self, built: &BuiltScene, light: u32) -> Explanation {
        let (what, is_clear) = match most(&self.occluders) {
            Some((shape, _)) => (shape_words(built, shape), lets_light_through(built, shape)),
            None => ("other surfaces".to_owned(), false),
        };
        let has_size = (light as usize) < built.scene.light_sampler.emitters.len();
        let to_do = match (is_clear, has_size) {
            (true, false) => {
                "light sampling takes what is clear for opaque, and no path meets a light without size: give it a size, an `AreaLightSource`"
            }
            (true, true) => {
                "light comes through what is clear by longer paths only: give the `LightTransport` a larger `maxdepth`"
            }
            (false, _) => "move the light out of it, or open what encloses it",
        };
        let lights = light_words(built, light);
        Explanation::warning(
            "lights-enclosed",
            format!(
                "the picture is black: the lights are enclosed, all shadow rays are occluded: before {lights} stands {what}; {to_do}"
            ),
        )
    }
}

/// Whether a light shines from a point, or in one direction.
fn is_sizeless(light: &dyn Light) -> bool {
    light.position().is_some() || light.sample_sky(Vec2::splat(0.5)).is_some_and(|sample| sample.is_parallel)
}

/// Whether a light shines into a cone.
fn is_spot(built: &BuiltScene, light: u32) -> bool {
    let number = (light as usize).checked_sub(built.scene.light_sampler.emitters.len());
    number.and_then(|number| built.statements.lights.get(number)).is_some_and(|statement| statement.plugin == "spot")
}

/// Whether the material of a shape lets light go on through it, as glass does.
fn lets_light_through(built: &BuiltScene, index: u32) -> bool {
    let Some(shape) = built.scene.shapes.iter().find(|shape| shape.index == index) else { return false };
    let at = Shading::at_uv(Vec2::splat(0.5), [550.0; N_LAMBDA]);
    let sample = |material: &dyn Material| material.sample(&at, Vec3::Z, 0.9, Vec2::splat(0.5));
    sample(&*shape.material).is_some_and(|sample| sample.wi.z < 0.0 && !sample.weight.is_zero())
}

/// The geodesics from a vertex to a sample of a light, and whether they are guessed: straight lines, where the integrator cannot join points.
fn connections(built: &BuiltScene, vertex: &Vertex, light: &LightSample) -> Vec<(Connection, bool)> {
    let scene = &built.scene;
    let from = scene.world.place_of(&vertex.hit);
    let is_sky = matches!(light.source, LightSource::Sky { .. });
    if let Some(connections) = scene.integrator.connections() {
        let found = match is_sky {
            true => connections.connect_sky(&scene.world, from, (light.point, light.side), 0),
            false => connections.connect(&scene.world, from, light.place(), 0),
        };
        return found.into_iter().flatten().map(|connection| (connection, false)).collect();
    }
    let way = if is_sky { light.point } else { light.point - from.x };
    let Some(launch) = way.try_normalize().filter(|_| from.side == light.side) else { return Vec::new() };
    vec![(Connection { launch, arrival: launch, spread: way.length_squared(), phi: 0.0 }, true)]
}

/// What keeps the light of a sample from a vertex along a connection.
fn obstacles(
    built: &BuiltScene,
    vertex: &Vertex,
    (light, connection, is_guess): (&LightSample, &Connection, bool),
    lambda: &SampledWavelengths,
) -> Obstacles {
    let scene = &built.scene;
    let wi = vertex.shading_direction(connection.launch);
    let is_across = vertex.wo.z * wi.z <= 0.0 || !vertex.is_consistent(wi);
    let is_dark = vertex.material.evaluate(&vertex.shading, vertex.wo, wi).is_zero() || !vertex.is_consistent(wi);
    let arriving = scene.light_sampler.arriving(light, connection, &vertex.observer, lambda, &scene.world.conventions);
    let start = vertex.leave(&scene.world, connection.launch, scene.footprints.rough);
    // A lamp that shines inwards stands before its own light.
    let own = match light.source {
        LightSource::Surface { primitive, .. } => Some(scene.shapes[primitive.geometry as usize].index),
        _ => None,
    };
    let occluder = occluder(built, (vertex, start), light, (connection, is_guess));
    let is_own = own.is_some() && occluder == own;
    Obstacles {
        back_of_light: is_own || arriving.emitted.max() <= faintest(built, light),
        behind_surface: is_dark && is_across,
        dark_surface: is_dark && !is_across,
        occluder: occluder.filter(|_| !is_own),
    }
}

/// What a light sends in a direction by rounding alone.
fn faintest(built: &BuiltScene, light: &LightSample) -> f32 {
    let LightSource::Surface { emitter, uv, .. } = light.source else { return 0.0 };
    let [lo, hi] = built.film.lambda_range();
    let at = EmissionPoint { uv, point: light.point };
    (1e-9 * built.scene.light_sampler.emitters[emitter as usize].light.exitance(&at, lo, hi)) as f32
}

/// The shape that stands between a vertex, from which the ray leaves, and a sample of a light.
fn occluder(
    built: &BuiltScene,
    (vertex, start): (&Vertex, Ray),
    light: &LightSample,
    (connection, is_guess): (&Connection, bool),
) -> Option<u32> {
    let scene = &built.scene;
    let target = match light.source {
        LightSource::Surface { primitive, .. } => Some(primitive),
        _ => None,
    };
    let met = |ray: &Ray| match scene.integrator.trace(&scene.world, ray).arrival {
        Arrival::Surface(hit) => Some(hit),
        _ => None,
    };
    if matches!(light.source, LightSource::Sky { .. }) {
        return met(&start).map(|hit| scene.shapes[hit.geometry as usize].index);
    }
    let far = (light.point - vertex.hit.point).length();
    if let Some(connections) = scene.integrator.connections().filter(|_| !is_guess) {
        let ray = ShadowRay { start, from: vertex.hit.point, to: light.place(), target, connection: *connection };
        let mut occluded = [false];
        connections.occluded_all(&scene.world, &[ray], &mut occluded);
        if !occluded[0] {
            return None;
        }
    } else {
        let hit = met(&start)?;
        let is_light = target.is_some_and(|target| target == hit.primitive());
        if is_light || (hit.point - vertex.hit.point).length() >= far * (1.0 - 1e-6) {
            return None;
        }
    }
    // The one nearest to the light says more: it is followed from there.
    let back = Ray { side: light.side, leaving: target, ..Ray::new(light.point, -connection.arrival) };
    let hit = met(&back).or_else(|| met(&start))?;
    Some(scene.shapes[hit.geometry as usize].index)
}
