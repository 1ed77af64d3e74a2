//! The materials of a file as named materials, textures and area lights.

use crate::lang::ast::Directive;
use crate::lang::models::picture::{Colour, let_through, texture};
use crate::lang::models::{ModelFile, few};
use crate::lang::params::{named, set, set_floats, set_strings};
use crate::lang::source::SourceMap;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::value::{ParamType, Values};
use bhs_elementary::Elementary;
use bhs_models::Model;
use bhs_models::gltf::accessor::Dimensions;
use bhs_models::gltf::texture::WrappingMode;
use bhs_models::gltf::{Primitive, Semantic};
use bhs_models::material::{AlphaMode, Number, Picture, Surface, surface};
use bhs_models::picture::{Place, place};
use std::collections::{BTreeMap, BTreeSet};

/// What a part of a mesh is made of.
#[derive(Clone, Default)]
pub(super) struct Made {
    /// The name of its material; `None`: the current one.
    pub material: Option<String>,
    /// The directives of the light that it emits.
    pub light: Vec<Directive>,
    /// The sets of texture coordinates that its pictures lie by.
    pub uv_sets: [Option<u32>; 2],
    /// Which of these its normal map lies by.
    pub normal_map: Option<usize>,
}

/// Whether vertices have colours, and whether these say how opaque they are.
type Painted = (bool, bool);

/// The materials of a file, each made when it is first needed.
pub(super) struct Surfaces<'s> {
    file: &'s ModelFile<'s>,
    model: &'s Model,
    sources: &'s SourceMap,
    with_materials: bool,
    out: Vec<Directive>,
    made: BTreeMap<(Option<usize>, Painted), Made>,
    /// Names of textures by what they are.
    textures: BTreeMap<String, String>,
    /// The sets of texture coordinates of the material that is being made.
    sets: [Option<u32>; 2],
    /// What is left out, with the materials that have it.
    left_out: BTreeMap<&'static str, BTreeSet<String>>,
    lost: BTreeSet<String>,
    faults: BTreeSet<String>,
}

/// What a picture is read as.
#[derive(Clone, Copy, Debug)]
enum Channel {
    /// A colour.
    Colour,
    /// A number of linear values, by the word of `imagemap`.
    Number(&'static str),
    /// A normal.
    Normal,
}

fn share(x: f32) -> f64 {
    f64::from(if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) })
}

fn bounded(x: f64) -> f64 {
    if x.is_finite() { x.clamp(-1e9, 1e9) } else { 0.0 }
}

fn boolean(d: &mut Directive, name: &str, value: bool) {
    set(d, ParamType::Bool, name, Values::Bools(vec![value]));
}

impl<'s> Surfaces<'s> {
    pub fn new(file: &'s ModelFile<'s>, model: &'s Model, sources: &'s SourceMap, with_materials: bool) -> Self {
        let (out, made, textures) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        let (left_out, lost, faults) = (BTreeMap::new(), BTreeSet::new(), BTreeSet::new());
        Self { file, model, sources, with_materials, out, made, textures, sets: [None; 2], left_out, lost, faults }
    }

    /// What a part of a mesh is made of.
    pub fn of(&mut self, primitive: &Primitive) -> Made {
        if !self.with_materials {
            return Made::default();
        }
        let colours = primitive.get(&Semantic::Colors(0));
        let painted = (colours.is_some(), colours.is_some_and(|a| a.dimensions() == Dimensions::Vec4));
        let key = (primitive.material().index(), painted);
        if let Some(made) = self.made.get(&key) {
            return made.clone();
        }
        let made = match surface(self.model, key.0) {
            Ok(surface) => self.make(&surface, key),
            Err(fault) => {
                self.faults.insert(fault);
                Made::default()
            }
        };
        self.made.insert(key, made.clone());
        made
    }

