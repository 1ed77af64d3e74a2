//! Materials of pbrt-v4.

use crate::lang::ast::Directive;
use crate::lang::params::{drop_all, find, float, name, renamed, set_floats, set_rgb, set_strings, set_text, string};
use crate::lang::pbrt::colours::{self, Meaning};
use crate::lang::pbrt::{Translated, Translator};
use bhs_core::diagnostics::Span;
use bhs_core::value::{Param, ParamType, Values};
use bhs_elementary::Elementary;
use std::sync::Arc;

/// What pbrt-v4's materials know, apart from `displacement` and `normalmap`.
fn known(plugin: &str) -> &'static [&'static str] {
    match plugin {
        "diffuse" => &["reflectance"],
        "coateddiffuse" => &[
            "reflectance",
            "roughness",
            "uroughness",
            "vroughness",
            "remaproughness",
            "thickness",
            "eta",
            "g",
            "albedo",
            "maxdepth",
            "nsamples",
        ],
        "conductor" => &["reflectance", "eta", "k", "roughness", "uroughness", "vroughness", "remaproughness"],
        "dielectric" => &["eta", "roughness", "uroughness", "vroughness", "remaproughness"],
        "thindielectric" => &["eta"],
        "diffusetransmission" => &["reflectance", "transmittance", "scale"],
        "coatedconductor" => &[
            "interface.roughness",
            "interface.uroughness",
            "interface.vroughness",
            "interface.eta",
            "thickness",
            "conductor.eta",
            "conductor.k",
            "reflectance",
            "conductor.roughness",
            "conductor.uroughness",
            "conductor.vroughness",
            "remaproughness",
            "maxdepth",
            "nsamples",
            "g",
            "albedo",
        ],
        "mix" => &["materials", "amount"],
        "hair" => &["sigma_a", "reflectance", "color", "eumelanin", "pheomelanin", "eta", "beta_m", "beta_n", "alpha"],
        "subsurface" => &[
            "sigma_a",
            "sigma_s",
            "reflectance",
            "mfp",
            "name",
            "g",
            "scale",
            "eta",
            "roughness",
            "uroughness",
            "vroughness",
            "remaproughness",
        ],
        "measured" => &["filename"],
        _ => &[],
    }
}

/// Whether a material of pbrt-v4's looks at `displacement` and `normalmap`.
fn has_bumps(plugin: &str) -> bool {
    !matches!(plugin, "mix" | "hair" | "interface" | "none" | "")
}

impl Translator {
    /// `Material` and `MakeNamedMaterial`.
    pub(super) fn material(&mut self, mut d: Directive, out: &mut Translated) {
        let is_named = d.keyword.value == "MakeNamedMaterial";
        let plugin = match is_named {
            true => string(&d, "type").map(|s| s.value.clone()).unwrap_or_default(),
            false => name(&d).to_owned(),
        };
        let at = d.keyword.span;
        let plugin = match super::older::rename(&mut d, &plugin) {
            Some(new) => {
                self.notes.mapped(
                    "the material",
                    &plugin,
                    &format!("`{new}`"),
                    at,
                    "the name is that of pbrt-v3; gloss and clearness differ",
                );
                new.to_owned()
            }
            None => plugin,
        };
        self.inherit(&mut d, "material", known(&plugin));
        if has_bumps(&plugin) {
            self.inherit(&mut d, "material", &["displacement", "normalmap"]);
        } else {
            drop_all(&mut d, &["displacement", "normalmap"]);
        }
        colours::translate(&mut d, self.state.space, |name| match name {
            "reflectance" | "transmittance" | "albedo" | "color" => Meaning::Share,
            _ => Meaning::Number,
        });
        if find(&d, "normalmap").is_some() {
            // pbrt-v4 follows the normal map.
            drop_all(&mut d, &["displacement"]);
        }
        let ours = self.body(&mut d, &plugin, at);
        if is_named {
            if string(&d, "type").is_some_and(|s| s.value != ours) {
                set_strings(&mut d, ParamType::String, "type", &[ours]);
            }
        } else {
            set_text(&mut d, 0, ours);
            self.state.material = Some(Arc::new(d.clone()));
        }
        out.directives.push(d);
    }

