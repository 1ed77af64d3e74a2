//! Parameters that `Attribute` states for directives of a kind, where these do not state them themselves.

use bhs_core::diagnostics::{Diagnostic, shorten};
use bhs_core::params::DefaultParams;
use bhs_core::value::Param;
use rpds::RedBlackTreeMapSync;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What parameters can be stated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// `Shape`.
    Shape,
    /// `LightSource` and `AreaLightSource`.
    Light,
    /// `Material` and `MakeNamedMaterial`.
    Material,
    /// `Texture`.
    Texture,
}

impl Target {
    /// All of them.
    pub(super) const ALL: [Target; 4] = [Self::Shape, Self::Light, Self::Material, Self::Texture];

    /// The word that `Attribute` uses.
    pub fn word(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Light => "light",
            Self::Material => "material",
            Self::Texture => "texture",
        }
    }
}

/// A parameter that `Attribute` states.
#[derive(Debug)]
pub struct AttributeParam {
    /// What it is for.
    pub target: Target,
    /// The parameter.
    pub param: Param,
    /// Whether a plugin has asked for it.
    taken: AtomicBool,
}

impl AttributeParam {
    /// One that no plugin has asked for yet.
    pub(super) fn new(target: Target, param: Param) -> Self {
        Self { target, param, taken: AtomicBool::new(false) }
    }

    /// Notes that a plugin knows this parameter, or that it is not worth a warning.
    fn take(&self) {
        self.taken.store(true, Ordering::Relaxed);
    }
}

/// The parameters that are in force for one kind of directive, by name. Each directive keeps those that were in force where it stands:
/// a tree that shares its branches, so that very many directives and parameters take little room.
#[derive(Clone, Debug, Default)]
pub struct Defaults(RedBlackTreeMapSync<String, Arc<AttributeParam>>);

impl Defaults {
    /// Notes that a plugin knows the parameter `name`, if it is one of these.
    pub fn take(&self, name: &str) {
        if let Some(param) = self.0.get(name) {
            param.take();
        }
    }

    /// Whether the same parameters have the same values.
    pub(super) fn same(&self, other: &Self) -> bool {
        self.0.size() == other.0.size() && self.0.iter().zip(other.0.iter()).all(|((_, a), (_, b))| a.param == b.param)
    }

    /// Adds one, in place of one of the same name.
    pub(super) fn set(&mut self, new: Arc<AttributeParam>) {
        // One that is replaced before it is used is not worth a warning.
        self.take(&new.param.name.value);
        self.0.insert_mut(new.param.name.value.clone(), new);
    }
}

impl DefaultParams for Defaults {
    fn find(&self, name: &str) -> Option<&Param> {
        self.0.get(name).map(|a| &a.param)
    }
}

/// Parameters of `Attribute` that no plugin has asked for.
pub(super) fn warn_unused(stated: &[Arc<AttributeParam>], found: &mut Vec<Diagnostic>) {
    for attribute in stated.iter().filter(|a| !a.taken.load(Ordering::Relaxed)) {
        let (param, word) = (&attribute.param, attribute.target.word());
        found.push(
            Diagnostic::warning("unused-attribute", format!("`{}` is never used", shorten(&param.name.value)))
                .at(param.name.span, format!("no {word} that follows has this parameter"))
                .help(format!("`bhs plugins {word}` lists the parameters")),
        );
    }
}
