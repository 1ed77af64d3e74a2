//! What emits light. One file, one plugin: `ALL` lists the lights that are no surfaces, `AREA` the emissions of surfaces.

use bhs_core::light::{AreaLight, Light};
use bhs_core::params::{Params, Point3};
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::Spectrum;
use glam::DVec3;

mod diffuse;
mod distant;
mod infinite;
mod point;
mod sky_map;
mod spot;

/// Lights that are no surfaces, in alphabetical order.
pub const ALL: &[Plugin<dyn Light>] = &[distant::PLUGIN, infinite::PLUGIN, point::PLUGIN, spot::PLUGIN];

/// Emissions of surfaces, in alphabetical order.
pub const AREA: &[Plugin<dyn AreaLight>] = &[diffuse::PLUGIN];

/// The parameter `scale`, which multiplies what a light emits.
fn scale(p: &Params) -> f32 {
    let scale = p.get("scale", 1.0, "", "multiplies what it emits") as f32;
    if (0.0..f32::INFINITY).contains(&scale) {
        return scale;
    }
    p.reject("scale", "`scale` must be a number from 0 up", if scale < 0.0 { "light cannot be negative" } else { "too large" });
    1.0
}

/// What the parameter `name`, if the scene gives it, multiplies a light with so that its strength, weighted by the eye, is the value:
/// `measure` times the luminance of `spectrum`. As films of bhs show luminance, `integral(L ybar) / integral(ybar)`, pictures are as
/// bright as those of pbrt-v4, which takes its `power` and `illuminance` in the same units.
fn rescale(p: &Params, name: &'static str, about: &'static str, spectrum: &dyn Spectrum, measure: f64) -> f32 {
    rescale_to(p, name, about, || measure * bhs_spectra::luminance(spectrum))
}

/// The same for a light of the strength `strength`.
fn rescale_to(p: &Params, name: &'static str, about: &'static str, strength: impl Fn() -> f64) -> f32 {
    match p.optional::<f64>(name, "", about) {
        None => 1.0,
        Some(wanted) if wanted <= 0.0 => {
            p.reject(name, format!("`{name}` must be above 0"), format!("found {wanted}"));
            1.0
        }
        Some(wanted) => {
            let factor = (wanted / strength()) as f32;
            if factor.is_finite() {
                return factor;
            }
            p.reject(name, format!("`{name}` cannot be reached"), "the eye sees nothing of this light");
            1.0
        }
    }
}

/// The parameters `from` and `to`, about which `about` says what they are: the one in world space, and the unit direction to the other.
/// `None` after a report that there is none.
fn aim(p: &Params, about: [&'static str; 2]) -> Option<(DVec3, DVec3)> {
    let from = p.get("from", Point3(DVec3::ZERO), "scene", about[0]);
    let to = p.get("to", Point3(DVec3::Z), "scene", about[1]);
    let transform = p.context().world_from_object;
    let direction = transform.transform_vector3(to.0 - from.0).try_normalize();
    if direction.is_none() {
        p.reject("to", "`from` and `to` are the same point", "no direction leads from one to the other");
    }
    Some((transform.transform_point3(from.0), direction?))
}

/// The mean of a spectrum over `lo..=hi`, in nm, by the midpoint rule with steps of at most a nanometre.
fn mean(spectrum: &dyn Spectrum, lo: f32, hi: f32) -> f32 {
    let n = (f64::from(hi - lo).ceil() as usize).clamp(1, 10_000);
    let step = f64::from(hi - lo) / n as f64;
    let sum: f64 = (0..n).map(|i| f64::from(spectrum.at((f64::from(lo) + (i as f64 + 0.5) * step) as f32))).sum();
    (sum / n as f64) as f32
}

#[cfg(test)]
bhs_core::every_file_is_listed!([ALL, AREA], helpers: ["sky_map"]);
