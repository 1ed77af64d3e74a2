//! Directives to a plain description of the scene: includes, transforms, attributes, names.
//!
//! A machine with pbrt's graphics state; it knows no plugin.

use crate::lang::ast::Directive;
use crate::lang::description::{Entity, SceneDescription};
use crate::lang::errors::{ErrorCount, Suggestions};
use crate::lang::foreign;
use crate::lang::parse::{self, Directives, MAX_ERRORS};
use crate::lang::pbrt::Translator;
use crate::lang::resolve::attributes::Attributes;
use crate::lang::source::SourceMap;
use crate::lang::transform;
use crate::lang::variables::Variables;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean, shorten};
use bhs_core::spacetime::Side;
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

mod attributes;
pub(super) mod call;
pub(crate) mod directives;
mod objects;
mod variables;
mod views;

use directives::Section;
use variables::Scope;

/// `AttributeBegin` within `AttributeBegin` that are allowed.
pub const MAX_ATTRIBUTE_DEPTH: usize = 1000;

/// Runs the directives of file number `file` and of all that it includes.
pub fn resolve(sources: &mut SourceMap, file: u16) -> (SceneDescription, Vec<Diagnostic>) {
    resolve_with(sources, file, &Variables::default())
}

/// As [`resolve`], with numbers from outside for the scene's variables.
pub fn resolve_with(sources: &mut SourceMap, file: u16, given: &Variables) -> (SceneDescription, Vec<Diagnostic>) {
    let mut resolver = Resolver {
        sources,
        found: Vec::new(),
        scene: SceneDescription::default(),
        state: State::default(),
        stack: Vec::new(),
        textures: Default::default(),
        cameras: BTreeMap::new(),
        objects: BTreeMap::new(),
        object: None,
        too_deep: 0,
        too_early: Vec::new(),
        systems: BTreeMap::new(),
        named: BTreeMap::new(),
        look_at: None,
        pending: Vec::new(),
        world: None,
        variables: Scope::new(given),
        directives: 0,
        errors: ErrorCount::default(),
        ended: false,
        suggestions: Suggestions::default(),
        pbrt: Translator::default(),
        models: 0,
    };
    resolver.found.extend(resolver.sources.take_notes());
    resolver.file(file);
    resolver.add_files(file);
    resolver.finish(file);
    (resolver.scene, resolver.found)
}

/// The material of the shapes that follow.
#[derive(Clone)]
pub(super) enum CurrentMaterial {
    Default,
    Index(usize),
    Named(Spanned<String>),
}

/// What `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone)]
pub(super) struct State {
    pub(super) ctm: Arc<DAffine3>,
    pub(super) reverse_orientation: bool,
    pub(super) side: Side,
    pub(super) material: CurrentMaterial,
    pub(super) area_light: Option<usize>,
    attributes: Attributes,
}

impl State {
    /// The same under another transform.
    pub(super) fn at(&self, ctm: DAffine3) -> Self {
        Self { ctm: Arc::new(ctm), ..self.clone() }
    }
}

impl Default for State {
    fn default() -> Self {
        Self {
            ctm: Arc::default(),
            reverse_orientation: false,
            side: Side::Near,
            material: CurrentMaterial::Default,
            area_light: None,
            attributes: Attributes::default(),
        }
    }
}

/// The machine that runs directives.
pub(crate) struct Resolver<'s> {
    pub(super) sources: &'s mut SourceMap,
    pub(super) found: Vec<Diagnostic>,
    pub(super) scene: SceneDescription,
    pub(super) state: State,
    pub(super) stack: Vec<(State, Span)>,
    /// Index of each texture, of spectra and of floats.
    pub(super) textures: [BTreeMap<String, usize>; 2],
    /// Index of each camera; `None`: the one without a name.
    pub(super) cameras: BTreeMap<Option<String>, usize>,
    /// Index of each object.
    pub(super) objects: BTreeMap<String, usize>,
    /// The object that is being defined: its index, where it begins, and the height of the stack there.
    pub(super) object: Option<(usize, Span, usize)>,
    /// `AttributeBegin`s beyond the greatest depth, which save nothing.
    pub(super) too_deep: usize,
    /// Directives of the world before it begins.
    pub(super) too_early: Vec<Spanned<String>>,
    pub(super) systems: BTreeMap<String, DAffine3>,
    /// Index of each named material.
    pub(super) named: BTreeMap<String, usize>,
    /// Where the last `LookAt` stands, and its target under the current transform there, which takes world space to camera space; `None` once another
    /// transform has taken its place.
    pub(super) look_at: Option<(Span, DVec3)>,
    /// Shapes whose material is known by name only, which may be defined after them.
    pub(super) pending: Vec<(usize, Spanned<String>)>,
    /// Where the world begins.
    pub(super) world: Option<Span>,
    variables: Scope<'s>,
    pub(super) directives: usize,
    pub(super) errors: ErrorCount,
    /// Whether there are so many errors that the rest is not read.
    pub(super) ended: bool,
    pub(super) suggestions: Suggestions,
    /// What turns pbrt-v4's directives into ours.
    pbrt: Translator,
    /// Files that have brought materials of their own.
    pub(super) models: usize,
}

