//! What emits light. One file, one plugin: `ALL` lists the lights that are no surfaces, `AREA` the emissions of surfaces.

use bhs_core::diagnostics::Diagnostic;
use bhs_core::light::{AreaLight, Light};
use bhs_core::params::{Params, Point3};
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum};
use glam::{DMat3, DVec3};

mod diffuse;
mod distant;
mod from_point;
mod goniometric;
mod infinite;
mod page_thorne;
mod picture;
mod point;
mod projection;
mod sky_map;
mod spot;
mod stars;
mod thindisc;

/// Lights that are no surfaces, in alphabetical order.
pub const ALL: &[Plugin<dyn Light>] =
    &[distant::PLUGIN, goniometric::PLUGIN, infinite::PLUGIN, point::PLUGIN, projection::PLUGIN, spot::PLUGIN, stars::PLUGIN];

/// Emissions of surfaces, in alphabetical order.
pub const AREA: &[Plugin<dyn AreaLight>] = &[diffuse::PLUGIN, thindisc::PLUGIN];

/// The parameter `scale`, which multiplies what a light emits.
fn scale(p: &Params) -> f64 {
    p.get_in("scale", 1.0, 0.0..=f64::from(f32::MAX), "", "multiplies what it emits")
}

/// `scale` as a factor of `spectrum`, which the parameter `name` gives. Reports a light that is brighter than single precision can tell.
fn factor(p: &Params, name: &str, spectrum: &dyn Spectrum, scale: f64) -> f32 {
    let [lo, hi] = p.context().lambda_range;
    factor_of(p, name, spectrum.max(lo, hi).into(), scale)
}

/// The same for a light whose greatest value is `greatest`.
fn factor_of(p: &Params, name: &str, greatest: f64, scale: f64) -> f32 {
    let brightest = greatest * scale;
    if brightest.is_finite() && brightest <= f64::from(f32::MAX) && scale <= f64::from(f32::MAX) {
        return scale as f32;
    }
    let at = if p.is_given("scale") { "scale" } else { name };
    p.reject(
        at,
        format!("`{name}` times `scale` is too large"),
        format!("it is {brightest:.3e}, and light is at most {:.3e}", f32::MAX),
    );
    1.0
}

/// What the parameter `name`, if the scene gives it, multiplies a light with so that its strength, weighted by the eye, is the value:
/// `measure` times the luminance of `spectrum`. As films of bhs show luminance, `integral(L ybar) / integral(ybar)`, pictures are as
/// bright as those of pbrt-v4, which takes its `power` and `illuminance` in the same units.
fn rescale(p: &Params, name: &'static str, about: &'static str, spectrum: &dyn Spectrum, measure: f64) -> f64 {
    rescale_to(p, name, about, || measure * bhs_spectra::luminance(spectrum))
}

/// The same for a light of the strength `strength`.
fn rescale_to(p: &Params, name: &'static str, about: &'static str, strength: impl Fn() -> f64) -> f64 {
    let Some(wanted) = p.optional::<f64>(name, "", about) else { return 1.0 };
    if wanted <= 0.0 {
        p.reject(name, format!("`{name}` must be above 0"), format!("found {wanted}"));
        return 1.0;
    }
    let (strength, single) = (strength(), f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX));
    let factor = wanted / strength;
    if single.contains(&factor) {
        return factor;
    }
    let why = match strength > 0.0 {
        true => format!("the light has {strength:.3e}, and can be multiplied by {:.3e} to {:.3e}", single.start(), single.end()),
        false => "the eye sees nothing of this light".to_owned(),
    };
    p.reject(name, format!("`{name}` cannot be reached"), why);
    1.0
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

/// Turns directions of the chart into those of the space of a light that shines from a point, which may be scaled: directions alone count.
fn turn_to_light(p: &Params) -> DMat3 {
    p.context().world_from_object.matrix3.inverse()
}

/// Turns directions of the chart into those of a sky under the current transform: a rotation, mirrored or not. `None` after a report that it is
/// none.
fn sky_from_chart(p: &Params) -> Option<DMat3> {
    let m = p.context().world_from_object.matrix3;
    let scale = m.x_axis.length();
    let turn = m * scale.recip();
    let off = (turn.transpose() * turn - DMat3::IDENTITY).to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    // A matrix in a scene file has few digits.
    if off < 1e-3 {
        return Some(turn.transpose());
    }
    p.report(
        Diagnostic::error("bad-transform", "the current transform stretches the sky")
            .at(p.owner().span, "it can be turned and mirrored only")
            .help("put `LightSource` outside of the transform, or scale by the same factor in all directions"),
    );
    None
}

/// The mean of a spectrum over `lo..=hi`, in nm, by the midpoint rule with steps of at most a nanometre.
fn mean(spectrum: &dyn Spectrum, lo: f32, hi: f32) -> f64 {
    let n = (f64::from(hi - lo).ceil() as usize).clamp(1, 10_000);
    let step = f64::from(hi - lo) / n as f64;
    let sum: f64 = (0..n).map(|i| f64::from(spectrum.at((f64::from(lo) + (i as f64 + 0.5) * step) as f32))).sum();
    sum / n as f64
}

/// The mean over `lo..=hi` (nm) of what `of` has at the wavelengths that it is asked for, by the midpoint rule in 64 steps.
fn mean_of(of: impl Fn([f32; N_LAMBDA]) -> SampledSpectrum, lo: f32, hi: f32) -> f64 {
    const N: usize = 64;
    let wavelength = |i: usize| lo + (i as f32 + 0.5) / N as f32 * (hi - lo);
    let sum = |first: usize| of(std::array::from_fn(|k| wavelength(first + k))).0.into_iter().map(f64::from).sum::<f64>();
    (0..N).step_by(N_LAMBDA).map(sum).sum::<f64>() / N as f64
}

/// The luminance of what `of` has at the wavelengths that it is asked for, `integral(L ybar) / integral(ybar)`, in steps of a nanometre.
fn luminance_of(of: impl Fn([f32; N_LAMBDA]) -> SampledSpectrum) -> f64 {
    let rows = bhs_colour::standard_observer();
    let part = |rows: &[[f64; 4]]| {
        let lambda_nm = std::array::from_fn(|k| rows[k.min(rows.len() - 1)][0] as f32);
        rows.iter().zip(of(lambda_nm).0).map(|(row, value)| row[2] * f64::from(value)).sum::<f64>()
    };
    rows.chunks(N_LAMBDA).map(part).sum::<f64>() / bhs_colour::Y_INTEGRAL
}

#[cfg(test)]
bhs_core::every_file_is_listed!([ALL, AREA], helpers: ["from_point", "page_thorne", "picture", "sky_map"]);
