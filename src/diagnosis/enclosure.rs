//! A camera that is shut in.

use super::lights::{self, directions};
use super::shadows::Survey;
use super::view::{back, camera_place};
use super::{Explanation, probe, shape_words};
use crate::lang::BuiltScene;
use crate::render::Job;
use bhs_core::camera::CameraRay;
use bhs_core::ray::{Arrival, Ray};
use std::collections::BTreeMap;

/// Directions in which is looked.
const AROUND: u32 = 192;

/// Of a picture that shows the inside of something into which no light comes.
pub fn around_the_camera(built: &BuiltScene, survey: &Survey) -> Option<Explanation> {
    let job = Job::of(built);
    let [index] = shapes_around(built, &job)?[..] else {
        // A room of several shapes, with no light in it.
        let (index, _) = survey.most_seen()?;
        return survey.no_light_in_sight().then(|| {
            Explanation::warning(
                "camera-shut-in",
                format!(
                    "the picture is black: the camera{} is inside a closed object of several shapes, such as {}, and no light is in there with it; put a light inside, \
                     leave an opening, or move the camera out",
                    camera_place(built),
                    shape_words(built, index)
                ),
            )
        });
    };
    let shape = shape_words(built, index);
    let to_do = match lights::emits(built, index) {
        true => "it shines outwards: write `ReverseOrientation` before the shape, or \"bool twosided\" true in its area light",
        false if !survey.no_light_in_sight() => return None,
        false => "no light is in there with it: move the camera out, make the object smaller, or put a light inside",
    };
    let look_at = match exchange_leads_out(built, &job, index) {
        true => "; or are from and to of `LookAt` exchanged?",
        false => "",
    };
    let camera = camera_place(built);
    Some(Explanation::warning(
        "camera-inside",
        format!("the picture is black: the camera{camera} is inside a closed object, {shape}, and {to_do}{look_at}"),
    ))
}

/// The `Shape` directives whose surfaces are all around the camera; `None` if there is an opening, or a hole.
fn shapes_around(built: &BuiltScene, job: &Job) -> Option<Vec<u32>> {
    let origin = built.camera.position();
    let rays: Option<Vec<Ray>> =
        directions(AROUND).map(|direction| probe::chart_ray(job, &CameraRay { origin, direction })).collect();
    let mut met: BTreeMap<u32, u32> = BTreeMap::new();
    for end in probe::trace(job, &rays?) {
        match end.arrival {
            Arrival::Surface(hit) => *met.entry(built.scene.shapes[hit.geometry as usize].index).or_default() += 1,
            Arrival::Captured => {}
            Arrival::Sky(..) | Arrival::OutOfSteps => return None,
        }
    }
    let most = *met.values().max()?;
    // Other things may be in there too.
    let main: Vec<u32> = met.iter().filter(|(_, count)| **count == most).map(|(index, _)| *index).collect();
    Some(if most * 10 >= AROUND * 9 { main } else { met.into_keys().collect() })
}

/// Whether the camera sees the shape from outside if it stands at its target and looks back.
fn exchange_leads_out(built: &BuiltScene, job: &Job, index: u32) -> bool {
    let ends = probe::trace(job, &back(built, job, &probe::rays(job)));
    let meets = |end: &bhs_core::ray::RayEnd| match end.arrival {
        Arrival::Surface(hit) => Some(
            built.scene.shapes[hit.geometry as usize].index == index && {
                let normal = built.scene.world.surface(&hit).normal;
                normal.dot(hit.direction) < 0.0
            },
        ),
        _ => None,
    };
    let outside = ends.iter().filter(|end| meets(end) == Some(true)).count();
    !ends.is_empty() && outside > 0 && ends.iter().all(|end| meets(end) != Some(false))
}
