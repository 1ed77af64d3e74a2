//! Shapes of pbrt-v4, and the holes that `alpha` cuts into them.

use crate::lang::ast::Directive;
use crate::lang::params::{self, drop_all, find, name, named, number, set_strings, set_text, take};
use crate::lang::pbrt::{Translated, Translator};
use bhs_core::value::{Param, ParamType};
use std::sync::Arc;

/// What `Attribute "shape"` may state.
const KNOWN: &[&str] = &[
    "alpha",
    "radius",
    "zmin",
    "zmax",
    "phimax",
    "height",
    "innerradius",
    "width",
    "width0",
    "width1",
    "type",
    "basis",
    "degree",
    "splitdepth",
];

impl Translator {
    /// `Shape`.
    pub(super) fn shape(&mut self, mut d: Directive, out: &mut Translated) {
        let (plugin, at) = (name(&d).to_owned(), d.keyword.span);
        let known: Vec<&str> = match plugin.as_str() {
            "sphere" => vec!["alpha", "radius", "zmin", "zmax", "phimax"],
            "disk" => vec!["alpha", "height", "radius", "innerradius", "phimax"],
            "cylinder" => vec!["alpha", "radius", "zmin", "zmax", "phimax"],
            "curve" => vec!["alpha", "width", "width0", "width1", "type", "basis", "degree", "splitdepth"],
            _ => vec!["alpha"],
        };
        debug_assert!(known.iter().all(|k| KNOWN.contains(k)));
        self.inherit(&mut d, "shape", &known);
        self.check_motion(&d);
        match plugin.as_str() {
            "trianglemesh" | "bilinearmesh" => {
                drop_all(&mut d, &["S", "faceIndices"]);
                for old in ["st", "emissionfilename"] {
                    if drop_all(&mut d, &[old]) {
                        self.notes.ignored(old, at, "");
                    }
                }
            }
            "plymesh" if drop_all(&mut d, &["displacement", "edgelength", "displacement.edgelength"]) => {
                self.notes.ignored("displacement", at, "the picture lacks the bumps");
            }
            "loopsubdiv" => {
                drop_all(&mut d, &["scheme"]);
            }
            _ => {}
        }
        let Some(alpha) = take(&mut d, "alpha") else { return out.directives.push(d) };
        match number(&alpha) {
            Some(a) if a >= 1.0 => return out.directives.push(d),
            Some(a) if a <= 0.0 => {
                self.notes.warn("a shape with an `alpha` of 0 is left out", at, "nothing meets it", "");
                return;
            }
            _ => {}
        }
        self.cut_out(&d, alpha, out);
        out.directives.push(d);
        // What follows has the material itself again.
        if let Some(material) = &self.state.material {
            out.directives.push(match material.keyword.value.as_str() {
                "Material" => named("NamedMaterial", &self.uncut(material), at),
                _ => (**material).clone(),
            });
        }
    }

    /// The name of the current material where it has been given one.
    fn uncut(&self, material: &Arc<Directive>) -> String {
        let known = self.cut.iter().find(|(m, ..)| Arc::ptr_eq(m, material));
        known.map_or_else(String::new, |(.., name)| format!("{name} whole"))
    }

    /// Makes the current material one with holes.
    fn cut_out(&mut self, shape: &Directive, alpha: Param, out: &mut Translated) {
        let at = shape.keyword.span;
        let material = self.state.material.get_or_insert_with(|| Arc::new(named("Material", "diffuse", at))).clone();
        let same = |a: &Param, b: &Param| a.ty.value == b.ty.value && format!("{:?}", a.values) == format!("{:?}", b.values);
        if let Some((.., name)) = self.cut.iter().find(|(m, a, _)| Arc::ptr_eq(m, &material) && same(a, &alpha)) {
            return out.directives.push(named("NamedMaterial", name, at));
        }
        let name = format!("alpha: {}", self.cut.len() + 1);
        let whole = if material.keyword.value == "Material" {
            let known = self.cut.iter().find(|(m, ..)| Arc::ptr_eq(m, &material)).map(|(.., n)| format!("{n} whole"));
            known.unwrap_or_else(|| {
                let whole = format!("{name} whole");
                let mut made = (*material).clone();
                let plugin = params::name(&made).to_owned();
                "MakeNamedMaterial".clone_into(&mut made.keyword.value);
                set_text(&mut made, 0, &whole);
                set_strings(&mut made, ParamType::String, "type", &[&plugin]);
                out.directives.push(made);
                whole
            })
        } else {
            params::name(&material).to_owned()
        };
        let open = "alpha: nothing";
        if self.cut.is_empty() {
            let mut nothing = named("MakeNamedMaterial", open, at);
            set_strings(&mut nothing, ParamType::String, "type", &["interface"]);
            out.directives.push(nothing);
        }
        let mut mixed = named("MakeNamedMaterial", &name, at);
        set_strings(&mut mixed, ParamType::String, "type", &["mix"]);
        set_strings(&mut mixed, ParamType::String, "materials", &[open, &whole]);
        let span = alpha.name.span;
        mixed.params.push(Param { name: bhs_core::diagnostics::Spanned::new("amount".to_owned(), span), ..alpha.clone() });
        debug_assert!(find(&mixed, "amount").is_some());
        out.directives.extend([mixed, named("NamedMaterial", &name, at)]);
        self.cut.push((material, alpha, name));
    }
}
