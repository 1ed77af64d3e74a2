//! What plugins ask for by name: textures, materials and pictures, each made once, when it is first asked for.
//!
//! What no shape uses is made too, so that its faults are found, but apart, and without reading its pictures.

use crate::lang::description::{Entity, MaterialEntity, SceneDescription, TextureEntity};
use crate::lang::errors::{ErrorCount, Suggestions};
use crate::lang::faulty::Faulty;
use crate::lang::parse::MAX_ERRORS;
use crate::registry::{Kind, Registry};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, shorten};
use bhs_core::image::Image;
use bhs_core::material::Material;
use bhs_core::params::{Context, Named, Nameless, Params};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::texture::{Texture, TextureKind};
use bhs_materials::bumps::Bumps;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// Materials within materials, and textures within textures, that are allowed: they are made, evaluated and let go by recursion.
pub const MAX_NESTED: u32 = 100;

/// A thing that is made at most once.
#[derive(Clone)]
enum Slot<T> {
    /// Its constructor runs.
    UnderWay,
    /// With how deep the things that it is made of are nested in it.
    Made(T, u32),
}

/// What making a thing by its name may come to.
enum Made<T> {
    Whole(T, u32),
    /// It is made of itself.
    UnderWay,
    /// Too many others are being made of which it is a part.
    TooDeep,
}

/// The textures and materials of a scene.
pub(super) struct Names<'a> {
    registry: &'a Registry,
    textures: &'a [TextureEntity],
    materials: &'a [MaterialEntity],
    /// Number of the first texture of each name, of spectra and of floats.
    texture_names: [BTreeMap<&'a str, usize>; 2],
    /// Number of the first material of each name.
    material_names: BTreeMap<&'a str, usize>,
    /// Whether the scene lacks an included file, in which what is missing may be.
    incomplete: bool,
    /// Constructors that run, each for the one before it.
    running: Cell<u32>,
    /// Whether something has been found to be nested too deeply.
    too_deep: Cell<bool>,
    /// Whether a texture that is used asks for the patch that a pixel sees.
    wants_patches: Cell<bool>,
    suggestions: Suggestions,
    state: RefCell<State>,
}

/// A texture may be made several times, for different uses.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct TextureKey {
    /// Its number in the scene.
    index: usize,
    kind: TextureKind,
    /// Whether it is for something that is used.
    used: bool,
}

#[derive(Default)]
struct State {
    textures: HashMap<TextureKey, Slot<Arc<dyn Texture>>>,
    /// For each texture of the scene: whether it has been asked for, and for something that is used.
    asked: Vec<[bool; 2]>,
    /// As many as the scene has; `None`: not asked for yet.
    materials: Vec<Option<Slot<Arc<dyn Material>>>>,
    /// By path as written and the file that it stands in.
    images: BTreeMap<(String, u16), Result<Arc<Image>, String>>,
    found: Vec<Diagnostic>,
    errors: ErrorCount,
    /// Codes, places and messages of all that has been found.
    reported: HashSet<(&'static str, Option<Span>, String)>,
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
        context.decode(&path.value, path.span, bhs_textures::decode::decode)
    }
}

impl<'a> Names<'a> {
    pub fn new(registry: &'a Registry, description: &'a SceneDescription) -> Self {
        let SceneDescription { textures, materials, incomplete, .. } = description;
        let state = State { materials: vec![None; materials.len()], asked: vec![[false; 2]; textures.len()], ..State::default() };
        let mut texture_names = [BTreeMap::new(), BTreeMap::new()];
        for (i, texture) in textures.iter().enumerate() {
            texture_names[usize::from(texture.is_float)].entry(texture.name.value.as_str()).or_insert(i);
        }
        let mut material_names = BTreeMap::new();
        for (i, name) in materials.iter().enumerate().filter_map(|(i, m)| Some((i, m.name.as_ref()?))) {
            material_names.entry(name.value.as_str()).or_insert(i);
        }
        Self {
            registry,
            textures,
            materials,
            texture_names,
            material_names,
            incomplete: *incomplete,
            running: Cell::new(0),
            too_deep: Cell::new(false),
            wants_patches: Cell::new(false),
            suggestions: Suggestions::default(),
            state: RefCell::new(state),
        }
    }

    /// Makes a thing that has no name of its own and is used, from what has one. All that is wrong is told by [`Names::make_all`].
    pub fn make<T: Kind + ?Sized>(&self, entity: &Entity, context: Context) -> Option<Box<T>> {
        self.create_with::<T, ()>(entity, TextureKind::Float, true, &context, |_| None).0
    }

