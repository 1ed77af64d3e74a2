//! `BlackHole "schwarzschild"`: the one thing of a scene that is no plugin, because everything else knows it.

use crate::lang::description::Entity;
use crate::lang::parse::shorten;
use crate::lang::transform::uniform_scale;
use bhs_core::blackhole::BlackHole;
use bhs_core::diagnostics::{Diagnostic, did_you_mean};
use bhs_core::observer::FrameConvention;
use bhs_core::params::{Context, Params, Point3};
use glam::DVec3;

/// Reads the hole that `entity` describes, in world space. All that is wrong goes to `found`.
pub(super) fn build_hole(entity: &Entity, context: Context, found: &mut Vec<Diagnostic>) -> Option<BlackHole> {
    let before = found.len();
    if entity.name.value != "schwarzschild" {
        let help = match did_you_mean(&entity.name.value, ["schwarzschild"]) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "there is schwarzschild".to_owned(),
        };
        let message = format!("unknown black hole `{}`", shorten(&entity.name.value));
        found.push(Diagnostic::error("unknown-plugin", message).at(entity.name.span, "").help(help));
        return None;
    }
    let p = Params::new(entity.name.clone(), &entity.params, context);
    let center = p.get("center", Point3(DVec3::ZERO), "scene", "centre, under the current transform");
    let rs = p.require::<f64>("rs", "scene", "Schwarzschild radius, under the current transform");
    let redshift = p.get("redshift", true, "", "whether wavelengths and radiance shift along a ray");
    let radiance = p.get("radiance", "full".to_owned(), "", "what redshift does to radiance: `full`, or `shift-only`: nothing");
    let frame = p.get("frame", "static".to_owned(), "", "whose angles count: `static` observers' or the `chart`'s");
    if rs.is_some_and(|rs| rs < 0.0) {
        p.reject("rs", "`rs` is negative", "expected 0 or more");
    }
    let frame = match frame.as_str() {
        "static" => FrameConvention::Static,
        "chart" => FrameConvention::Chart,
        _ => {
            p.reject("frame", format!("unknown frame `{}`", shorten(&frame)), "expected `static` or `chart`");
            FrameConvention::Static
        }
    };
    let radiance_shift = match radiance.as_str() {
        "full" => true,
        "shift-only" => false,
        _ => {
            p.reject("radiance", format!("unknown radiance `{}`", shorten(&radiance)), "expected `full` or `shift-only`");
            true
        }
    };
    found.extend(p.finish().0.into_iter().filter(|d| !(entity.faulty && d.code == "missing-parameter")));

    let Some(scale) = uniform_scale(&entity.world_from_object) else {
        found.push(
            Diagnostic::error("bad-transform", "the current transform stretches the black hole")
                .at(entity.keyword, "a Schwarzschild hole is round")
                .help("put `BlackHole` outside of the transform, or scale by the same factor in all directions"),
        );
        return None;
    };
    let center = entity.world_from_object.transform_point3(center.0);
    let hole = BlackHole { center, rs: rs? * scale, redshift, radiance_shift, frame };
    if !hole.center.is_finite() || !hole.rs.is_finite() {
        found.push(Diagnostic::error("out-of-range", "the black hole is out of range").at(entity.keyword, ""));
    }
    (found.len() == before).then_some(hole)
}
