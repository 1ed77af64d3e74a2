//! Causes in where the camera stands and looks.

use super::probe::{self, ProbeRay};
use super::shapes::is_within_horizon;
use super::{Explanation, Level, few_digits};
use crate::lang::BuiltScene;
use crate::render::Job;
use bhs_core::camera::CameraRay;
use bhs_core::geometry::Aabb;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_engine::stats::Counters;
use glam::{DVec2, DVec3, DVec4, Vec2};

/// Share of the rays that have to meet something once the points of `LookAt` are exchanged, and how far beyond where the camera stands now, over
/// its distance from the target: what is farther behind it is not what it was to look at.
const MEETS: f64 = 0.01;
const BEYOND: f64 = 1.3;

/// The rays of the camera if it stood at its target and looked back to where it stands.
pub fn back(built: &BuiltScene, job: &Job, rays: &[ProbeRay]) -> Vec<Ray> {
    let Some((_, look_at)) = built.camera_statement().and_then(|c| c.look_at) else { return Vec::new() };
    let (eye, target) = (job.camera.position(), look_at.target - built.scene.world.origin);
    let Some(forward) = (target - eye).try_normalize() else { return Vec::new() };
    let up = forward.any_orthonormal_vector();
    // Half a turn about an axis across the view.
    let turn = |v: DVec3| 2.0 * v.dot(up) * up - v;
    let turned = |seen: &CameraRay| CameraRay { origin: target + turn(seen.origin - eye), direction: turn(seen.direction) };
    rays.iter().filter_map(|r| probe::chart_ray(job, &turned(&r.seen))).collect()
}

/// Whether there is a surface that rays could meet.
fn anything_to_meet(built: &BuiltScene) -> bool {
    let world = &built.scene.world;
    (0..world.geometries.len() as u32).any(|number| !is_within_horizon(world, number))
}

/// What became of the rays of the whole frame: whether any met a surface, left the scene, fell into a hole.
fn fates(job: &Job, c: &Counters) -> [bool; 3] {
    let counted = [c.camera_hit, c.camera_escaped, c.camera_captured].map(|count| count > 0);
    if counted[0] || probe::is_whole(job) {
        return counted;
    }
    let rays: Vec<Ray> = probe::rays(job).iter().filter_map(|r| r.ray).collect();
    let mut fates = counted;
    for end in probe::trace(job, &rays) {
        match end.arrival {
            Arrival::Surface(_) => fates[0] = true,
            Arrival::Sky(..) => fates[1] = true,
            Arrival::Captured => fates[2] = true,
            Arrival::OutOfSteps => {}
        }
    }
    fates
}

/// Of a picture in which nothing but the hole is seen.
pub fn only_the_hole(built: &BuiltScene, job: &Job, c: &Counters) -> Option<Explanation> {
    let [false, false, true] = fates(job, c) else { return None };
    let statements = &built.statements;
    let place = statements.spacetime.as_ref().and_then(|s| statements.place(s.at));
    let place = place.map(|place| format!(" at {place}")).unwrap_or_default();
    let hole = built.scene.world.spacetime().captures().first().copied();
    let how_far = hole.map_or_else(String::new, |hole| {
        let distance = (built.camera.position() - hole.center).length();
        format!(", only {} away from the middle of a hole of radius {}", few_digits(distance), few_digits(hole.radius))
    });
    let camera = camera_place(built);
    Some(Explanation::warning(
        "only-the-hole",
        format!(
            "the picture is black: every camera ray falls into the hole{place}: the camera{camera} is too near{how_far}, or sees too little; move it \
             out, turn it, or give it a larger `fov`"
        ),
    ))
}

/// The camera's place in the text, in brackets.
pub fn camera_place(built: &BuiltScene) -> String {
    let camera = built.camera_statement();
    let at = camera.map(|c| c.look_at.map_or(c.camera.at, |(at, _)| at));
    at.and_then(|at| built.statements.place(at)).map(|place| format!(" ({place})")).unwrap_or_default()
}

