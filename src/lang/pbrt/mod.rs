//! Files of pbrt-v4: each directive becomes those of ours that mean the same.
//!
//! A file is translated while it is read, directive by directive, and the resolver runs what comes out; `bhs convert` prints it. So a scene
//! and what it is converted to are the same. Options wait until the world begins: the last of each kind counts, and the film needs the
//! camera's shutter. What has no counterpart is left out with a warning that names it, once.

use crate::lang::ast::Directive;
use crate::lang::params::{self, directive, numbers};
use crate::lang::transform;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::value::Param;
use colours::Space;
use glam::{DAffine3, DVec3};
use notes::Notes;
use std::collections::BTreeMap;
use std::sync::Arc;

mod colours;
mod convert;
mod lights;
mod materials;
mod notes;
mod older;
mod options;
mod shapes;
mod textures;

pub use convert::convert;

/// What a directive of pbrt becomes.
#[derive(Default)]
pub(crate) struct Translated {
    /// These are to be run in order.
    pub directives: Vec<Directive>,
    /// Whether it was `Import`: [`Translator::end_import`] is to be called once they have been run.
    pub is_import: bool,
}

/// Which of the two transforms directives change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Active {
    All,
    Start,
    End,
}

/// What `AttributeBegin` saves.
#[derive(Clone)]
struct State {
    /// When the shutter opens, and when it closes.
    transforms: [DAffine3; 2],
    active: Active,
    /// Whether the current transform flattens space: what stands under it has no surface.
    flat: bool,
    space: Space,
    /// What `Attribute` states, by the kind of directive.
    attributes: Arc<Vec<(String, Param)>>,
    /// The current material as it was written here.
    material: Option<Arc<Directive>>,
}

/// Reads pbrt-v4, and remembers what later directives depend on.
pub(crate) struct Translator {
    notes: Notes,
    /// Options, and the transforms between them, in order.
    options: Vec<Directive>,
    world: bool,
    state: State,
    stack: Vec<State>,
    systems: BTreeMap<String, [DAffine3; 2]>,
    /// Materials that have been given a name, and the textures that cut holes into them.
    cut: Vec<(Arc<Directive>, Param, String)>,
    /// Whether `ActiveTransform` was the last word.
    chooses: bool,
}

impl Default for Translator {
    fn default() -> Self {
        let state = State {
            transforms: [DAffine3::IDENTITY; 2],
            active: Active::All,
            flat: false,
            space: Space::Srgb,
            attributes: Arc::default(),
            material: None,
        };
        Self {
            notes: Notes::default(),
            options: Vec::new(),
            world: false,
            state,
            stack: Vec::new(),
            systems: BTreeMap::new(),
            cut: Vec::new(),
            chooses: false,
        }
    }
}

impl Translator {
    /// Translates a directive; what is to be said of it goes to `found`.
    pub fn translate(&mut self, d: Directive, found: &mut Vec<Diagnostic>) -> Translated {
        let mut out = Translated::default();
        self.run(d, &mut out);
        found.extend(self.notes.take());
        out
    }

    /// The options of a file whose world never begins.
    pub fn finish(&mut self, found: &mut Vec<Diagnostic>) -> Vec<Directive> {
        let options = if self.world { Vec::new() } else { std::mem::take(&mut self.options) };
        found.extend(self.notes.take());
        options
    }

    /// The place where `--include` adds files: the world as it begins.
    pub fn start_addition(&mut self) {
        self.state = Self::default().state;
    }

    /// Nothing that was set in an imported file lasts.
    pub fn end_import(&mut self) {
        if let Some(state) = self.stack.pop() {
            self.state = state;
        }
    }

    fn run(&mut self, mut d: Directive, out: &mut Translated) {
        let (word, at) = (d.keyword.value.clone(), d.keyword.span);
        if std::mem::take(&mut self.chooses) {
            self.state.active = match word.as_str() {
                "All" => Active::All,
                "StartTime" => Active::Start,
                "EndTime" => Active::End,
                _ => return self.run_word(d, out),
            };
            return;
        }
        let push = |this: &mut Self| this.stack.push(this.state.clone());
        let end = match word.as_str() {
            "TransformBegin" => "AttributeBegin",
            _ => "AttributeEnd",
        };
        match word.as_str() {
            "TransformBegin" | "TransformEnd" => {
                self.notes.mapped("the directive", &word, &format!("`{end}`"), at, "as pbrt-v4 reads it");
                d.keyword.value = end.to_owned();
                self.run(d, out);
            }
            "AttributeBegin" | "ObjectBegin" => {
                push(self);
                out.directives.push(d);
            }
            "AttributeEnd" | "ObjectEnd" => {
                self.end_import();
                out.directives.push(d);
            }
            "ActiveTransform" => self.chooses = true,
            "Import" => {
                push(self);
                out.is_import = true;
                d.keyword.value = "Include".to_owned();
                out.directives = vec![directive("AttributeBegin", at), d, directive("AttributeEnd", at)];
            }
            "WorldBegin" => {
                out.directives = self.take_options(at);
                (self.world, self.state.transforms, self.state.active) = (true, [DAffine3::IDENTITY; 2], Active::All);
                self.systems.insert("world".to_owned(), [DAffine3::IDENTITY; 2]);
                out.directives.push(d);
            }
            _ => self.run_word(d, out),
        }
    }

