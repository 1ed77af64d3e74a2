//! Causes in where the camera stands and looks.

use super::probe::{self, ProbeRay};
use super::shapes::is_within_horizon;
use super::{Explanation, Level, few_digits};
use crate::lang::BuiltScene;
use crate::render::Job;
use bhs_core::camera::CameraRay;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_engine::stats::Counters;
use glam::{DVec2, DVec3, Vec2};

/// Code of a `LookAt` whose points are exchanged.
pub const EXCHANGED: &str = "look-at-exchanged";

/// Share of the rays that have to meet something once the points of `LookAt` are exchanged, and how far beyond where the camera stands now, over
/// its distance from the target: what is farther behind it is not what it was to look at.
const MEETS: f64 = 0.01;
const BEYOND: f64 = 1.3;

/// Warns of a `LookAt` whose first point is the second one: no ray meets a surface, and from the other point back some do.
pub fn exchanged(built: &BuiltScene) -> Option<Diagnostic> {
    let (at, _) = built.camera_statement()?.look_at?;
    let job = Job::of(built);
    if !anything_to_meet(built) {
        return None;
    }
    let rays = probe::rays(&job);
    let charted: Vec<Ray> = rays.iter().filter_map(|r| r.ray).collect();
    if charted.is_empty() || probe::any_meets(&job, &charted) {
        return None;
    }
    if !exchange_helps(built, &job, &rays) {
        return None;
    }
    let message = "no camera ray meets a surface, and with from and to of `LookAt` exchanged some do";
    Some(
        Diagnostic::warning(EXCHANGED, message)
            .at(at.span, "the camera stands at the first point and looks at the second one")
            .help("exchange the first two points of `LookAt`: first where the camera is, then what it looks at"),
    )
}

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
    let bounds = built.scene.world.bounds;
    if bounds.is_empty() {
        let text = format!(
            "{black}no camera ray meets a surface: all shapes are on the other side; look through the throat, or add `\"string side\"` to the camera{camera}"
        );
        return Some(Explanation { level, code: "nothing-met", text });
    }
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
    } else {
        ("the camera looks past all shapes", format!("point the camera{camera} at the middle of the shapes, {middle}"))
    };
    let to_do = match exchange_helps(built, job, &probe::rays(job)) {
        true => format!("exchange the first two points of `LookAt`{camera}, from and to: then some do"),
        false => to_do,
    };
    Some(Explanation { level, code: "nothing-met", text: format!("{black}no camera ray meets a surface: {what}; {to_do}") })
}

/// Whether surfaces are seen from the target of `LookAt` back, about where the camera stands.
fn exchange_helps(built: &BuiltScene, job: &Job, rays: &[ProbeRay]) -> bool {
    let Some((_, look_at)) = built.camera_statement().and_then(|c| c.look_at) else { return false };
    let target = look_at.target - built.scene.world.origin;
    let reach = BEYOND * (job.camera.position() - target).length();
    let is_near = |end: &RayEnd| matches!(end.arrival, Arrival::Surface(hit) if (hit.point - target).length() <= reach);
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