    /// The directives that make all of them, and what is to be said.
    pub fn finish(self) -> (Vec<Directive>, Vec<Diagnostic>) {
        let path = self.file.path;
        let mut said = Vec::new();
        for (what, materials) in &self.left_out {
            let message = format!("`{path}`: {what} are left out of {}", few(materials.iter().map(String::as_str)));
            said.push(self.file.warning("left-out", message, ""));
        }
        if !self.lost.is_empty() {
            let message = format!("pictures of `{path}` are not there: {}", few(self.lost.iter().map(String::as_str)));
            said.push(self.file.warning("lost-pictures", message, "its materials do without them"));
        }
        let fault = |why: &String| Diagnostic::error("bad-file", format!("cannot read `{path}`: {why}")).at(self.file.at, "");
        said.extend(self.faults.iter().map(fault));
        (self.out, said)
    }

    fn make(&mut self, s: &Surface, (index, painted): (Option<usize>, Painted)) -> Made {
        let name = match index.and_then(|i| self.model.document.materials().nth(i)) {
            None => "default".to_owned(),
            Some(m) => format!("{} {}", m.index().unwrap_or_default(), m.name().unwrap_or_default()).trim_end().to_owned(),
        };
        for what in &s.left_out {
            self.left_out.entry(what).or_default().insert(name.clone());
        }
        let kind = match painted {
            (false, _) => "",
            (true, false) => ", painted",
            (true, true) => ", painted with opacity",
        };
        let prefix = format!("{}: material {name}{kind}", self.file.prefix);
        self.sets = s.uv_sets();
        let alpha = self.alpha(s, painted, &prefix);
        let base = self.base(s, painted);
        let light = self.light(s, (&base, painted.0), &alpha, &prefix, &name);
        let whole = self.surface(s, &base, &prefix);
        let material = format!("{prefix} ");
        let mut directives = Vec::new();
        let (amount, picture) = alpha;
        let_through(whole, (amount, picture.as_deref()), &prefix, &mut directives);
        // The last one is the material itself, which gets a name.
        if let Some(mut last) = directives.pop() {
            let plugin = crate::lang::params::name(&last).to_owned();
            "MakeNamedMaterial".clone_into(&mut last.keyword.value);
            crate::lang::params::set_text(&mut last, 0, &material);
            set_strings(&mut last, ParamType::String, "type", &[&plugin]);
            directives.push(last);
        }
        self.out.extend(directives);
        Made { material: Some(material), light, uv_sets: self.sets, normal_map: self.set_of(s.normal.picture.as_ref()) }
    }

    fn base(&mut self, s: &Surface, painted: Painted) -> Colour {
        let mut textures: Vec<String> = s.base_picture.iter().filter_map(|p| self.picture(p, Channel::Colour, 1.0)).collect();
        if painted.0 {
            textures.push(self.vertex_colours(false));
        }
        Colour { factor: Some([0, 1, 2].map(|i| share(s.base[i]))), textures }
    }

    /// The share of the surface that is there.
    fn alpha(&mut self, s: &Surface, painted: Painted, prefix: &str) -> (f64, Option<String>) {
        if s.alpha_mode == AlphaMode::Opaque {
            return (1.0, None);
        }
        let factor = share(s.base[3]);
        let mut picture = s.base_picture.as_ref().and_then(|p| self.picture(p, Channel::Number("opacity"), factor));
        if painted.1 {
            let vertices = self.vertex_colours(true);
            let name = format!("{prefix} opacity");
            let mut product = texture(&name, true, "product", self.file.at);
            set_strings(&mut product, ParamType::Texture, "tex1", &[&vertices]);
            match &picture {
                Some(picture) => set_strings(&mut product, ParamType::Texture, "tex2", &[picture]),
                None => set_floats(&mut product, "tex2", &[factor]),
            }
            self.out.push(product);
            picture = Some(name);
        }
        if s.alpha_mode != AlphaMode::Mask {
            return (factor, picture);
        }
        let Some(picture) = picture else { return (f64::from(factor >= f64::from(s.cutoff)), None) };
        let name = format!("{prefix} mask");
        let mut mask = texture(&name, true, "threshold", self.file.at);
        set_strings(&mut mask, ParamType::Texture, "tex", &[&picture]);
        set_floats(&mut mask, "cutoff", &[bounded(f64::from(s.cutoff))]);
        self.out.push(mask);
        (1.0, Some(name))
    }