/// Of a picture in which no surface is seen, though there are some, or none that could be lit.
pub fn nothing_met(built: &BuiltScene, job: &Job, c: &Counters, level: Level) -> Option<Explanation> {
    let [false, ..] = fates(job, c) else { return None };
    let black = if level == Level::Warning { "the picture is black: " } else { "" };
    if !anything_to_meet(built) {
        return (level == Level::Warning).then(|| nothing_there(built)).flatten();
    }
    let camera = camera_place(built);
    // Each side of a wormhole has a chart of its own.
    let half = built.scene.world.half(job.viewpoint.side);
    let Some(bounds) = half.map(|half| *half.bounds).filter(|bounds| !bounds.is_empty()) else {
        let text = format!(
            "{black}no camera ray meets a surface: all shapes are on the other side; look through the throat, or write another \
             `\"string side\"` into the camera{camera}"
        );
        return Some(Explanation { level, code: "nothing-met", text });
    };
    let to = bounds.center() - built.camera.position();
    let width = 0.5 * (bounds.max - bounds.min).length();
    // A sky may be looked at for its own sake, with something tiny in it.
    if level == Level::Note && width < 2.0 * built.camera.pixel_width(to.length()) {
        return None;
    }
    let forward = job.camera.ray(0.5 * DVec2::from_array(job.film.resolution().map(f64::from)), Vec2::splat(0.5)).direction;
    let middle = bounds.center() + built.scene.world.origin;
    let middle = middle.to_array().map(few_digits).join(" ");
    let (what, to_do) = if to.dot(forward) < 0.0 && to.length() > width {
        ("all shapes are behind the camera", format!("turn the camera{camera}: the middle of the shapes is {middle}"))
    } else if may_be_in_frame(built, job) {
        let what = "the camera looks past all shapes, or sees them edge-on, or they are smaller than a pixel";
        (what, format!("move the camera{camera}, or point it at the middle of the shapes, {middle}"))
    } else {
        ("the camera looks past all shapes", format!("point the camera{camera} at the middle of the shapes, {middle}"))
    };
    let to_do = match exchange_helps(built, job, &probe::rays(job)) {
        true => format!("exchange the first two points of `LookAt`{camera}, from and to: then some do"),
        false => to_do,
    };
    Some(Explanation { level, code: "nothing-met", text: format!("{black}no camera ray meets a surface: {what}; {to_do}") })
}

/// Whether any shape on the camera's side may be within the frame, as far as straight lines say: its box is not wholly beyond one of the edges.
fn may_be_in_frame(built: &BuiltScene, job: &Job) -> bool {
    let world = &built.scene.world;
    let Some(matrices) = job.camera.matrices() else { return true };
    let Some(screen_from_camera) = matrices.screen_from_camera else { return true };
    let may = |bounds: Aabb| {
        let corners = bounds.corners().map(|corner| matrices.camera_from_render.transform_point3(corner));
        let on_screen = corners.map(|corner| screen_from_camera * corner.extend(1.0));
        let beyond = |is: fn(DVec4) -> bool| on_screen.iter().all(|p| is(*p));
        !(corners.iter().all(|corner| corner.z <= 0.0)
            || beyond(|p| p.x < 0.0)
            || beyond(|p| p.x > p.w)
            || beyond(|p| p.y < 0.0)
            || beyond(|p| p.y > p.w))
    };
    let on_this_side = (0..world.geometries.len() as u32).filter(|number| world.side_of(*number) == job.viewpoint.side);
    on_this_side.map(|number| world.geometries[number as usize].bounds()).any(|bounds| !bounds.is_empty() && may(bounds))
}

/// Whether surfaces are seen from outside from the target of `LookAt` back, about where the camera stands.
fn exchange_helps(built: &BuiltScene, job: &Job, rays: &[ProbeRay]) -> bool {
    let Some((_, look_at)) = built.camera_statement().and_then(|c| c.look_at) else { return false };
    let target = look_at.target - built.scene.world.origin;
    let reach = BEYOND * (job.camera.position() - target).length();
    let is_near = |end: &RayEnd| match end.arrival {
        Arrival::Surface(hit) => {
            (hit.point - target).length() <= reach && built.scene.world.surface(&hit).normal.dot(hit.direction) < 0.0
        }
        _ => false,
    };
    let met = probe::trace(job, &back(built, job, rays)).iter().filter(|end| is_near(end)).count();
    met > 0 && met as f64 >= MEETS * rays.len() as f64
}

/// Of a scene that has light and nothing that it could fall on.
fn nothing_there(built: &BuiltScene) -> Option<Explanation> {
    let lights = &built.scene.light_sampler.lights;
    // A sky may be dark where the camera looks.
    let is_unseen = |light: &dyn bhs_core::light::Light| {
        let lambda = [450.0, 500.0, 550.0, 600.0];
        light.points().is_empty() && super::lights::directions(64).all(|d| light.sky_radiance(d, lambda).is_zero())
    };
    if !built.scene.world.geometries.is_empty() || lights.is_empty() || !lights.iter().all(|light| is_unseen(&**light)) {
        return None;
    }
    let first = super::light_words(built, 0);
    Some(Explanation::warning(
        "nothing-there",
        format!(
            "the picture is black: no camera ray meets a surface, for there is none, and {first} is seen only where it falls on something; add a \
             `Shape`, or a sky: LightSource \"infinite\""
        ),
    ))
}
