//! Textures of pbrt-v4.

use crate::lang::ast::Directive;
use crate::lang::params::{set_strings, set_text, text};
use crate::lang::pbrt::colours::{self, Meaning};
use crate::lang::pbrt::{Translated, Translator};
use bhs_core::diagnostics::shorten;
use bhs_core::value::ParamType;

impl Translator {
    /// `Texture`.
    pub(super) fn texture(&mut self, mut d: Directive, out: &mut Translated) {
        let at = d.keyword.span;
        if text(&d, 1).is_some_and(|t| t.value == "color") {
            set_text(&mut d, 1, "spectrum");
        }
        let plugin = text(&d, 2).map(|t| t.value.clone()).unwrap_or_default();
        let known: &[&str] = match plugin.as_str() {
            "imagemap" => &["filename", "wrap", "filter", "maxanisotropy", "encoding", "scale", "invert", "mapping"],
            "checkerboard" | "dots" | "bilerp" => &["mapping"],
            _ => &[],
        };
        self.inherit(&mut d, "texture", known);
        colours::translate(&mut d, self.state.space, |_| Meaning::Share);
        if plugin == "imagemap" && text(&d, 1).is_some_and(|t| t.value == "float") {
            set_strings(&mut d, ParamType::String, "channel", &["alpha"]);
        }
        if matches!(plugin.as_str(), "fbm" | "wrinkled") {
            set_strings(&mut d, ParamType::String, "mapping", &["space"]);
        }
        if plugin == "ptex" {
            let message = format!("the texture class `{}` is read as `constant`", shorten(&plugin));
            self.notes.warn(&message, at, "", "the picture lacks its pattern");
            set_text(&mut d, 2, "constant");
            d.params.clear();
            crate::lang::params::set_floats(&mut d, "value", &[0.5]);
        }
        out.directives.push(d);
    }
}
