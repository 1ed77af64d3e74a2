//! Textures of pictures, and products of colours with them.

use crate::lang::ast::{Arg, Directive};
use crate::lang::params::{named, set_floats, set_rgb, set_strings};
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::value::{ParamType, Values};

/// A texture that the scene does not name itself.
pub(super) fn texture(name: &str, is_float: bool, plugin: &str, at: Span) -> Directive {
    let mut d = named("Texture", name, at);
    let words = [if is_float { "float" } else { "spectrum" }, plugin];
    d.args.extend(words.map(|word| Arg { values: Values::Strings(vec![Spanned::new(word.to_owned(), at)]), span: at }));
    d
}

/// A colour that may vary: a factor, and a texture that it multiplies.
#[derive(Clone, Debug, Default)]
pub(super) struct Colour {
    pub factor: Option<[f64; 3]>,
    pub textures: Vec<String>,
}

impl Colour {
    /// Gives a directive this colour as the parameter `name`; textures that this takes go to `out`, under names that begin with `prefix`.
    pub fn set(&self, d: &mut Directive, name: &str, prefix: &str, out: &mut Vec<Directive>) {
        let at = d.keyword.span;
        let Some((first, rest)) = self.textures.split_first() else {
            return set_rgb(d, name, self.factor.unwrap_or([1.0; 3]));
        };
        let mut whole = first.clone();
        let factor = self.factor.filter(|f| *f != [1.0; 3]);
        let others = rest.iter().map(|other| (Some(other), [0.0; 3])).chain(factor.map(|f| (None, f)));
        for (i, (other, factor)) in others.enumerate() {
            let product_name = format!("{prefix} {name} {i}");
            let mut product = texture(&product_name, false, "product", at);
            set_strings(&mut product, ParamType::Texture, "tex1", &[&whole]);
            match other {
                Some(other) => set_strings(&mut product, ParamType::Texture, "tex2", &[other]),
                None => set_rgb(&mut product, "tex2", factor),
            }
            out.push(product);
            whole = product_name;
        }
        set_strings(d, ParamType::Texture, name, &[&whole]);
    }
}

/// A number that may vary: a texture where there is one, which has its factor already.
pub(super) fn set_number(d: &mut Directive, name: &str, value: f64, texture: Option<&str>) {
    match texture {
        Some(texture) => set_strings(d, ParamType::Texture, name, &[texture]),
        None => set_floats(d, name, &[value]),
    }
}

/// What `whole` becomes where only a share of it is there, and the rest of the light goes straight through: the directives that make it the
/// current material.
pub(super) fn let_through(whole: Directive, (alpha, texture): (f64, Option<&str>), prefix: &str, out: &mut Vec<Directive>) {
    if alpha >= 1.0 && texture.is_none() {
        return out.push(whole);
    }
    let at = whole.keyword.span;
    let [nothing, kept] = ["nothing", "whole"].map(|part| format!("{prefix} {part}"));
    let plugin = crate::lang::params::name(&whole).to_owned();
    let mut of_nothing = named("MakeNamedMaterial", &nothing, at);
    set_strings(&mut of_nothing, ParamType::String, "type", &["interface"]);
    let mut of_whole = whole;
    "MakeNamedMaterial".clone_into(&mut of_whole.keyword.value);
    crate::lang::params::set_text(&mut of_whole, 0, &kept);
    set_strings(&mut of_whole, ParamType::String, "type", &[&plugin]);
    let mut mixed = named("Material", "mix", at);
    set_strings(&mut mixed, ParamType::String, "materials", &[&nothing, &kept]);
    set_number(&mut mixed, "amount", alpha.clamp(0.0, 1.0), texture);
    out.extend([of_nothing, of_whole, mixed]);
}
