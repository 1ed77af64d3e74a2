//! `Attribute "shape" ...`: parameters for all directives of a kind that follow, where these do not state them themselves.

use crate::lang::defaults::{AttributeParam, Defaults, Target};
use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use bhs_core::diagnostics::{did_you_mean, shorten};
use std::sync::Arc;

/// The parameters that are in force.
#[derive(Clone, Default)]
pub(super) struct Attributes([Defaults; Target::ALL.len()]);

impl Attributes {
    /// Those for one kind of directive.
    pub fn of(&self, target: Target) -> Defaults {
        self.0[target as usize].clone()
    }

    /// Those for shapes alone: a file's own materials, textures and lights are what the file says.
    pub fn of_shapes_alone(&self) -> Self {
        let mut alone = Self::default();
        alone.0[Target::Shape as usize] = self.of(Target::Shape);
        alone
    }
}

impl Resolver<'_> {
    pub(crate) fn attribute(&mut self, call: Call) {
        let Some(target) = Target::ALL.into_iter().find(|t| t.word() == call.name.value) else {
            let help = match did_you_mean(&call.name.value, Target::ALL.map(Target::word)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there is {}", Target::ALL.map(Target::word).join(", ")),
            };
            let message = format!("`Attribute` knows no `{}`", shorten(&call.name.value));
            return self.error("unknown-attribute-target", message, call.name.span, "", help);
        };
        if call.params.is_empty() && !call.faulty {
            let help = "such as Attribute \"shape\" \"float radius\" 2";
            self.error("missing-parameter", "`Attribute` needs a parameter", call.keyword, "", help);
        }
        for param in call.params {
            let new = Arc::new(AttributeParam::new(target, param));
            self.scene.attributes.push(Arc::clone(&new));
            self.state.attributes.0[target as usize].set(new);
        }
    }
}