    /// The directives of what it emits: its emission, or all that is seen of it if no light counts. What lets light through emits as much less.
    fn light(
        &mut self,
        s: &Surface,
        (base, is_painted): (&Colour, bool),
        (amount, opacity): &(f64, Option<String>),
        prefix: &str,
        name: &str,
    ) -> Vec<Directive> {
        let mut colour = if s.unlit {
            let mut textures = base.textures.clone();
            if is_painted {
                self.left_out.entry("colours of vertices, which do not shine,").or_default().insert(name.to_owned());
                // The last one is that of the vertices.
                textures.pop();
            }
            Colour { factor: base.factor, textures }
        } else {
            let factor = s.emissive.map(|e| if e.is_nan() { 0.0 } else { f64::from(e).clamp(0.0, 1e30) });
            if factor == [0.0; 3] {
                return Vec::new();
            }
            let textures = s.emissive_picture.iter().filter_map(|p| self.picture(p, Channel::Colour, 1.0)).collect();
            Colour { factor: Some(factor), textures }
        };
        let (mut out, mut d) = (Vec::new(), named("AreaLightSource", "diffuse", self.file.at));
        if *amount < 1.0 && opacity.is_none() {
            colour.factor = colour.factor.map(|c| c.map(|x| x * amount));
        }
        colour.set(&mut d, "L", prefix, &mut out);
        if let Some(opacity) = opacity {
            let covered = format!("{prefix} light");
            let mut scaled = texture(&covered, false, "scale", self.file.at);
            let mut light = d.params.remove(0);
            "tex".clone_into(&mut light.name.value);
            scaled.params.push(light);
            set_strings(&mut scaled, ParamType::Texture, "scale", &[opacity]);
            out.push(scaled);
            set_strings(&mut d, ParamType::Texture, "L", &[&covered]);
        }
        if s.double_sided {
            boolean(&mut d, "twosided", true);
        }
        // Textures are defined once, with the materials.
        self.out.append(&mut out);
        vec![d]
    }

    /// What it does with light, but for how much of it is there.
    fn surface(&mut self, s: &Surface, base: &Colour, prefix: &str) -> Directive {
        let mut d = named("Material", "principled", self.file.at);
        if s.unlit {
            let mut black = named("Material", "principled", self.file.at);
            set_floats(&mut black, "reflectance", &[0.0]);
            set_floats(&mut black, "specular", &[0.0]);
            set_floats(&mut black, "roughness", &[1.0]);
            boolean(&mut black, "twosided", s.double_sided);
            return black;
        }
        let mut out = Vec::new();
        base.set(&mut d, "reflectance", prefix, &mut out);
        self.out.append(&mut out);
        self.number(&mut d, "metallic", &s.metallic, "blue");
        self.number(&mut d, "roughness", &s.roughness, "green");
        set_floats(&mut d, "eta", &[if s.ior >= 0.1 { f64::from(s.ior).min(10.0) } else { 1.5 }]);
        let is_set = |n: &Number, default: f32| n.factor != default || n.picture.is_some();
        if is_set(&s.specular, 1.0) {
            self.number(&mut d, "specular", &s.specular, "opacity");
        }
        if is_set(&s.clearcoat, 0.0) {
            self.number(&mut d, "clearcoat", &s.clearcoat, "red");
            self.number(&mut d, "clearcoatroughness", &s.clearcoat_roughness, "green");
        }
        let is_clear = is_set(&s.transmission, 0.0);
        if is_clear {
            self.number(&mut d, "transmission", &s.transmission, "red");
            boolean(&mut d, "thin", !s.is_solid);
        }
        if !s.double_sided && !is_clear {
            boolean(&mut d, "twosided", false);
        }
        if let Some(map) = s.normal.picture.as_ref().and_then(|p| self.picture(p, Channel::Normal, 1.0)) {
            set_strings(&mut d, ParamType::Texture, "normalmap", &[&map]);
            let scale = bounded(f64::from(s.normal.factor)).clamp(-1e6, 1e6);
            if scale != 1.0 {
                set_floats(&mut d, "normalmapscale", &[scale]);
            }
        }
        d
    }

