//! What the materials of MTL files are here.

use super::ModelFile;
use super::picture::{Colour, let_through, set_number, texture};
use crate::lang::ast::Directive;
use crate::lang::params::{named, set, set_floats, set_rgb, set_strings};
use crate::lang::source::SourceMap;
use bhs_core::image::{Image, Texels};
use bhs_core::params::{Decoded, Files};
use bhs_core::value::{ParamType, Values};
use bhs_shapes::mtl::{Map, Material};
use std::any::TypeId;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Makes directives of materials.
pub(super) struct MtlTranslator<'t> {
    pub file: &'t ModelFile<'t>,
    pub sources: &'t SourceMap,
    /// Pictures that are not there.
    pub lost: BTreeSet<String>,
    /// Statements that are not read.
    pub unread: BTreeSet<String>,
}

/// Of `illum`: those that refract, or mirror as glass does.
const GLASS: [f64; 4] = [4.0, 6.0, 7.0, 9.0];
/// Refractive index of glass whose `Ni` says nothing.
const USUAL_INDEX: f64 = 1.5;

/// The mean of a picture's numbers, from 0 to 1, over some of its texels.
fn mean(image: &Image) -> [f64; 3] {
    const ABOUT: usize = 10_000;
    let count = image.width as usize * image.height as usize;
    let texel = |i: usize| match &image.texels {
        Texels::Bytes(t) => t[i].map(|c| f64::from(c) / f64::from(u8::MAX)),
        Texels::Words(t) => t[i].map(|c| f64::from(c) / f64::from(u16::MAX)),
        Texels::Floats(t) => t[i].map(f64::from),
    };
    // An odd step meets all columns of a picture whose width is even.
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    for i in (0..count).step_by((count / ABOUT) | 1) {
        sum.iter_mut().zip(texel(i)).for_each(|(sum, x)| *sum += x);
        n += 1.0;
    }
    sum.map(|x| x / n)
}