    fn run_word(&mut self, mut d: Directive, out: &mut Translated) {
        let (word, at) = (d.keyword.value.clone(), d.keyword.span);
        match word.as_str() {
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform" | "CoordSysTransform" => {
                if let Some(d) = self.transform(d) {
                    if self.world { out.directives.push(d) } else { self.options.push(d) }
                }
            }
            "CoordinateSystem" => {
                self.systems.insert(params::name(&d).to_owned(), self.state.transforms);
                if self.world { out.directives.push(d) } else { self.options.push(d) }
            }
            "ColorSpace" => match Space::named(params::name(&d)) {
                Some(space) => self.state.space = space,
                None => out.directives.push(d),
            },
            "Attribute" => {
                let kind = params::name(&d).to_owned();
                let attributes = Arc::make_mut(&mut self.state.attributes);
                for param in d.params {
                    attributes.retain(|(k, p)| *k != kind || p.name.value != param.name.value);
                    attributes.push((kind.clone(), param));
                }
            }
            "MakeNamedMedium" | "MediumInterface" => {
                self.notes.ignored(&word, at, "there are no media: the picture lacks fog, smoke, and colours of clear bodies");
            }
            "Accelerator" => self.notes.ignored(&word, at, "Option \"string intersector\" chooses what finds surfaces"),
            "TransformTimes" => self.notes.ignored(&word, at, "nothing moves during the exposure"),
            "WorldEnd" => self.notes.ignored(&word, at, "the world ends with the file"),
            "Texture" => self.texture(d, out),
            "Material" | "MakeNamedMaterial" => self.material(d, out),
            "NamedMaterial" => {
                self.state.material = Some(Arc::new(d.clone()));
                out.directives.push(d);
            }
            "LightSource" | "AreaLightSource" | "Shape" | "ObjectInstance" if self.state.flat => {
                let what = format!("`{word}` under a transform of determinant 0 is left out");
                self.notes.warn(&what, at, "it has no size here", "");
            }
            "LightSource" | "AreaLightSource" => {
                self.light(&mut d);
                out.directives.push(d);
            }
            "Shape" => self.shape(d, out),
            "ObjectInstance" => {
                self.check_motion(&d);
                out.directives.push(d);
            }
            "Camera" | "Film" | "Sampler" | "PixelFilter" | "Integrator" | "LightTransport" | "Option" if !self.world => {
                if word == "Camera" {
                    self.check_motion(&d);
                    let inverse = self.state.transforms.map(|t| t.inverse());
                    self.systems.insert("camera".to_owned(), inverse);
                }
                self.options.push(d);
            }
            _ => out.directives.push(d),
        }
    }

    /// Follows a transform; the directive if it is to be run.
    fn transform(&mut self, d: Directive) -> Option<Directive> {
        let n = numbers(&d);
        let v = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
        let relative = match (d.keyword.value.as_str(), n.len()) {
            ("Translate", 3) => DAffine3::from_translation(v(0)),
            ("Scale", 3) => DAffine3::from_scale(v(0)),
            // What cannot be read is reported where it is run.
            ("Rotate", 4) => transform::rotate(n[0], v(1)).unwrap_or_default(),
            ("LookAt", 9) => transform::look_at(v(0), v(3), v(6)).unwrap_or_default(),
            ("ConcatTransform" | "Transform", 16) => matrix(&n),
            _ => DAffine3::IDENTITY,
        };
        let word = d.keyword.value.as_str();
        let absolute = matches!(word, "Identity" | "Transform" | "CoordSysTransform");
        let [on_start, on_end] = [self.state.active != Active::End, self.state.active != Active::Start];
        let known = self.systems.get(params::name(&d)).copied().filter(|_| word == "CoordSysTransform");
        let changed = |old: DAffine3, i: usize| match absolute {
            true => known.map_or(relative, |k| k[i]),
            false => old * relative,
        };
        if on_end {
            self.state.transforms[1] = changed(self.state.transforms[1], 1);
        }
        if !on_start {
            return None;
        }
        let new = changed(self.state.transforms[0], 0);
        let flattens = new.is_finite() && new.matrix3.determinant() == 0.0;
        if flattens || (self.state.flat && !absolute) {
            self.state.flat = true;
            return None;
        }
        (self.state.flat, self.state.transforms[0]) = (false, new);
        Some(d)
    }

    /// Says that something moves which stands still here.
    fn check_motion(&mut self, d: &Directive) {
        let [start, end] = self.state.transforms;
        if !start.abs_diff_eq(end, 1e-9 * (1.0 + start.translation.abs().max_element())) {
            let word = d.keyword.value.as_str();
            let message = format!("`ActiveTransform`: this `{word}` moves, and stands still here, where it is at the start");
            self.notes.warn(&message, d.keyword.span, "", "nothing moves during the exposure: the picture lacks the blur");
        }
    }

    /// Gives a directive the parameters that `Attribute` states for its kind, if they are among `known`.
    fn inherit(&self, d: &mut Directive, kind: &str, known: &[&str]) {
        for (_, param) in self.state.attributes.iter().filter(|(k, _)| k == kind) {
            if known.contains(&param.name.value.as_str()) && params::find(d, &param.name.value).is_none() {
                d.params.push(param.clone());
            }
        }
    }
}

/// The matrix of sixteen numbers, flat or not.
fn matrix(n: &[f64]) -> DAffine3 {
    let column = |i: usize| DVec3::new(n[4 * i], n[4 * i + 1], n[4 * i + 2]);
    let w = if n[15] == 0.0 { 1.0 } else { n[15] };
    let axes = glam::DMat3::from_cols(column(0) / w, column(1) / w, column(2) / w);
    DAffine3::from_mat3_translation(axes, column(3) / w)
}