    fn number(&mut self, d: &mut Directive, name: &str, number: &Number, channel: &'static str) {
        let factor = share(number.factor);
        let picture = number.picture.as_ref().and_then(|p| self.picture(p, Channel::Number(channel), factor));
        crate::lang::models::picture::set_number(d, name, factor, picture.as_deref());
    }

    /// The texture of the vertices' colours, or of how opaque these are.
    fn vertex_colours(&mut self, opacity: bool) -> String {
        let name = format!("{}: {}", self.file.prefix, if opacity { "opacity of vertices" } else { "colours of vertices" });
        if self.textures.insert(name.clone(), name.clone()).is_none() {
            self.out.push(texture(&name, opacity, "vertexcolor", self.file.at));
        }
        name
    }

    /// Which set of texture coordinates of its material a picture lies by, from 0.
    fn set_of(&self, picture: Option<&Picture>) -> Option<usize> {
        picture.map(|p| usize::from(self.sets[0] != Some(p.set) && self.sets[1] == Some(p.set)))
    }

    /// The texture of a picture, if it is there.
    fn picture(&mut self, picture: &Picture, channel: Channel, factor: f64) -> Option<String> {
        let second = self.set_of(Some(picture)) == Some(1);
        let key = format!("{picture:?} {channel:?} {factor} {second}");
        if let Some(known) = self.textures.get(&key) {
            return Some(known.clone());
        }
        let (path, number) = match place(self.model, picture.image)? {
            Place::Within => (self.file.path.to_owned(), Some(picture.image)),
            Place::File(path) => match self.file.find(&path, self.sources) {
                Some(found) => (found, None),
                None => {
                    self.lost.insert(path);
                    return None;
                }
            },
        };
        let name = format!("{}: picture {}", self.file.prefix, self.textures.len());
        let is_float = matches!(channel, Channel::Number(_));
        let mut d = texture(&name, is_float, "imagemap", self.file.at);
        set_strings(&mut d, ParamType::String, "filename", &[&path]);
        if let Some(number) = number {
            set(&mut d, ParamType::Integer, "image", Values::Numbers { values: vec![number as f64], whole: true });
        }
        let encoding = if matches!(channel, Channel::Colour) { "sRGB" } else { "linear" };
        set_strings(&mut d, ParamType::String, "encoding", &[encoding]);
        if let Channel::Number(channel) = channel {
            set_strings(&mut d, ParamType::String, "channel", &[channel]);
            set_floats(&mut d, "scale", &[factor]);
        }
        let [u, v] = picture.wrap.map(|wrap| match wrap {
            WrappingMode::Repeat => "repeat",
            WrappingMode::ClampToEdge => "clamp",
            WrappingMode::MirroredRepeat => "mirror",
        });
        if u != "repeat" {
            set_strings(&mut d, ParamType::String, "wrap", &[u]);
        }
        if v != u {
            set_strings(&mut d, ParamType::String, "wrapv", &[v]);
        }
        if second {
            set(&mut d, ParamType::Integer, "uvset", Values::Numbers { values: vec![1.0], whole: true });
        }
        if picture.nearest {
            set_strings(&mut d, ParamType::String, "filter", &["point"]);
        }
        // KHR_texture_transform counts v downwards; meshes have it upwards here.
        let (sin, cos) = picture.rotation.sine_cosine();
        let ([su, sv], [ou, ov]) = (picture.scale, picture.offset);
        let placed = [
            ("uscale", su, 1.0),
            ("vscale", sv, 1.0),
            ("rotate", picture.rotation.to_degrees(), 0.0),
            ("udelta", ou + sv * sin, 0.0),
            ("vdelta", 1.0 - ov - sv * cos, 0.0),
        ];
        for (param, value, default) in placed {
            if value != default {
                set_floats(&mut d, param, &[bounded(value)]);
            }
        }
        self.out.push(d);
        self.textures.insert(key, name.clone());
        Some(name)
    }
}