    /// Makes all materials, and the textures that they ask for; in the order of the scene. All that is wrong goes to `found`. The second: whether a
    /// texture asks for the patch that a pixel sees.
    pub fn make_all(self, context: Context, found: &mut Vec<Diagnostic>) -> (Vec<Option<Arc<dyn Material>>>, bool) {
        for i in (0..self.materials.len()).filter(|i| self.materials[*i].used) {
            if self.too_many_errors() {
                break;
            }
            self.material_at(i, true, &context);
        }
        // Lights have been made before ([`Names::make`]), and no shape takes a texture: the others are unused.
        let unused: Vec<usize> = {
            let state = self.state.borrow();
            (0..self.materials.len()).filter(|i| state.materials[*i].is_none()).collect()
        };
        for i in &unused {
            if self.too_many_errors() {
                break;
            }
            self.material_at(*i, false, &context);
        }
        for (i, texture) in self.textures.iter().enumerate() {
            if self.too_many_errors() {
                break;
            }
            let [asked, used] = self.state.borrow().asked[i];
            if !asked {
                let kind = if texture.is_float { TextureKind::Float } else { TextureKind::Spectrum(SpectrumRole::Unbounded) };
                self.texture_at(i, kind, false, &context);
            }
            if !used && !self.incomplete && !self.too_deep.get() {
                let message = format!("texture `{}` is never used", shorten(&texture.name.value));
                let d = Diagnostic::warning("unused-texture", message).at(texture.name.span, "nothing that is used has it");
                self.report([d]);
            }
        }
        for name in
            unused.iter().filter_map(|i| self.materials[*i].name.as_ref()).filter(|_| !self.incomplete && !self.too_deep.get())
        {
            let message = format!("material `{}` is never used", shorten(&name.value));
            self.report([Diagnostic::warning("unused-material", message).at(name.span, "no shape has it")]);
        }
        let mut state = self.state.into_inner();
        found.append(&mut state.found);
        let made = |slot| match slot {
            Some(Slot::Made(material, _)) => Some(material),
            _ => None,
        };
        (state.materials.into_iter().map(made).collect(), self.wants_patches.get())
    }

    fn too_many_errors(&self) -> bool {
        let state = &mut *self.state.borrow_mut();
        state.errors.count(&state.found) >= MAX_ERRORS
    }

    fn report(&self, found: impl IntoIterator<Item = Diagnostic>) {
        let state = &mut *self.state.borrow_mut();
        // A texture that is made for several uses has the same faults in each.
        for d in found {
            if state.reported.insert((d.code, d.primary.as_ref().map(|p| p.span), d.message.clone())) {
                state.found.push(d);
            }
        }
    }

    /// A material.
    fn material_at(&self, i: usize, used: bool, context: &Context) -> Made<Arc<dyn Material>> {
        let known = self.state.borrow().materials[i].clone();
        match known {
            Some(Slot::UnderWay) => return Made::UnderWay,
            Some(Slot::Made(material, depth)) => return Made::Whole(material, depth),
            None if self.running.get() == MAX_NESTED => return Made::TooDeep,
            None => self.state.borrow_mut().materials[i] = Some(Slot::UnderWay),
        }
        let (made, bumps, depth) = self.create_with(&self.materials[i].entity, TextureKind::Float, used, context, Bumps::read);
        let made: Option<Box<dyn Material>> = match bumps {
            Some(bumps) => made.map(|material| bumps.over(material)),
            None => made,
        };
        // What could not be made has been reported: nothing is rendered.
        let made: Arc<dyn Material> = made.map_or_else(|| Arc::new(Faulty) as _, Arc::from);
        self.state.borrow_mut().materials[i] = Some(Slot::Made(Arc::clone(&made), depth));
        Made::Whole(made, depth)
    }

    /// A texture.
    fn texture_at(&self, i: usize, kind: TextureKind, used: bool, context: &Context) -> Made<Arc<dyn Texture>> {
        let key = TextureKey { index: i, kind, used };
        let known = self.state.borrow().textures.get(&key).cloned();
        match known {
            Some(Slot::UnderWay) => return Made::UnderWay,
            Some(Slot::Made(texture, depth)) => return Made::Whole(texture, depth),
            None if self.running.get() == MAX_NESTED => return Made::TooDeep,
            None => {
                let state = &mut *self.state.borrow_mut();
                state.textures.insert(key, Slot::UnderWay);
                let [asked, for_use] = &mut state.asked[i];
                (*asked, *for_use) = (true, *for_use || used);
            }
        }
        let (made, _, depth) = self.create_with::<dyn Texture, ()>(&self.textures[i].entity, kind, used, context, |_| None);
        let made: Arc<dyn Texture> = made.map_or_else(|| Arc::new(Faulty) as _, Arc::from);
        self.state.borrow_mut().textures.insert(key, Slot::Made(Arc::clone(&made), depth));
        Made::Whole(made, depth)
    }

