//! Plugins, each made alone, to a scene: render space, the intersector, emitters, and what must hold between the parts.

use crate::lang::coplanar;
use crate::lang::emitters;
use crate::lang::has_errors;
use crate::lang::instances::Placed;
use crate::lang::moving;
use crate::lang::overrides::Overrides;
use crate::lang::parts::{LoadCounters, Part, PartAreaLight, PartCamera, PartLight, Parts, View};
use crate::lang::sky_points::SkyPoints;
use crate::lang::spacetime::{Gravity, choose_integrator};
use crate::registry::Registry;
use bhs_core::camera::Camera;
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::{Aabb, Geometry, WorldGeometry};
use bhs_core::light::Light;
use bhs_core::material::Material;
use bhs_core::motion::Motion;
use bhs_core::sampling::Discrete;
use bhs_core::spacetime::Side;
use bhs_engine::light_sampling::{Emitter, LightSampler};
use bhs_engine::scene::{Footprints, Scene, ShapeBinding};
use bhs_engine::world::World;
use glam::{DVec3, Vec2};
use std::collections::VecDeque;
use std::sync::Arc;

/// A scene in render space.
pub(super) struct Assembled {
    pub scene: Scene,
    /// The one that the scene is seen from.
    pub view: View,
    pub further_views: VecDeque<View>,
    pub integrator_name: String,
    pub load: LoadCounters,
}

