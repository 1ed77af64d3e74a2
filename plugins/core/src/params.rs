//! How a plugin reads its parameters: its constructor is its schema.
//!
//! Every `get` records the name it asked for with type, default, unit and meaning, marks the parameter as used, and collects an
//! error (returning the default) instead of stopping, so that all faults of a scene come out at once. After the constructor
//! has run, the program (not the plugin) calls [`Params::finish`] and reports what nobody asked for. Building with an empty
//! list yields the plugin's parameter table.
//!
//! `files` has the files that plugins read, `from_param` the Rust types that parameters are read as, `spectra` the parameters that are spectra, `textures` those that may be
//! textures, `named` what a scene gives names.

use crate::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use crate::spectrum::{Spectrum, SpectrumRole};
use crate::value::{Param, ParamType};
use glam::DAffine3;
use std::cell::RefCell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::RangeInclusive;
use std::sync::Arc;

mod files;
mod from_param;
mod named;
mod spectra;
mod textures;

pub use files::{Decode, Decoded, Files, share};
pub use from_param::{FromParam, Normal3, Point2, Point3, Vector3};
pub use named::{Named, Nameless};
pub use spectra::Constant;

/// Makes spectra from parameters; implemented by the program over the spectrum plugins.
pub trait SpectrumSource {
    /// The spectrum that `param` (of type `spectrum`, `rgb`, `blackbody`, `tolman` or `float`) describes.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn build(&self, param: &Param, role: SpectrumRole, context: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>>;
}

/// One way to describe a spectrum. One implementation, one plugin, whose constructor gets no parameters: what a scene writes is the one parameter
/// that [`SpectrumMaker::make`] reads.
pub trait SpectrumMaker: Send + Sync {
    /// The names by which scenes ask for its spectra: the first text of a parameter of the type `spectrum`, without `/` and `.`, which are for
    /// files. Empty for one that the language chooses by type word and values.
    fn names(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// The spectrum that `param` describes, whose further texts are for the maker to read. Values that `role` does not admit are errors
    /// ([`SpectrumRole::fault`]).
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn make(&self, param: &Param, role: SpectrumRole, context: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>>;
}

/// What a plugin may know of the scene around it while it is built.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The files beside the scene.
    pub files: &'a dyn Files,
    /// The maker of spectra.
    pub spectra: &'a dyn SpectrumSource,
    /// The scene's textures, materials and pictures.
    pub named: &'a dyn Named,
    /// The current transform: from the plugin's own coordinates to world space.
    pub world_from_object: DAffine3,
    /// Whether `ReverseOrientation` is in force.
    pub reverse_orientation: bool,
    /// Width and height of the picture (pixels).
    pub resolution: [u32; 2],
    /// The range of wavelengths that the film records (nm).
    pub lambda_range: [f32; 2],
    /// The seed of the render.
    pub seed: u64,
}

/// Parameters that stand in for those which a plugin's own list does not give.
pub trait DefaultParams {
    /// The one called `name`.
    fn find(&self, name: &str) -> Option<&Param>;
}

/// Faults of one kind that are reported of the parameters of one plugin, one by one; the others are counted.
const MAX_REPORTED: usize = 20;

/// The parameters whose names have been given before, each behind the first one of its name.
fn repeated(params: &[Param]) -> Vec<(&Param, &Param)> {
    // Looking through a few costs less than a table of them.
    const FEW: usize = 16;
    if params.len() <= FEW {
        let first = |i: usize| params[..i].iter().find(|q| q.name.value == params[i].name.value);
        return (1..params.len()).filter_map(|i| Some((first(i)?, &params[i]))).collect();
    }
    let mut firsts: HashMap<&str, &Param> = HashMap::with_capacity(params.len());
    let again = params.iter().filter_map(|param| match firsts.entry(&param.name.value) {
        Entry::Occupied(first) => Some((*first.get(), param)),
        Entry::Vacant(none) => {
            none.insert(param);
            None
        }
    });
    again.collect()
}

/// One row of a plugin's parameter table.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamInfo {
    /// Name, without the type word.
    pub name: &'static str,
    /// Type word.
    pub ty: &'static str,
    /// The default as a scene would state it; `required` or `none` where there is none.
    pub default: String,
    /// Unit; empty for pure numbers.
    pub unit: &'static str,
    /// What it means, in a few words.
    pub about: &'static str,
}

