//! How a plugin reads its parameters: its constructor is its schema.
//!
//! Every `get` records the name it asked for with type, default, unit and meaning, marks the parameter as used, and collects an
//! error (returning the default) instead of stopping, so that all faults of a scene come out at once. After the constructor
//! has run, the program (not the plugin) calls [`Params::finish`] and reports what nobody asked for. Building with an empty
//! list yields the plugin's parameter table.

use crate::blackhole::BlackHole;
use crate::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use crate::spectrum::{Spectrum, SpectrumRole};
use crate::texture::Named;
use crate::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec2, DVec3};
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Files as plugins see them: the contract does no input or output itself.
pub trait Files {
    /// The whole content of the file that the text at `span` calls `path`; a relative path starts at the folder of the file
    /// that `span` lies in.
    ///
    /// # Errors
    /// What is wrong with the file, in words that can follow "cannot read `path`: ".
    fn read(&self, path: &str, span: Span) -> Result<Vec<u8>, String>;
}

/// Makes spectra from parameters; implemented by the program over the spectrum plugins.
pub trait SpectrumSource {
    /// The spectrum that `param` (of type `spectrum`, `rgb`, `blackbody`, `tolman` or `float`) describes.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn build(&self, param: &Param, role: SpectrumRole, context: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>>;
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
    /// The scene's black hole, if there is one.
    pub hole: Option<&'a BlackHole>,
    /// Width and height of the picture (pixels).
    pub resolution: [u32; 2],
    /// The range of wavelengths that the film records (nm).
    pub lambda_range: [f32; 2],
    /// The seed of the render.
    pub seed: u64,
}

/// A place, as `"point3 name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point3(pub DVec3);

/// A direction, as `"vector3 name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector3(pub DVec3);

/// A surface normal, as `"normal name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal3(pub DVec3);

/// A pair, as `"point2 name" [x y]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point2(pub DVec2);

/// A Rust type that a parameter can be read as.
pub trait FromParam: Sized {
    /// The type words that are accepted, the proper one first.
    const TYPES: &'static [ParamType];
    /// Reads the values.
    ///
    /// # Errors
    /// What was expected, in words such as `an integer`.
    fn read(values: &Values) -> Result<Self, String>;
    /// The value as a scene would state it, for the parameter tables.
    fn show(&self) -> String;
}

fn numbers(values: &Values) -> Option<&[f64]> {
    match values {
        Values::Numbers { values, .. } => Some(values),
        _ => None,
    }
}

impl FromParam for f64 {
    const TYPES: &'static [ParamType] = &[ParamType::Float];
    fn read(values: &Values) -> Result<Self, String> {
        match numbers(values) {
            Some([x]) => Ok(*x),
            _ => Err("a number".into()),
        }
    }
    fn show(&self) -> String {
        format!("{self}")
    }
}

impl FromParam for i64 {
    const TYPES: &'static [ParamType] = &[ParamType::Integer];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Numbers { values, whole: true } if values.len() == 1 => Ok(values[0] as i64),
            _ => Err("an integer".into()),
        }
    }
    fn show(&self) -> String {
        format!("{self}")
    }
}

impl FromParam for bool {
    const TYPES: &'static [ParamType] = &[ParamType::Bool];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Bools(b) if b.len() == 1 => Ok(b[0]),
            _ => Err("`true` or `false`".into()),
        }
    }
    fn show(&self) -> String {
        format!("{self}")
    }
}

impl FromParam for String {
    const TYPES: &'static [ParamType] = &[ParamType::String];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Strings(s) if s.len() == 1 => Ok(s[0].value.clone()),
            _ => Err("a string".into()),
        }
    }
    fn show(&self) -> String {
        format!("\"{self}\"")
    }
}