    /// Runs the constructor of a material or a texture; what it makes, what its directive reads, and how deep its parts are nested.
    fn create_with<T: Kind + ?Sized, D>(
        &self,
        entity: &Entity,
        kind: TextureKind,
        used: bool,
        context: &Context,
        read: impl FnOnce(&Params) -> Option<D>,
    ) -> (Option<Box<T>>, Option<D>, u32) {
        let view = View { names: self, kind, used, depth: Cell::new(0) };
        let mut found = Vec::new();
        self.running.set(self.running.get() + 1);
        let (made, of_directive) = self.registry.create_with::<T, D>(entity, view.context(entity, context), &mut found, read);
        self.running.set(self.running.get() - 1);
        self.report(found);
        (made, of_directive, view.depth.get())
    }
}

/// The names of a scene as one thing that is being made sees them.
struct View<'v, 'a> {
    names: &'v Names<'a>,
    kind: TextureKind,
    /// Whether it is, or is for, something that is used.
    used: bool,
    /// How deep the parts that it has asked for are nested, themselves counted.
    depth: Cell<u32>,
}

impl View<'_, '_> {
    /// A part that has been asked for by its name.
    fn part<T>(&self, made: Made<T>, what: &str, name: &Spanned<String>) -> Result<Option<T>, Box<Diagnostic>> {
        match made {
            Made::Whole(part, depth) if depth + 1 < MAX_NESTED => {
                self.depth.set(self.depth.get().max(depth + 1));
                return Ok(Some(part));
            }
            Made::UnderWay => return Err(made_of_itself(what, name)),
            Made::Whole(..) | Made::TooDeep => {}
        }
        if self.names.too_deep.replace(true) {
            // The others of the same chain say nothing new.
            return Ok(None);
        }
        let message = format!("{what}s are nested more than {MAX_NESTED} deep");
        let label = format!("`{}` is made of too many others, one within the other", shorten(&name.value));
        Err(Diagnostic::error("nested-too-deep", message).at(name.span, label).help("make it of fewer").into())
    }

    fn context<'c>(&'c self, entity: &Entity, context: &Context<'c>) -> Context<'c> {
        Context { named: self, world_from_object: *entity.world_from_object, ..*context }
    }
}

impl Named for View<'_, '_> {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        let is_float = kind == TextureKind::Float;
        let of_type = |is_float: bool| &self.names.texture_names[usize::from(is_float)];
        if let Some(i) = of_type(is_float).get(name.value.as_str()) {
            let made = self.names.texture_at(*i, kind, self.used, context);
            return Ok(self.part(made, "texture", name)?.unwrap_or_else(|| Arc::new(Faulty)));
        }
        let (wanted, other) = if is_float { ("float", "spectrum") } else { ("spectrum", "float") };
        let short = shorten(&name.value);
        if let Some(of_other_type) = of_type(!is_float).get(name.value.as_str()).map(|i| &self.names.textures[*i]) {
            return Err(Diagnostic::error("wrong-type", format!("texture `{short}` is of the type `{other}`"))
                .at(name.span, format!("a texture of the type `{wanted}` is needed here"))
                .and(of_other_type.name.span, "defined here")
                .into());
        }
        if self.names.incomplete {
            return Ok(Arc::new(Faulty));
        }
        let help = match self.names.suggestions.near(&name.value, of_type(is_float).keys().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if short.contains('.') => format!(
                "a picture gets a name first: Texture \"t\" \"{wanted}\" \"imagemap\" \"string filename\" \"{short}\"; then write the name"
            ),
            None => format!("define it: Texture \"{short}\" \"{wanted}\" \"imagemap\" ..."),
        };
        Err(Diagnostic::error("unknown-texture", format!("unknown texture `{short}`")).at(name.span, "").help(help).into())
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        if let Some(i) = self.names.material_names.get(name.value.as_str()) {
            let made = self.names.material_at(*i, self.used, context);
            return Ok(self.part(made, "material", name)?.unwrap_or_else(|| Arc::new(Faulty)));
        }
        if self.names.incomplete {
            return Ok(Arc::new(Faulty));
        }
        let short = shorten(&name.value);
        let help = match self.names.suggestions.near(&name.value, self.names.material_names.keys().copied()) {
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
        let image = context.decode(&path.value, path.span, bhs_textures::decode::decode);
        self.names.state.borrow_mut().images.insert(key, image.clone());
        image
    }

    fn wants_patches(&self) {
        self.names.wants_patches.set(self.names.wants_patches.get() || self.used);
    }

    fn kind(&self) -> TextureKind {
        self.kind
    }
}

fn made_of_itself(what: &str, name: &Spanned<String>) -> Box<Diagnostic> {
    let message = format!("{what} `{}` is made of itself", shorten(&name.value));
    Diagnostic::error("cycle", message).at(name.span, "").help("name another one").into()
}