/// The parameters of one plugin in one place of a scene, while its constructor reads them.
pub struct Params<'a> {
    owner: Spanned<String>,
    params: &'a [Param],
    /// Stand in for what `params` does not give.
    defaults: Option<&'a dyn DefaultParams>,
    context: Context<'a>,
    used: RefCell<Vec<bool>>,
    asked: RefCell<Vec<ParamInfo>>,
    found: RefCell<Vec<Diagnostic>>,
}

impl<'a> Params<'a> {
    /// The parameters `params` for the plugin `owner` (its name, at its place in the text).
    pub fn new(owner: Spanned<String>, params: &'a [Param], context: Context<'a>) -> Self {
        let p = Self {
            owner,
            params,
            defaults: None,
            context,
            used: RefCell::new(vec![false; params.len()]),
            asked: RefCell::default(),
            found: RefCell::default(),
        };
        let again = repeated(params);
        for (first, param) in again.iter().take(MAX_REPORTED) {
            p.report(
                Diagnostic::error("duplicate-parameter", format!("parameter `{}` is given twice", param.name.value))
                    .at(param.name.span, "given again here")
                    .and(first.name.span, "first given here")
                    .help("remove one of the two"),
            );
        }
        if let Some((_, next)) = again.get(MAX_REPORTED) {
            let message = format!("{} more parameters are given twice", again.len() - MAX_REPORTED);
            p.report(Diagnostic::error("duplicate-parameter", message).at(next.name.span, "this is the first of them"));
        }
        p
    }

    /// Adds parameters that count where the plugin's own list does not give them, and may remain unused.
    pub fn with_defaults(mut self, defaults: &'a dyn DefaultParams) -> Self {
        self.defaults = Some(defaults);
        self
    }