    /// Translates the parameters of the material `plugin`; its name here.
    fn body<'p>(&mut self, d: &mut Directive, plugin: &'p str, at: Span) -> &'p str {
        match plugin {
            "coateddiffuse" => self.clear(d, at),
            "conductor" => copper(d, ["eta", "k"]),
            "coatedconductor" => {
                self.clear(d, at);
                drop_all(d, &["maxdepth", "nsamples"]);
                copper(d, ["conductor.eta", "conductor.k"]);
            }
            "" | "none" => {
                drop_all(d, &["eta"]);
                return "interface";
            }
            "hair" => {
                let colour = find(d, "reflectance").or_else(|| find(d, "color")).cloned();
                let dark = float(d, "eumelanin").unwrap_or(1.3);
                let red = float(d, "pheomelanin").unwrap_or(0.0);
                let stated = find(d, "sigma_a").filter(|p| p.ty.value == ParamType::Rgb).and_then(numbers_of);
                d.params.retain(|p| p.name.value == "type");
                self.notes.mapped(
                    "the material",
                    plugin,
                    "`diffuse`",
                    at,
                    "the picture lacks the gloss of the hair, and light through it",
                );
                match colour {
                    Some(param) => d.params.push(Param { name: renamed(&param, "reflectance"), ..param }),
                    // Absorption of the pigments, and the colour of hair that has it (d'Eon et al. 2011; Chiang et al. 2016, beta_n = 0.3).
                    None => {
                        let pigments = [0.419 * dark + 0.187 * red, 0.697 * dark + 0.4 * red, 1.37 * dark + 1.05 * red];
                        let colour = |s: f64| (-(s.max(0.0).sqrt() * 5.5)).exponential();
                        set_rgb(d, "reflectance", stated.unwrap_or(pigments).map(colour));
                    }
                }
                return "diffuse";
            }
            "subsurface" => {
                let colour = find(d, "reflectance").cloned();
                drop_all(d, &["sigma_a", "sigma_s", "mfp", "name", "g", "scale", "reflectance"]);
                self.notes.mapped("the material", plugin, "`coateddiffuse`", at, "the picture lacks the light within the body");
                match colour {
                    Some(param) => d.params.push(param),
                    None => set_rgb(d, "reflectance", [0.8; 3]),
                }
                if find(d, "eta").is_none() {
                    set_floats(d, "eta", &[1.33]);
                }
                return "coateddiffuse";
            }
            "measured" => {
                drop_all(d, &["filename"]);
                self.notes.mapped(
                    "the material",
                    plugin,
                    "`coateddiffuse` of a reflectance of 0.5",
                    at,
                    "the picture lacks its colour and gloss",
                );
                set_floats(d, "roughness", &[0.3]);
                return "coateddiffuse";
            }
            _ => {}
        }
        plugin
    }

    /// A coat without anything in it, as thick everywhere.
    fn clear(&mut self, d: &mut Directive, at: Span) {
        let zero = |p: &Param| matches!(&p.values, Values::Numbers { values, .. } if values.iter().all(|v| *v == 0.0));
        if find(d, "albedo").is_some_and(|p| !zero(p)) {
            self.notes.ignored("albedo", at, "the coat is clear");
        }
        drop_all(d, &["albedo", "g"]);
        if find(d, "thickness").is_some_and(|p| p.ty.value == ParamType::Texture) {
            drop_all(d, &["thickness"]);
            self.notes.ignored("thickness", at, "it is a texture: the coat is as thick everywhere, 0.01");
        }
    }
}

/// The three numbers of a parameter.
fn numbers_of(p: &Param) -> Option<[f64; 3]> {
    match &p.values {
        Values::Numbers { values, .. } => <[f64; 3]>::try_from(values.as_slice()).ok(),
        _ => None,
    }
}

/// The default of a metal: pbrt's tables of copper.
fn copper(d: &mut Directive, names: [&str; 2]) {
    if find(d, "reflectance").is_some() {
        return;
    }
    for (part, table) in names.into_iter().zip(["metal-Cu-pbrt-eta", "metal-Cu-pbrt-k"]) {
        if find(d, part).is_none() {
            set_strings(d, ParamType::Spectrum, part, &[table]);
        }
    }
}