impl Resolver<'_> {
    pub(super) fn file(&mut self, file: u16) {
        let Some((text, is_pbrt)) = self.sources.get(file).map(|s| (Arc::clone(&s.text), s.is_pbrt)) else { return };
        let mut directives = Directives::new(&text, file).suggesting(directives::KEYWORDS);
        while let Some(mut directive) = directives.next() {
            self.found.extend(directives.take_faults());
            if self.ended {
                return;
            }
            self.directives += 1;
            let end = directive.span.end;
            if !directive.references.is_empty() {
                self.substitute(&mut directive);
            }
            if is_pbrt {
                self.run_pbrt(directive);
            } else {
                self.directive(directive);
            }
            if self.errors.count(&self.found) >= MAX_ERRORS && !self.ended {
                self.found.push(parse::too_many(file, end));
                self.end();
            }
        }
        self.found.extend(directives.into_faults());
        if self.errors.count(&self.found) >= MAX_ERRORS {
            self.end();
        }
    }

    /// Runs a directive of pbrt-v4's.
    fn run_pbrt(&mut self, directive: Directive) {
        let translated = self.pbrt.translate(directive, &mut self.found);
        translated.directives.into_iter().for_each(|d| self.directive(d));
        if translated.is_import {
            self.pbrt.end_import();
        }
    }

    /// Reads the files that `--include` adds, with the world's coordinates.
    fn add_files(&mut self, scene: u16) {
        for path in self.sources.additions().to_vec() {
            if self.ended {
                return;
            }
            self.state = State::default();
            if self.sources.get(scene).is_some_and(|s| s.is_model) {
                // In the file's own coordinates.
                self.state.ctm = Arc::new(DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)));
            }
            self.pbrt.start_addition();
            match self.sources.open_addition(&path, scene) {
                Ok(file) => self.file(file),
                Err(fault) => {
                    self.found.push(*fault);
                    self.scene.incomplete = true;
                }
            }
        }
        for directive in self.pbrt.finish(&mut self.found) {
            self.directive(directive);
        }
    }

    /// Ends the reading of all files: there are too many errors. What is missing may be in what is not read.
    fn end(&mut self) {
        self.ended = true;
        self.scene.incomplete = true;
    }

    pub(super) fn error(
        &mut self,
        code: &'static str,
        message: impl Into<String>,
        span: Span,
        label: &str,
        help: impl Into<String>,
    ) {
        let help = Some(help.into()).filter(|h| !h.is_empty());
        self.found.push(Diagnostic::error(code, message).at(span, label).maybe_help(help));
    }

    pub(super) fn directive(&mut self, directive: Directive) {
        let (word, at) = (directive.keyword.value.as_str(), directive.keyword.span);
        let Some(row) = directives::find(word) else {
            match directives::absent(word) {
                Some(advice) => self.error("unsupported", format!("`{word}` is not supported yet"), at, "", advice),
                None => {
                    let help = match did_you_mean(word, directives::KEYWORDS.iter().copied()) {
                        _ if let Some(help) = foreign::directive(word) => help.to_owned(),
                        Some(near) => format!("did you mean `{near}`?"),
                        None => String::new(),
                    };
                    self.error("unknown-directive", format!("unknown directive `{}`", shorten(word)), at, "", help);
                }
            }
            return;
        };
        match (row.section, self.world) {
            (Section::Options, Some(world)) => {
                let error = Diagnostic::error("wrong-section", format!("`{word}` stands before `WorldBegin`"));
                let error = error.at(at, "this is in the world").and(world, "the world begins here");
                return self.found.push(error.help("move it before `WorldBegin`"));
            }
            (Section::World, None) => self.too_early.push(directive.keyword.clone()),
            _ => {}
        }
        if let Some(call) = self.call(row, directive) {
            (row.run)(self, call);
        }
    }

    /// What must hold at the end of the scene.
    fn finish(&mut self, file: u16) {
        if self.ended {
            return;
        }
        if let Some((_, begin, depth)) = self.object.take() {
            self.stack.remove(depth);
            self.error("unclosed-object", "this `ObjectBegin` is never ended", begin, "", "add `ObjectEnd`");
        }
        for (_, begin) in std::mem::take(&mut self.stack) {
            let help = "add `AttributeEnd`";
            self.error("unclosed-attribute", "this `AttributeBegin` is never ended", begin, "", help);
        }
        self.check_world(file);

        // Materials may be defined after the shapes that have them.
        let mut unknown = BTreeMap::new();
        for (shape, name) in std::mem::take(&mut self.pending) {
            match self.named.get(&name.value) {
                Some(index) => self.scene.shapes[shape].material = Some(*index),
                None => {
                    unknown.entry(name.value).or_insert(name.span);
                }
            }
        }
        if !self.scene.incomplete {
            for (name, span) in unknown {
                let help = match self.suggestions.near(&name, self.named.keys().map(String::as_str)) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!(
                        "define it: MakeNamedMaterial \"{0}\" \"string type\" ...; a kind of material is written Material \"{0}\"",
                        shorten(&name)
                    ),
                };
                self.error("unknown-material", format!("unknown material `{}`", shorten(&name)), span, "", help);
            }
        }
        for shape in &self.scene.shapes {
            if let Some(material) = shape.material {
                self.scene.materials[material].used = true;
            }
            if let Some(light) = shape.area_light {
                self.scene.area_lights[light].used = true;
            }
        }
        self.finish_objects();
        self.finish_variables();
        self.warn_unused();
    }

    fn check_world(&mut self, file: u16) {
        let too_early = std::mem::take(&mut self.too_early);
        if self.world.is_some() {
            for Spanned { value: word, span } in too_early {
                let message = format!("`{word}` stands after `WorldBegin`");
                self.error("wrong-section", message, span, "the world has not begun", "move it behind `WorldBegin`");
            }
            return;
        }
        let name = self.sources.get(file).map_or("", |s| s.name.as_str());
        let help = "options such as `Camera` and `Film` come first, then `WorldBegin`, then lights and shapes";
        let error = match self.directives {
            0 if self.found.iter().any(|d| d.code == "other-language") => return,
            0 if self.found.is_empty() => Diagnostic::error("empty-scene", format!("the scene `{name}` is empty")),
            _ => Diagnostic::error("no-world", format!("the scene `{name}` has no `WorldBegin`")),
        };
        // It belongs before the first directive of the world.
        self.found.push(match too_early.first() {
            Some(first) => error.at(first.span, "the world has not begun").help("write `WorldBegin` before this"),
            None => error.help(help),
        });
    }

    fn warn_unused(&mut self) {
        if self.scene.incomplete {
            return;
        }
        for light in self.scene.area_lights.iter().filter(|l| !l.used) {
            let message = "this area light lights nothing: no shape follows it";
            let help = "an area light is of the shapes that follow it: write it before them";
            self.found.push(Diagnostic::warning("unused-light", message).at(light.entity.keyword, "").help(help));
        }
        // A material that is set and never used may be meant for others; one behind all shapes is meant for those before it.
        let last = self.scene.shapes.last().map(|shape| shape.entity.keyword);
        let late = |at: Span| last.is_some_and(|last| last.file == at.file && last.start < at.start);
        for material in self.scene.materials.iter().filter(|m| !m.used && m.name.is_none() && late(m.entity.keyword)) {
            let message = "this material is of no shape: it stands behind all of them";
            let help = "a material is of the shapes that follow it: write it before them";
            self.found.push(Diagnostic::warning("late-material", message).at(material.entity.keyword, "").help(help));
        }
    }

    /// The state in which each part of a model begins: nothing counts that the scene states for its own materials and lights.
    pub(super) fn state_of_model(&self) -> State {
        State { attributes: self.state.attributes.of_shapes_alone(), ..self.state.clone() }
    }

    /// Multiplies the current transform from the right.
    pub(super) fn apply(&mut self, t: DAffine3, span: Span) {
        let ctm = *self.state.ctm * t;
        if transform::is_invertible(&ctm) {
            self.state.ctm = Arc::new(ctm);
        } else {
            let help = "the current transform is made of all transforms since the world or the file began";
            self.error("bad-transform", "the current transform leaves the range of numbers here", span, "", help);
        }
    }

    pub(super) fn set_once(&mut self, slot: fn(&mut SceneDescription) -> &mut Option<Entity>, what: &str, entity: Entity) {
        match slot(&mut self.scene) {
            Some(first) => {
                let first = first.keyword;
                self.found.push(
                    Diagnostic::error("duplicate-directive", format!("the scene has {what} already"))
                        .at(entity.keyword, "second one")
                        .and(first, "first one")
                        .help("remove one of the two"),
                );
            }
            empty => *empty = Some(entity),
        }
    }
}