    /// What the plugin may know of the scene around it.
    pub fn context(&self) -> &Context<'a> {
        &self.context
    }

    /// The plugin's name as written, with its place.
    pub fn owner(&self) -> &Spanned<String> {
        &self.owner
    }

    /// The parameter `name`, with a default where the scene does not give it.
    pub fn get<T: FromParam>(&self, name: &'static str, default: T, unit: &'static str, about: &'static str) -> T {
        self.record::<T>(name, default.show(), unit, about);
        self.lookup(name).unwrap_or(default)
    }

    /// The parameter `name`, which must lie in `range`.
    pub fn get_in<T: FromParam + PartialOrd + Clone>(
        &self,
        name: &'static str,
        default: T,
        range: RangeInclusive<T>,
        unit: &'static str,
        about: &'static str,
    ) -> T {
        let value = self.get(name, default.clone(), unit, about);
        if range.contains(&value) {
            return value;
        }
        let (lo, hi) = (range.start().show(), range.end().show());
        self.reject(
            name,
            format!("`{name}` is out of range"),
            format!("expected a value from {lo} to {hi}, found {}", value.show()),
        );
        default
    }

    /// The parameter `name`, if the scene gives it.
    pub fn optional<T: FromParam>(&self, name: &'static str, unit: &'static str, about: &'static str) -> Option<T> {
        self.record::<T>(name, "none".into(), unit, about);
        self.lookup(name)
    }

    /// The parameter `name`; an error where the scene does not give it.
    pub fn require<T: FromParam>(&self, name: &'static str, unit: &'static str, about: &'static str) -> Option<T> {
        self.record::<T>(name, "required".into(), unit, about);
        let given = self.find(name).is_some();
        if !given {
            let owner = &self.owner;
            self.report(
                Diagnostic::error("missing-parameter", format!("`{}` needs the parameter `{name}`", owner.value))
                    .at(owner.span, "")
                    .help(format!("add \"{} {name}\" and its value: {about}", T::TYPES[0].word())),
            );
        }
        self.lookup(name)
    }

    /// Whether the scene gives the parameter `name`.
    pub fn is_given(&self, name: &str) -> bool {
        self.params.iter().any(|p| p.name.value == name)
    }

    /// Where the parameter `name` stands: its values if the scene gives it, else the plugin's name.
    pub fn span_of(&self, name: &str) -> Span {
        let own = self.params.iter().find(|p| p.name.value == name);
        own.or_else(|| self.defaults?.find(name)).map_or(self.owner.span, |p| p.span)
    }

    /// Reports that the value of `name` does not do; `cause` stands under it.
    pub fn reject(&self, name: &str, message: impl Into<String>, cause: impl Into<String>) {
        self.report(Diagnostic::error("bad-value", message).at(self.span_of(name), cause));
    }

    /// Adds a finding.
    pub fn report(&self, diagnostic: Diagnostic) {
        self.found.borrow_mut().push(diagnostic);
    }

    /// Ends the reading: what was wrong, what nobody asked for, and the table of what was asked for.
    pub fn finish(self) -> (Vec<Diagnostic>, Vec<ParamInfo>) {
        let asked = self.asked.into_inner();
        let mut found = self.found.into_inner();
        let names: Vec<&str> = asked.iter().map(|a| a.name).collect();
        let used = self.used.into_inner();
        let unknown: Vec<&Param> = self.params.iter().zip(used).filter(|(_, used)| !used).map(|(param, _)| param).collect();
        for param in unknown.iter().take(MAX_REPORTED) {
            let (name, owner) = (&param.name.value, &self.owner.value);
            let help = match did_you_mean(name, names.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if names.is_empty() => format!("`{owner}` takes no parameters"),
                None => format!("`{owner}` takes {}", names.join(", ")),
            };
            found.push(
                Diagnostic::error("unknown-parameter", format!("unknown parameter `{name}`"))
                    .at(param.name.span, format!("`{owner}` has no such parameter"))
                    .help(help),
            );
        }
        if let Some(next) = unknown.get(MAX_REPORTED) {
            let message = format!("{} more unknown parameters", unknown.len() - MAX_REPORTED);
            found.push(Diagnostic::error("unknown-parameter", message).at(next.name.span, "this is the first of them"));
        }
        (found, asked)
    }

    fn record<T: FromParam>(&self, name: &'static str, default: String, unit: &'static str, about: &'static str) {
        self.ask(ParamInfo { name, ty: T::TYPES[0].word(), default, unit, about });
    }

    /// Adds a row to the parameter table.
    fn ask(&self, info: ParamInfo) {
        self.asked.borrow_mut().push(info);
    }

    /// Changes the type in the last row of the parameter table.
    fn relabel(&self, ty: &'static str) {
        if let Some(last) = self.asked.borrow_mut().last_mut() {
            last.ty = ty;
        }
    }

    /// The parameter `name` as the scene gives it; it counts as used.
    fn find(&self, name: &str) -> Option<&'a Param> {
        let Some(i) = self.params.iter().position(|p| p.name.value == name) else {
            return self.defaults?.find(name);
        };
        self.used.borrow_mut()[i] = true;
        // A second one of the same name has been reported already; it is not unknown.
        for (j, p) in self.params.iter().enumerate().skip(i + 1) {
            if p.name.value == name {
                self.used.borrow_mut()[j] = true;
            }
        }
        Some(&self.params[i])
    }

    /// The value of the parameter `name`, if the scene gives it and it is one of the type.
    fn lookup<T: FromParam>(&self, name: &str) -> Option<T> {
        let param = self.find(name)?;
        // As in pbrt, whole numbers pass for real ones, whatever the type word says of them.
        let (found, expected) = (param.ty.value, T::TYPES[0]);
        let integer_for_float = found == ParamType::Integer && expected == ParamType::Float;
        if !T::TYPES.contains(&found) && !integer_for_float {
            let message = format!("`{name}` has the type `{}`, not `{}`", expected.word(), found.word());
            self.wrong_type(param, &message, expected.word());
            return None;
        }
        match T::read(&param.values) {
            Ok(value) => Some(value),
            Err(expected) => {
                self.report(
                    Diagnostic::error("wrong-value", format!("`{name}` expects {expected}"))
                        .at(param.span, format!("found {}", param.values.describe())),
                );
                None
            }
        }
    }

    fn wrong_type(&self, param: &Param, message: &str, expected: &str) {
        self.report(
            Diagnostic::error("wrong-type", message)
                .at(param.ty.span, format!("expected `{expected}`"))
                .help(format!("write \"{expected} {}\"", param.name.value)),
        );
    }
}