/// Joins the parts. `None` if something is wrong with them or has been before.
pub(super) fn assemble(
    parts: Parts,
    registry: &Registry,
    overrides: &Overrides,
    found: &mut Vec<Diagnostic>,
) -> Option<Assembled> {
    let Parts { mut cameras, lambda_range, mut shapes, .. } = parts;
    let mut motions = parts.motions;
    let (integrator_name, integrator, bends) = choose_integrator(parts.integrator, parts.gravity.as_ref(), registry, found);

    // Render space: single precision is fine near its origin only.
    check_range(&shapes, found);
    let mut load = LoadCounters { shapes: shapes.len() as u64, ..Default::default() };
    let objects: Vec<Placed> = parts.objects.into_iter().filter_map(|o| Placed::new(o, &mut load, found)).collect();
    let bounds = shapes.iter().map(|s| s.geometry.bounds()).chain(objects.iter().map(Placed::bounds));
    let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
    let origin = render_origin(&bounds, cameras.first().and_then(|c| c.camera.as_deref()));
    // In world space, and in render space.
    let stated = parts.gravity.clone();
    let in_world = parts.gravity.filter(|g| bends || g.spacetime.has_far_side());
    let gravity = in_world.as_ref().map(|g| g.moved(origin));
    let has_far_side = gravity.as_ref().is_some_and(|g| g.spacetime.has_far_side());
    cameras.iter_mut().filter_map(|c| c.camera.as_mut()).for_each(|c| c.rebase(origin));
    cameras.iter_mut().filter_map(|c| Arc::get_mut(c.viewpoint.motion.as_mut()?)).for_each(|m| m.rebase(origin));
    motions.iter_mut().for_each(|m| m.rebase(origin));
    let motions: Vec<Arc<dyn Motion>> = motions.into_iter().map(Arc::from).collect();
    for PartCamera { span, camera, viewpoint, target, .. } in &cameras {
        // Where a camera is missing, it may be for another fault.
        let unknown = overrides.without_camera || (span.is_none() && (overrides.may_lack_camera || has_errors(found)));
        if let (Some(camera), Some(gravity), false) = (camera, &gravity, unknown) {
            gravity.check_camera(camera.as_ref(), viewpoint, (*span, target.map(|target| target - origin)), found);
        }
    }
    if !has_far_side {
        let shapes = shapes.iter().map(|s| (s.side, s.span));
        let objects = objects.iter().flat_map(Placed::sides);
        let lights = parts.lights.iter().map(|l| (l.side, l.span));
        let views = cameras.iter().filter_map(|c| Some((c.viewpoint.side, c.span?)));
        if let Some((_, span)) = shapes.chain(objects).chain(lights).chain(views).find(|(side, _)| *side == Side::Far) {
            found.push(
                Diagnostic::error("no-far-side", "this stands on the far side, and there is none")
                    .at(span, "")
                    .help("only a wormhole has a far side: `Wormhole \"ellis\"` or `Wormhole \"dneg\"`"),
            );
        }
    }
    let joins = integrator.as_ref().is_none_or(|i| i.connections().is_some());
    let sampling = match (parts.samples_lights, joins) {
        (true, true) => Ok(()),
        (true, false) => Err((
            "the integrator does not join points with lights, and this light is found in no other way",
            "use Integrator \"adaptive\" \"bool connections\" true, or a light that has a size",
        )),
        (false, _) => Err((
            "the light transport does not find this light",
            "use LightTransport \"path\" with light sampling, or a light that has a size",
        )),
    };
    let points = SkyPoints::new(&parts.lights, joins);
    points.check(&cameras, found);
    check_points(&parts.lights, sampling, in_world.as_ref(), found);
    warn_dark(&parts.lights, &parts.area_lights, &shapes, found);
    // Also where rays are taken to be straight, emission is that of the scene's spacetime.
    let told = stated.map(|g| g.moved(origin));
    let area_lights = emitters::bind(parts.area_lights, told.as_ref(), found);
    emitters::open(&mut shapes, &area_lights, found);
    if has_errors(found) {
        return None;
    }

    // Surfaces and what they are made of.
    let (materials, wants_patches) = (parts.materials, parts.wants_patches);
    let default_material: Arc<dyn Material> = parts.default_material?.into();
    let (mut geometries, mut bindings, mut emitters) = (Vec::new(), Vec::new(), Vec::new());
    // The places of their names.
    let mut spans = Vec::new();
    let mut first_far = None;
    let mut shapes_by_side = [Vec::new(), Vec::new()];
    shapes.into_iter().for_each(|part| shapes_by_side[part.side as usize].push(part));
    for (side, shapes) in [Side::Near, Side::Far].into_iter().zip(shapes_by_side) {
        if side == Side::Far {
            first_far = Some(geometries.len());
        }
        for part in shapes {
            let geometry = to_render_space(part.geometry, origin, part.span, &mut load, found);
            let motion = part.motion.and_then(|m| motions.get(m).cloned());
            moving::check((&geometry, motion.as_ref()), told.as_ref(), (side, part.span), found);
            let material = match part.material {
                Some(material) => materials.get(material)?.as_ref()?,
                None => &default_material,
            };
            let mut binding = ShapeBinding::new(Arc::clone(material), part.index);
            binding.motion.clone_from(&motion);
            if let Some(gravity) = &gravity {
                gravity.check_throat(&geometry, part.span, found);
            }
            if let Some(light) = part.area_light {
                if let (Some(gravity), None) = (&gravity, &motion) {
                    gravity.check_light(&geometry, side, part.span, found);
                }
                binding.emitter = Some(emitters.len() as u32);
                let light = Arc::clone(area_lights.get(light)?.as_ref()?);
                let place = (side, part.span);
                emitters::check((&geometry, motion.as_ref()), light.as_ref(), told.as_ref(), place, found);
                let mut emitter = Emitter::new(geometries.len() as u32, &geometry, light);
                if let Some(light) = emitter.light.of_area(emitter.area(&geometry)) {
                    emitter.light = light;
                }
                emitters.push(Emitter { motion, ..emitter });
            }
            geometries.push(geometry);
            bindings.push(binding);
            spans.push(part.span);
        }
        for (geometry, part) in objects.iter().flat_map(|o| o.geometries(origin, side)) {
            let material = match part.material {
                Some(material) => Arc::clone(materials.get(material)?.as_ref()?),
                None => Arc::clone(&default_material),
            };
            geometries.push(geometry);
            bindings.push(ShapeBinding::new(material, part.index));
            spans.push(part.span);
        }
    }
    if has_errors(found) {
        return None;
    }
    let first_far = first_far.unwrap_or(geometries.len());
    for part in [0..first_far, first_far..geometries.len()] {
        coplanar::warn(&geometries[part.clone()], &bindings[part.clone()], &spans[part], found);
    }
    drop(spans);
    let [lo, hi] = lambda_range;
    let power = emitters.iter().map(|e: &Emitter| finite_power(e.power(&geometries[e.geometry as usize], lo, hi)));
    let mut sides = Vec::new();
    let lights: Vec<Arc<dyn Light>> = parts
        .lights
        .into_iter()
        .filter_map(|part| {
            let mut light = part.light?;
            light.rebase(origin);
            sides.push(part.side);
            Some(Arc::from(light))
        })
        .collect();
    let radius = scene_radius(&bounds);
    let choice = Discrete::new(power.chain(lights.iter().map(|l| finite_power(l.power(lo, hi, radius)))));

    let (intersector_span, builder) = parts.intersector?;
    let far = geometries.split_off(first_far);
    let mut build = |geometries: &[Geometry]| match builder.build(geometries) {
        Ok(intersector) => Some(intersector),
        Err(why) => {
            found.push(
                Diagnostic::error("intersector-failed", format!("the intersector cannot be built: {why}"))
                    .at(intersector_span, "")
                    .help("Option \"string intersector\" \"reference\" does without, slowly"),
            );
            None
        }
    };
    let intersector = build(&geometries)?;
    let mut world = World::new(geometries, intersector, origin);
    if let Some(gravity) = gravity.filter(|_| bends) {
        world = world.in_spacetime(gravity.spacetime, gravity.conventions);
    }
    if !far.is_empty() {
        let intersector = build(&far)?;
        world = world.with_far_side(far, intersector);
    }
    let integrator = integrator?;
    let mut further_views = VecDeque::new();
    for PartCamera { name, camera, viewpoint, .. } in cameras {
        let camera = camera?;
        let footprints = footprints(&world.bounds_of_both_sides(), camera.as_ref());
        let draws_points = points.is_drawn_by(camera.as_ref());
        further_views.push_back(View { name, camera, viewpoint, footprints, draws_points });
    }
    let view = further_views.pop_front()?;
    let (footprints, draws_points) = (view.footprints, view.draws_points);
    let depends_on_time = emitters.iter().any(|e| e.light.depends_on_time());
    let light_sampler = LightSampler { emitters, lights, sides, choice, depends_on_time };
    let scene = Scene { world, integrator, shapes: bindings, light_sampler, footprints, draws_points, wants_patches };
    Some(Assembled { scene, view, further_views, integrator_name, load })
}