impl MtlTranslator<'_> {
    /// The directives that make a material the current one, with the light that it emits.
    pub fn material(&mut self, m: &Material) -> Vec<Directive> {
        let mut out = Vec::new();
        let prefix = format!("{}: {}", self.file.prefix, m.name);
        self.unread.extend(m.unread.iter().cloned());
        self.emission(m, &prefix, &mut out);
        let whole = self.surface(m, &prefix, &mut out);
        let whole = self.bumped(whole, m, &prefix, &mut out);
        let alpha = if self.is_glass(m) { (1.0, None) } else { self.alpha(m, &prefix, &mut out) };
        let_through(whole, (alpha.0, alpha.1.as_deref()), &prefix, &mut out);
        out
    }

    /// A material with the relief that the file gives it: normals, else heights in scene units.
    fn bumped(&mut self, mut whole: Directive, m: &Material, prefix: &str, out: &mut Vec<Directive>) -> Directive {
        const LARGEST: f64 = 1e6;
        let at = self.file.at;
        let given = ["norm", "map_Bump", "disp"].into_iter().find_map(|name| Some((name, m.maps.get(name)?)));
        let Some((statement, map)) = given else { return whole };
        let is_colour = statement == "norm" || (statement == "map_Bump" && self.holds_normals(map));
        let bump = map.bump.clamp(-LARGEST, LARGEST);
        if is_colour {
            if let Some((name, mut d)) = self.imagemap(map, false, statement, prefix) {
                set_strings(&mut d, ParamType::String, "encoding", &["linear"]);
                out.push(d);
                set_strings(&mut whole, ParamType::Texture, "normalmap", &[&name]);
                if bump != 1.0 {
                    set_floats(&mut whole, "normalmapscale", &[bump]);
                }
            }
            return whole;
        }
        let Some(mut height) = self.float_picture(map, statement, prefix, out) else { return whole };
        if bump != 1.0 {
            let name = format!("{prefix} height");
            let mut scaled = texture(&name, true, "product", at);
            set_strings(&mut scaled, ParamType::Texture, "tex1", &[&height]);
            set_floats(&mut scaled, "tex2", &[bump]);
            out.push(scaled);
            height = name;
        }
        set_strings(&mut whole, ParamType::Texture, "displacement", &[&height]);
        whole
    }

    /// Whether a picture is bluish as those of normals are: Blender writes `map_Bump` for these too.
    fn holds_normals(&self, map: &Map) -> bool {
        let Some(path) = self.file.find(&map.path, self.sources) else { return false };
        let decode = |bytes: &[u8]| bhs_textures::decode::decode(bytes).map(|image| Arc::new(image) as Decoded);
        let image = self.sources.decode(&path, self.file.at, TypeId::of::<Image>(), &decode);
        let Some(image) = image.ok().and_then(|image| image.downcast::<Image>().ok()) else { return false };
        let mean = mean(&image);
        mean[2] > 0.7 && (mean[0] - 0.5).abs() < 0.2 && (mean[1] - 0.5).abs() < 0.2
    }

    fn emission(&mut self, m: &Material, prefix: &str, out: &mut Vec<Directive>) {
        let factor = m.colours.get("Ke").map(|c| c.map(|x| x.max(0.0)));
        let picture = self.picture(m, "map_Ke", prefix, out);
        // Many programs write `Ke 0 0 0` for what does not shine, with a picture or without.
        if factor == Some([0.0; 3]) || (factor.is_none() && picture.is_none()) {
            return;
        }
        let mut light = named("AreaLightSource", "diffuse", self.file.at);
        Colour { factor, textures: picture.into_iter().collect() }.set(&mut light, "L", prefix, out);
        out.push(light);
    }

    /// The share of it that is there.
    fn alpha(&mut self, m: &Material, prefix: &str, out: &mut Vec<Directive>) -> (f64, Option<String>) {
        let d = m.numbers.get("d").map_or(1.0, |d| d.clamp(0.0, 1.0));
        let scaled = m.maps.get("map_d").map(|map| Map { gain: map.gain * d, ..map.clone() });
        (d, scaled.and_then(|map| self.float_picture(&map, "map_d", prefix, out)))
    }

    fn is_glass(&self, m: &Material) -> bool {
        let number = |name: &str| m.numbers.get(name).copied();
        if m.maps.contains_key("map_d") {
            // Leaves and fences, whatever `illum` says.
            return false;
        }
        let filters = m.colours.get("Tf").is_some_and(|c| *c != [1.0; 3]);
        match number("illum") {
            Some(illum) => GLASS.contains(&illum),
            None => number("Ni").is_some_and(|n| n > 1.0) && (filters || number("d").is_some_and(|d| d < 1.0)),
        }
    }

    /// What it does with light, but for how much of it is there.
    fn surface(&mut self, m: &Material, prefix: &str, out: &mut Vec<Directive>) -> Directive {
        let at = self.file.at;
        let number = |name: &str| m.numbers.get(name).copied();
        let share = |c: [f64; 3]| c.map(|x| x.clamp(0.0, 1.0));
        let index = number("Ni").filter(|n| (1.0..=10.0).contains(n) && *n > 1.0).unwrap_or(USUAL_INDEX);
        // Blinn's exponent, as the width of a distribution of facets: Walter et al. 2007, section 5.2.
        let width = number("Ns").map(|n| (2.0 / (n.max(0.0) + 2.0)).sqrt());
        let picture = self.picture(m, "map_Kd", prefix, out);
        let stated = m.colours.get("Kd").copied().map(share);
        let base = Colour { factor: stated.or(picture.is_none().then_some([0.5; 3])), textures: picture.into_iter().collect() };
        if self.is_glass(m) {
            let filter = m.colours.get("Tf").copied().map(share).filter(|c| *c != [1.0; 3] && *c != [0.0; 3]);
            let mut glass = named("Material", if filter.is_some() { "principled" } else { "dielectric" }, at);
            set_floats(&mut glass, "eta", &[index]);
            if let Some(filter) = filter {
                set_rgb(&mut glass, "reflectance", filter);
                set_floats(&mut glass, "transmission", &[1.0]);
                set_floats(&mut glass, "roughness", &[0.0]);
            }
            return glass;
        }
        const PHYSICAL: [&str; 4] = ["Pr", "Pm", "Pc", "Pcr"];
        if PHYSICAL.iter().any(|n| number(n).is_some()) || ["map_Pr", "map_Pm"].iter().any(|n| m.maps.contains_key(n)) {
            let mut d = named("Material", "principled", at);
            base.set(&mut d, "reflectance", prefix, out);
            for (name, own, map, default) in
                [("roughness", "Pr", "map_Pr", width.map_or(0.5, f64::sqrt)), ("metallic", "Pm", "map_Pm", 0.0)]
            {
                let picture = m.maps.get(map).cloned().and_then(|map_of| self.float_picture(&map_of, map, prefix, out));
                set_number(&mut d, name, number(own).unwrap_or(default).clamp(0.0, 1.0), picture.as_deref());
            }
            for (name, own) in [("clearcoat", "Pc"), ("clearcoatroughness", "Pcr")] {
                if let Some(value) = number(own) {
                    set_floats(&mut d, name, &[value.clamp(0.0, 1.0)]);
                }
            }
            set_floats(&mut d, "eta", &[index]);
            return d;
        }
        let shines = m.colours.get("Ks").is_some_and(|c| c.iter().any(|x| *x > 0.0));
        let is_matt = !shines || number("illum").is_some_and(|illum| illum <= 1.0);
        let mut d = named("Material", if is_matt { "diffuse" } else { "coateddiffuse" }, at);
        base.set(&mut d, "reflectance", prefix, out);
        if !is_matt {
            set_floats(&mut d, "eta", &[index]);
            set_floats(&mut d, "roughness", &[width.unwrap_or(0.5)]);
            set(&mut d, ParamType::Bool, "remaproughness", Values::Bools(vec![false]));
        }
        d
    }

    /// The texture of a picture of colours, if the material has it and it is there.
    fn picture(&mut self, m: &Material, statement: &str, prefix: &str, out: &mut Vec<Directive>) -> Option<String> {
        let map = m.maps.get(statement)?;
        let (name, d) = self.imagemap(map, false, statement, prefix)?;
        out.push(d);
        Some(name)
    }

    /// The same of numbers.
    fn float_picture(&mut self, map: &Map, statement: &str, prefix: &str, out: &mut Vec<Directive>) -> Option<String> {
        let (name, mut d) = self.imagemap(map, true, statement, prefix)?;
        let channel = match map.channel {
            Some('r') => "red",
            Some('g') => "green",
            Some('b') => "blue",
            Some('m') => "alpha",
            Some(_) => "mean",
            None if statement == "map_d" => "alpha",
            None => "mean",
        };
        set_strings(&mut d, ParamType::String, "channel", &[channel]);
        set_strings(&mut d, ParamType::String, "encoding", &["linear"]);
        out.push(d);
        Some(name)
    }

    fn imagemap(&mut self, map: &Map, is_float: bool, statement: &str, prefix: &str) -> Option<(String, Directive)> {
        let Some(path) = self.file.find(&map.path, self.sources) else {
            self.lost.insert(map.path.clone());
            return None;
        };
        let name = format!("{prefix} {statement}");
        let mut d = texture(&name, is_float, "imagemap", self.file.at);
        set_strings(&mut d, ParamType::String, "filename", &[&path]);
        let [su, sv] = map.scale;
        let [ou, ov] = map.offset;
        for (param, value, default) in [("uscale", su, 1.0), ("vscale", sv, 1.0), ("udelta", ou, 0.0), ("vdelta", ov, 0.0)] {
            if value != default {
                set_floats(&mut d, param, &[value]);
            }
        }
        if map.gain != 1.0 {
            set_floats(&mut d, "scale", &[map.gain.max(0.0)]);
        }
        if map.clamp {
            set_strings(&mut d, ParamType::String, "wrap", &["clamp"]);
        }
        Some((name, d))
    }
}
