//! What plugins ask for by name: textures, materials and pictures, each made once, when it is first asked for.
//!
//! What no shape uses is made too, so that its faults are found, but apart, and without reading its pictures.

use crate::lang::description::{Entity, MaterialEntity, SceneDescription, TextureEntity};
use crate::lang::parse::shorten;
use crate::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Spanned, did_you_mean};
use bhs_core::image::Image;
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Context;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::{Named, Nameless, Texture, TextureKind};
use glam::{Vec2, Vec3};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A thing that is made at most once.
#[derive(Clone)]
enum Slot<T> {
    /// Its constructor runs.
    UnderWay,
    Made(T),
}

/// The textures and materials of a scene.
pub(super) struct Names<'a> {
    registry: &'a Registry,
    textures: &'a [TextureEntity],
    materials: &'a [MaterialEntity],
    /// Whether the scene lacks an included file, in which what is missing may be.
    incomplete: bool,
    state: RefCell<State>,
}

/// A texture may be made several times, for different uses.
#[derive(Clone, Copy, PartialEq)]
struct TextureKey {
    /// Its number in the scene.
    index: usize,
    kind: TextureKind,
    /// Whether it is for something that is used.
    used: bool,
}

#[derive(Default)]
struct State {
    textures: Vec<(TextureKey, Slot<Arc<dyn Texture>>)>,
    /// As many as the scene has; `None`: not asked for yet.
    materials: Vec<Option<Slot<Arc<dyn Material>>>>,
    /// By path as written and the file that it stands in.
    images: BTreeMap<(String, u16), Result<Arc<Image>, String>>,
    found: Vec<Diagnostic>,
}

/// What lights may ask for: pictures, and nothing that has a name.
pub(super) struct Pictures;

impl Named for Pictures {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        Nameless.texture(name, kind, context)
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        Nameless.material(name, context)
    }

    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String> {
        let bytes = context.files.read(&path.value, path.span)?;
        bhs_textures::decode::decode(&bytes).map(Arc::new)
    }
}

impl<'a> Names<'a> {
    pub fn new(registry: &'a Registry, description: &'a SceneDescription) -> Self {
        let SceneDescription { textures, materials, incomplete, .. } = description;
        let state = State { materials: vec![None; materials.len()], ..State::default() };
        Self { registry, textures, materials, incomplete: *incomplete, state: RefCell::new(state) }
    }

    /// Makes all materials, and the textures that they ask for; in the order of the scene. All that is wrong goes to `found`.
    pub fn make_all(self, context: Context, found: &mut Vec<Diagnostic>) -> Vec<Option<Arc<dyn Material>>> {
        for i in (0..self.materials.len()).filter(|i| self.materials[*i].used) {
            self.material_at(i, true, &context);
        }
        // A texture may lend itself to lights and shapes too, but none takes one yet: the others are unused.
        let unused: Vec<usize> = {
            let state = self.state.borrow();
            (0..self.materials.len()).filter(|i| state.materials[*i].is_none()).collect()
        };
        for i in &unused {
            self.material_at(*i, false, &context);
        }
        for (i, texture) in self.textures.iter().enumerate() {
            let (asked, used) = {
                let state = self.state.borrow();
                let mut made = state.textures.iter().map(|(key, _)| key).filter(|key| key.index == i).peekable();
                (made.peek().is_some(), made.any(|key| key.used))
            };
            if !asked {
                let kind = if texture.is_float { TextureKind::Float } else { TextureKind::Spectrum(SpectrumRole::Unbounded) };
                self.texture_at(i, kind, false, &context);
            }
            if !used && !self.incomplete {
                let message = format!("texture `{}` is never used", shorten(&texture.name.value));
                let d = Diagnostic::warning("unused-texture", message).at(texture.name.span, "nothing that is used has it");
                self.report([d]);
            }
        }
        for name in unused.iter().filter_map(|i| self.materials[*i].name.as_ref()).filter(|_| !self.incomplete) {
            let message = format!("material `{}` is never used", shorten(&name.value));
            self.report([Diagnostic::warning("unused-material", message).at(name.span, "no shape has it")]);
        }
        let mut state = self.state.into_inner();
        found.append(&mut state.found);
        let made = |slot| match slot {
            Some(Slot::Made(material)) => Some(material),
            _ => None,
        };
        state.materials.into_iter().map(made).collect()
    }

    fn report(&self, found: impl IntoIterator<Item = Diagnostic>) {
        let all = &mut self.state.borrow_mut().found;
        // A texture that is made for several uses has the same faults in each.
        for d in found {
            if !all.contains(&d) {
                all.push(d);
            }
        }
    }

    /// A material; `None` while it is being made.
    fn material_at(&self, i: usize, used: bool, context: &Context) -> Option<Arc<dyn Material>> {
        let known = self.state.borrow().materials[i].clone();
        match known {
            Some(Slot::UnderWay) => return None,
            Some(Slot::Made(material)) => return Some(material),
            None => self.state.borrow_mut().materials[i] = Some(Slot::UnderWay),
        }
        let view = View { names: self, kind: TextureKind::Float, used };
        let entity = &self.materials[i].entity;
        let mut found = Vec::new();
        let made = self.registry.create::<dyn Material>(entity, view.context(entity, context), &mut found);
        self.report(found);
        // What could not be made has been reported: nothing is rendered.
        let made: Arc<dyn Material> = made.map_or_else(|| Arc::new(Faulty) as _, Arc::from);
        self.state.borrow_mut().materials[i] = Some(Slot::Made(Arc::clone(&made)));
        Some(made)
    }