/// A power that lights can be chosen by.
fn finite_power(power: f64) -> f64 {
    if power.is_finite() { power.max(0.0) } else { 0.0 }
}

/// Radius of a sphere around all surfaces (scene units); 1 without any, as nothing is lit then.
fn scene_radius(bounds: &Aabb) -> f64 {
    if bounds.is_empty() { 1.0 } else { 0.5 * (bounds.max - bounds.min).length() }
}

/// Footprints of rays in a scene within `bounds`; without a surface there is nothing that rays could miss.
fn footprints(bounds: &Aabb, camera: &dyn Camera) -> Footprints {
    if bounds.is_empty() {
        return Footprints::default();
    }
    let distance = (camera.position() - bounds.center()).length();
    Footprints::new((bounds.max - bounds.min).length(), distance, |d| camera.pixel_width(d))
}

/// World position of render space's origin: the world's own if the scene is near it, else the scene's middle.
fn render_origin(bounds: &Aabb, camera: Option<&dyn Camera>) -> DVec3 {
    if bounds.is_empty() {
        return camera.map_or(DVec3::ZERO, |c| c.position());
    }
    bounds.origin()
}

fn to_render_space(
    geometry: WorldGeometry,
    origin: DVec3,
    span: Span,
    load: &mut LoadCounters,
    found: &mut Vec<Diagnostic>,
) -> Geometry {
    match geometry {
        WorldGeometry::Mesh(mesh) => {
            let (mesh, dropped) = mesh.rebase(origin);
            load.triangles += mesh.triangles.len() as u64;
            load.zero_area_triangles += dropped as u64;
            if mesh.triangles.is_empty() {
                let message = "this shape has no surface: it has no triangle with an area";
                found.push(Diagnostic::warning("empty-shape", message).at(span, format!("{dropped} without area")));
            }
            Geometry::Mesh(Arc::new(mesh))
        }
        WorldGeometry::Analytic(mut surface) => {
            surface.rebase(origin);
            Geometry::Analytic(Arc::from(surface))
        }
    }
}

/// Coordinates must be numbers, and fit into single precision with room for their squares' sums.
fn check_range(shapes: &[Part], found: &mut Vec<Diagnostic>) {
    const LARGEST: f64 = 1e15;
    let fits = |p: DVec3| p.abs().cmple(DVec3::splat(LARGEST)).all();
    for shape in shapes {
        // Not the bounds of a mesh: they pass over what is not a number.
        let inside = match &shape.geometry {
            WorldGeometry::Mesh(mesh) => mesh.positions.iter().all(|p| fits(*p)),
            WorldGeometry::Analytic(surface) => surface.bounds().is_empty() || surface.bounds().corners().into_iter().all(fits),
        };
        if !inside {
            found.push(
                Diagnostic::error("out-of-range", "this shape reaches too far out")
                    .at(shape.span, format!("coordinates are at most {LARGEST:e}"))
                    .help("use a smaller scale for the whole scene"),
            );
        }
    }
}

/// Lights that shine from a point: not behind the horizon, and only for who samples lights (else: what helps). In world space.
fn check_points(lights: &[PartLight], samples: Result<(), (&str, &str)>, gravity: Option<&Gravity>, found: &mut Vec<Diagnostic>) {
    for (span, side, light) in lights.iter().filter_map(|l| Some((l.span, l.side, l.light.as_ref()?))) {
        let Some(position) = light.position() else {
            if let Err(help) = samples
                && light.sample_sky(Vec2::splat(0.5)).is_some_and(|s| s.is_parallel)
            {
                not_found(span, "no path leaves the scene in exactly its direction: only light sampling finds it", help, found);
            }
            continue;
        };
        let stands = gravity.is_none_or(|g| g.check_point(position, side, span, found));
        if let Err(help) = samples
            && stands
        {
            not_found(span, "no path meets a point: only light sampling finds it", help, found);
        }
    }
}

fn not_found(span: Span, why: &str, (message, help): (&str, &str), found: &mut Vec<Diagnostic>) {
    found.push(Diagnostic::warning("light-not-found", message).at(span, why).help(help));
}

fn warn_dark(lights: &[PartLight], area_lights: &[PartAreaLight], shapes: &[Part], found: &mut Vec<Diagnostic>) {
    // A light that could not be made has been reported; the scene is not dark for lack of one.
    let any =
        !lights.is_empty() || area_lights.iter().any(|l| l.light.is_none()) || shapes.iter().any(|s| s.area_light.is_some());
    if !any && !has_errors(found) {
        found.push(
            Diagnostic::warning("no-light", "nothing in the scene emits light: the picture will be black")
                .help("add `LightSource \"infinite\"`, or `AreaLightSource \"diffuse\"` before a shape"),
        );
    }
}
