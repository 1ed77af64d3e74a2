//! Materials that pbrt-v3 had under other names: files are about that were converted by half.

use crate::lang::ast::Directive;
use crate::lang::params::{drop_all, find, renamed, take};

/// Names of pbrt-v3, and ours.
const NAMES: &[(&str, &str)] = &[
    ("fourier", "coateddiffuse"),
    ("glass", "dielectric"),
    ("kdsubsurface", "subsurface"),
    ("matte", "diffuse"),
    ("metal", "conductor"),
    ("mirror", "mirror"),
    ("plastic", "coateddiffuse"),
    ("substrate", "coateddiffuse"),
    ("translucent", "diffusetransmission"),
    ("uber", "coateddiffuse"),
];

/// Gives the parameters of a material of pbrt-v3 the names of pbrt-v4; its own name there, if `plugin` is one.
pub(super) fn rename(d: &mut Directive, plugin: &str) -> Option<&'static str> {
    let (_, new) = NAMES.iter().find(|(old, _)| *old == plugin)?;
    let colour = if *new == "mirror" { "Kr" } else { "Kd" };
    let pairs = [(colour, "reflectance"), ("index", "eta"), ("bumpmap", "displacement")];
    for (old, name) in pairs {
        if let Some(param) = take(d, old)
            && find(d, name).is_none()
            && (*new != "dielectric" || name != "reflectance")
        {
            d.params.push(bhs_core::value::Param { name: renamed(&param, name), ..param });
        }
    }
    drop_all(d, &["Kd", "Ks", "Kr", "Kt", "opacity", "sigma", "bsdffile", "transmit", "reflect"]);
    Some(new)
}