impl FromParam for Vec<Spanned<String>> {
    const TYPES: &'static [ParamType] = &[ParamType::String];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Strings(s) => Ok(s.clone()),
            _ => Err("strings".into()),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(|s| format!("\"{}\"", s.value)).collect::<Vec<_>>().join(" "))
    }
}

impl FromParam for Vec<f64> {
    const TYPES: &'static [ParamType] = &[ParamType::Float];
    fn read(values: &Values) -> Result<Self, String> {
        numbers(values).map(<[f64]>::to_vec).ok_or_else(|| "numbers".into())
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
    }
}

impl FromParam for Vec<i64> {
    const TYPES: &'static [ParamType] = &[ParamType::Integer];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Numbers { values, whole: true } => Ok(values.iter().map(|v| *v as i64).collect()),
            _ => Err("integers".into()),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(i64::to_string).collect::<Vec<_>>().join(" "))
    }
}

macro_rules! tuple_param {
    ($name:ident, $ty:expr, $n:literal, $vec:ident, $one:literal, $many:literal) => {
        impl FromParam for $name {
            const TYPES: &'static [ParamType] = &[$ty];
            fn read(values: &Values) -> Result<Self, String> {
                match numbers(values) {
                    Some(v) if v.len() == $n => Ok($name($vec::from_slice(v))),
                    _ => Err($one.into()),
                }
            }
            fn show(&self) -> String {
                self.0.to_array().to_vec().show()
            }
        }
        impl FromParam for Vec<$name> {
            const TYPES: &'static [ParamType] = &[$ty];
            fn read(values: &Values) -> Result<Self, String> {
                match numbers(values) {
                    Some(v) if v.len() % $n == 0 => Ok(v.chunks_exact($n).map(|c| $name($vec::from_slice(c))).collect()),
                    _ => Err($many.into()),
                }
            }
            fn show(&self) -> String {
                self.iter().flat_map(|p| p.0.to_array()).collect::<Vec<f64>>().show()
            }
        }
    };
}
tuple_param!(Point2, ParamType::Point2, 2, DVec2, "2 numbers", "a multiple of 2 numbers");
tuple_param!(Point3, ParamType::Point3, 3, DVec3, "3 numbers", "a multiple of 3 numbers");
tuple_param!(Vector3, ParamType::Vector3, 3, DVec3, "3 numbers", "a multiple of 3 numbers");
tuple_param!(Normal3, ParamType::Normal, 3, DVec3, "3 numbers", "a multiple of 3 numbers");

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
    defaults: Vec<&'a Param>,
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
            defaults: Vec::new(),
            context,
            used: RefCell::new(vec![false; params.len()]),
            asked: RefCell::default(),
            found: RefCell::default(),
        };
        for (i, param) in params.iter().enumerate() {
            if let Some(first) = params[..i].iter().find(|q| q.name.value == param.name.value) {
                p.report(
                    Diagnostic::error("duplicate-parameter", format!("parameter `{}` is given twice", param.name.value))
                        .at(param.name.span, "given again here")
                        .and(first.name.span, "first given here")
                        .help("remove one of the two"),
                );
            }
        }
        p
    }

    /// Adds parameters that count where the plugin's own list does not give them, and may remain unused.
    pub fn with_defaults(mut self, defaults: Vec<&'a Param>) -> Self {
        self.defaults = defaults;
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

    /// The spectrum `name`; where the scene does not give it, `default` at all wavelengths.
    pub fn spectrum(
        &self,
        name: &'static str,
        default: f32,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Arc<dyn Spectrum> {
        self.optional_spectrum(name, default.to_string(), role, unit, about).unwrap_or_else(|| Arc::new(Constant(default)))
    }

    /// The spectrum `name`; where the scene does not give it, the built-in spectrum called `default`.
    pub fn named_spectrum(
        &self,
        name: &'static str,
        default: &'static str,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Arc<dyn Spectrum> {
        if let Some(given) = self.optional_spectrum(name, format!("\"{default}\""), role, unit, about) {
            return given;
        }
        self.builtin_spectrum(name, default, role)
    }

    /// The built-in spectrum called `default`, in place of the parameter `name`.
    pub(crate) fn builtin_spectrum(&self, name: &str, default: &str, role: SpectrumRole) -> Arc<dyn Spectrum> {
        let span = self.owner.span;
        let param = Param {
            ty: Spanned::new(ParamType::Spectrum, span),
            name: Spanned::new(name.to_owned(), span),
            values: Values::Strings(vec![Spanned::new(default.to_owned(), span)]),
            span,
        };
        self.build_spectrum(&param, role).unwrap_or_else(|| Arc::new(Constant(1.0)))
    }

    /// The spectrum `name`, if the scene gives it (and it can be built); `shown` is the default for the parameter table.
    pub fn optional_spectrum(
        &self,
        name: &'static str,
        shown: String,
        role: SpectrumRole,
        unit: &'static str,
        about: &'static str,
    ) -> Option<Arc<dyn Spectrum>> {
        self.ask(ParamInfo { name, ty: "spectrum", default: shown, unit, about });
        let param = self.find(name)?;
        match param.ty.value {
            ParamType::Spectrum | ParamType::Rgb | ParamType::Blackbody | ParamType::Tolman | ParamType::Float => {
                self.build_spectrum(param, role)
            }
            other => {
                self.wrong_type(
                    param,
                    &format!("`{name}` takes a spectrum, not a value of the type `{}`", other.word()),
                    "spectrum",
                );
                None
            }
        }
    }

    /// Whether the scene gives the parameter `name`.
    pub fn is_given(&self, name: &str) -> bool {
        self.params.iter().any(|p| p.name.value == name)
    }

    /// Where the parameter `name` stands: its values if the scene gives it, else the plugin's name.
    pub fn span_of(&self, name: &str) -> Span {
        let mut all = self.params.iter().chain(self.defaults.iter().copied());
        all.find(|p| p.name.value == name).map_or(self.owner.span, |p| p.span)
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
        for (param, used) in self.params.iter().zip(self.used.into_inner()) {
            if used {
                continue;
            }
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
        (found, asked)
    }

    fn record<T: FromParam>(&self, name: &'static str, default: String, unit: &'static str, about: &'static str) {
        self.ask(ParamInfo { name, ty: T::TYPES[0].word(), default, unit, about });
    }

    /// Adds a row to the parameter table.
    pub(crate) fn ask(&self, info: ParamInfo) {
        self.asked.borrow_mut().push(info);
    }

    /// Changes the type in the last row of the parameter table.
    pub(crate) fn relabel(&self, ty: &'static str) {
        if let Some(last) = self.asked.borrow_mut().last_mut() {
            last.ty = ty;
        }
    }

    /// The parameter `name` as the scene gives it; it counts as used.
    pub(crate) fn find(&self, name: &str) -> Option<&'a Param> {
        let Some(i) = self.params.iter().position(|p| p.name.value == name) else {
            return self.defaults.iter().copied().find(|p| p.name.value == name);
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
    pub(crate) fn lookup<T: FromParam>(&self, name: &str) -> Option<T> {
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

    fn build_spectrum(&self, param: &Param, role: SpectrumRole) -> Option<Arc<dyn Spectrum>> {
        match self.context.spectra.build(param, role, &self.context) {
            Ok(spectrum) => Some(spectrum),
            Err(found) => {
                self.found.borrow_mut().extend(found);
                None
            }
        }
    }
}

/// The same value at all wavelengths; stands in where a plugin states a number as its default.
#[derive(Debug)]
pub(crate) struct Constant(pub(crate) f32);

impl Spectrum for Constant {
    fn at(&self, _: f32) -> f32 {
        self.0
    }
    fn max(&self, _: f32, _: f32) -> f32 {
        self.0
    }
    fn is_constant(&self) -> bool {
        true
    }
}
