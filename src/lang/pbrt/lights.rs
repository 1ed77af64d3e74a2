//! Lights: pbrt-v4 makes what a spectrum emits a luminance of 1, which `scale` then multiplies.

use crate::lang::ast::Directive;
use crate::lang::params::{drop_all, find, float, name, set_floats, set_rgb, set_strings, take, take_float};
use crate::lang::pbrt::Translator;
use crate::lang::pbrt::colours::{self, Meaning};
use bhs_core::value::{Param, ParamType};
use bhs_elementary::Elementary;
use std::f64::consts::PI;

/// What pbrt-v4's lights know.
const KNOWN: &[&str] = &[
    "I",
    "L",
    "scale",
    "power",
    "illuminance",
    "from",
    "to",
    "coneangle",
    "conedeltaangle",
    "filename",
    "twosided",
    "portal",
    "fov",
];

impl Translator {
    /// `LightSource` and `AreaLightSource`.
    pub(super) fn light(&mut self, d: &mut Directive) {
        let (word, at) = (name(d).to_owned(), d.keyword.span);
        let known: &[&str] = match word.as_str() {
            "point" => &["I", "scale", "power", "from"],
            "spot" => &["I", "scale", "power", "from", "to", "coneangle", "conedeltaangle"],
            "distant" => &["L", "scale", "illuminance", "from", "to"],
            "infinite" => &["L", "scale", "illuminance", "filename", "portal"],
            "diffuse" => &["L", "scale", "power", "filename", "twosided"],
            "goniometric" => &["I", "scale", "power", "filename"],
            "projection" => &["scale", "power", "filename", "fov"],
            // One of our own.
            _ => return,
        };
        debug_assert!(known.iter().all(|k| KNOWN.contains(k)));
        self.inherit(d, "light", known);
        if word != "AreaLightSource" {
            self.check_motion(d);
        }
        colours::translate(d, self.state.space, |_| Meaning::Light);
        if drop_all(d, &["portal"]) {
            self.notes.ignored("portal", at, "it changes noise alone");
        }
        if let Some(param) = take(d, "mapname") {
            self.notes.warn("`mapname` is read as `filename`", param.name.span, "", "the name is that of pbrt-v3");
            d.params.push(Param { name: super::params::renamed(&param, "filename"), ..param });
        }
        let is_area = d.keyword.value == "AreaLightSource";
        let strength = if word == "distant" || word == "infinite" || is_area { "L" } else { "I" };
        let wanted = if word == "distant" || word == "infinite" { "illuminance" } else { "power" };
        let is_picture = find(d, "filename").is_some() && word != "goniometric";
        if float(d, wanted).is_some_and(|v| v <= 0.0) {
            take(d, wanted);
        }
        if find(d, strength).is_none() && !is_picture && word != "projection" {
            set_rgb(d, strength, [1.0; 3]);
        }
        if word == "infinite" && is_picture {
            set_strings(d, ParamType::String, "mapping", &["equalarea"]);
        }
        if is_picture || word == "projection" {
            return;
        }
        let measure = match word.as_str() {
            "distant" => 1.0,
            "infinite" => PI,
            "spot" => cone(d),
            _ => 4.0 * PI,
        };
        if colours::is_spectral(d, strength) {
            match (find(d, wanted), is_area, word.as_str()) {
                (Some(_), ..) => {}
                (None, true, _) => set_floats(d, "luminance", &[1.0]),
                // A picture shares the light out.
                (None, false, "goniometric") => set_floats(d, "luminance", &[1.0]),
                (None, ..) => set_floats(d, wanted, &[measure]),
            }
            return;
        }
        // Of a colour, pbrt takes the strength of white.
        let Some(lum) = find(d, strength).and_then(colours::luminance) else { return };
        let Some(value) = float(d, wanted) else { return };
        if is_area || word == "goniometric" {
            if lum > 0.0 {
                set_floats(d, wanted, &[value * lum]);
            } else {
                take(d, wanted);
            }
        } else if let Some(value) = take_float(d, wanted) {
            let scale = float(d, "scale").unwrap_or(1.0);
            set_floats(d, "scale", &[scale * value / measure]);
        }
    }
}

/// The solid angle that the cone of a `spot` counts for (sr).
fn cone(d: &Directive) -> f64 {
    let angle = float(d, "coneangle").unwrap_or(30.0);
    let delta = float(d, "conedeltaangle").unwrap_or(5.0);
    let cos = |degrees: f64| degrees.max(0.0).to_radians().cosine();
    let (outer, inner) = (cos(angle), cos(angle - delta));
    2.0 * PI * ((1.0 - inner) + 0.5 * (inner - outer))
}
