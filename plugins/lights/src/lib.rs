//! What emits light. One file, one plugin: `ALL` lists the lights that are no surfaces, `AREA` the emissions of surfaces.

use bhs_core::light::{AreaLight, Light};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::Spectrum;

mod diffuse;
mod infinite;
mod point;

/// Lights that are no surfaces, in alphabetical order.
pub const ALL: &[Plugin<dyn Light>] = &[infinite::PLUGIN, point::PLUGIN];

/// Emissions of surfaces, in alphabetical order.
pub const AREA: &[Plugin<dyn AreaLight>] = &[diffuse::PLUGIN];

/// The parameter `scale`, which multiplies what a light emits.
fn scale(p: &Params) -> f32 {
    let scale = p.get("scale", 1.0, "", "multiplies L") as f32;
    if (0.0..f32::INFINITY).contains(&scale) {
        return scale;
    }
    p.reject("scale", "`scale` must be a number from 0 up", if scale < 0.0 { "light cannot be negative" } else { "too large" });
    1.0
}

/// The mean of a spectrum over `lo..=hi`, in nm, by the midpoint rule with steps of at most a nanometre.
fn mean(spectrum: &dyn Spectrum, lo: f32, hi: f32) -> f32 {
    let n = (f64::from(hi - lo).ceil() as usize).clamp(1, 10_000);
    let step = f64::from(hi - lo) / n as f64;
    let sum: f64 = (0..n).map(|i| f64::from(spectrum.at((f64::from(lo) + (i as f64 + 0.5) * step) as f32))).sum();
    (sum / n as f64) as f32
}

#[cfg(test)]
bhs_core::every_file_is_listed!([ALL, AREA], helpers: []);