    /// A texture; `None` while it is being made.
    fn texture_at(&self, i: usize, kind: TextureKind, used: bool, context: &Context) -> Option<Arc<dyn Texture>> {
        let key = TextureKey { index: i, kind, used };
        let known = self.state.borrow().textures.iter().find(|(k, _)| *k == key).map(|(_, slot)| slot.clone());
        match known {
            Some(Slot::UnderWay) => return None,
            Some(Slot::Made(texture)) => return Some(texture),
            None => self.state.borrow_mut().textures.push((key, Slot::UnderWay)),
        }
        let view = View { names: self, kind, used };
        let entity = &self.textures[i].entity;
        let mut found = Vec::new();
        let made = self.registry.create::<dyn Texture>(entity, view.context(entity, context), &mut found);
        self.report(found);
        let made: Arc<dyn Texture> = made.map_or_else(|| Arc::new(Faulty) as _, Arc::from);
        let mut state = self.state.borrow_mut();
        for (_, slot) in state.textures.iter_mut().filter(|(k, _)| *k == key) {
            *slot = Slot::Made(Arc::clone(&made));
        }
        Some(made)
    }
}

/// The names of a scene as one thing that is being made sees them.
struct View<'v, 'a> {
    names: &'v Names<'a>,
    kind: TextureKind,
    /// Whether it is, or is for, something that is used.
    used: bool,
}

impl View<'_, '_> {
    fn context<'c>(&'c self, entity: &Entity, context: &Context<'c>) -> Context<'c> {
        Context { named: self, world_from_object: *entity.world_from_object, ..*context }
    }
}

impl Named for View<'_, '_> {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        let is_float = kind == TextureKind::Float;
        let all = self.names.textures;
        if let Some(i) = all.iter().position(|t| t.name.value == name.value && t.is_float == is_float) {
            return self.names.texture_at(i, kind, self.used, context).ok_or_else(|| made_of_itself("texture", name));
        }
        let (wanted, other) = if is_float { ("float", "spectrum") } else { ("spectrum", "float") };
        let short = shorten(&name.value);
        if let Some(of_other_type) = all.iter().find(|t| t.name.value == name.value) {
            return Err(Diagnostic::error("wrong-type", format!("texture `{short}` is of the type `{other}`"))
                .at(name.span, format!("a texture of the type `{wanted}` is needed here"))
                .and(of_other_type.name.span, "defined here")
                .into());
        }
        if self.names.incomplete {
            return Ok(Arc::new(Faulty));
        }
        let names = all.iter().filter(|t| t.is_float == is_float).map(|t| t.name.value.as_str());
        let help = match did_you_mean(&name.value, names) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("define it: Texture \"{short}\" \"{wanted}\" \"imagemap\" ..."),
        };
        Err(Diagnostic::error("unknown-texture", format!("unknown texture `{short}`")).at(name.span, "").help(help).into())
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        let all = self.names.materials;
        let named = |m: &MaterialEntity| m.name.as_ref().map(|n| n.value.clone());
        if let Some(i) = all.iter().position(|m| named(m).as_ref() == Some(&name.value)) {
            return self.names.material_at(i, self.used, context).ok_or_else(|| made_of_itself("material", name));
        }
        if self.names.incomplete {
            return Ok(Arc::new(Faulty));
        }
        let short = shorten(&name.value);
        let names: Vec<String> = all.iter().filter_map(named).collect();
        let help = match did_you_mean(&name.value, names.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("define it: MakeNamedMaterial \"{short}\" \"string type\" ..."),
        };
        Err(Diagnostic::error("unknown-material", format!("unknown material `{short}`")).at(name.span, "").help(help).into())
    }

    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String> {
        if !self.used {
            return Ok(Arc::new(Image::of_one_texel([0.0; 3])));
        }
        let key = (path.value.clone(), path.span.file);
        if let Some(known) = self.names.state.borrow().images.get(&key) {
            return known.clone();
        }
        let bytes = context.files.read(&path.value, path.span);
        let image = bytes.and_then(|bytes| bhs_textures::decode::decode(&bytes)).map(Arc::new);
        self.names.state.borrow_mut().images.insert(key, image.clone());
        image
    }

    fn kind(&self) -> TextureKind {
        self.kind
    }
}

fn made_of_itself(what: &str, name: &Spanned<String>) -> Box<Diagnostic> {
    let message = format!("{what} `{}` is made of itself", shorten(&name.value));
    Diagnostic::error("cycle", message).at(name.span, "").help("name another one").into()
}

/// Stands in for what is at fault, which has been reported: no light.
struct Faulty;

impl Texture for Faulty {
    fn spectrum(&self, _: &Shading) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn float(&self, _: &Shading) -> f32 {
        0.0
    }
}

impl Material for Faulty {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, _: &Shading, _: Vec3, _: f32, _: Vec2) -> Option<BsdfSample> {
        None
    }

    fn is_specular(&self) -> bool {
        true
    }
}
