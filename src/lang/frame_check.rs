//! Whether the other frames of an animation can be rendered, if its first one can: found out without what they share.

use crate::lang::build::build;
use crate::lang::description::{Entity, SceneDescription};
use crate::lang::overrides::Overrides;
use crate::lang::resolve::resolve_with;
use crate::lang::source::SourceMap;
use crate::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Severity};
use std::path::Path;

/// What the first frame of a scene is made of.
pub struct FrameCheck(SceneDescription);

impl FrameCheck {
    /// Reads the first frame, which can be built.
    ///
    /// # Errors
    /// If it cannot be read any more.
    pub fn of_first(scene: &Path, overrides: &Overrides, sources: &mut SourceMap) -> Result<Self, Vec<Diagnostic>> {
        let file = sources.open(scene).map_err(|d| vec![*d])?;
        Ok(Self(resolve_with(sources, file, &overrides.variables).0))
    }

    /// What is wrong with another frame. Shapes and lights that are those of the first frame are not made again.
    pub fn errors(&self, scene: &Path, registry: &Registry, overrides: &Overrides, sources: &mut SourceMap) -> Vec<Diagnostic> {
        let file = match sources.open(scene) {
            Ok(file) => file,
            Err(fault) => return vec![*fault],
        };
        let (mut description, mut found) = resolve_with(sources, file, &overrides.variables);
        if !crate::lang::has_errors(&found) {
            self.leave_out(&mut description);
            found = build(description, found, registry, overrides, sources).err().unwrap_or_default();
        }
        found.retain(|d| d.severity == Severity::Error);
        found
    }

    /// Leaves out of a frame what is as in the first one, and so is right.
    fn leave_out(&self, frame: &mut SceneDescription) {
        let first = &self.0;
        let moves = match (&first.spacetime, &frame.spacetime) {
            (Some(a), Some(b)) => !same(a, b),
            (a, b) => a.is_some() != b.is_some(),
        };
        // Where the hole moves, what stands still may come to lie in it.
        if moves || first.shapes.len() != frame.shapes.len() || first.lights.len() != frame.lights.len() {
            return;
        }
        let instances_stay = first.instances == frame.instances;
        let mut others = first.shapes.iter();
        frame.shapes.retain(|shape| {
            let is_same = others.next().is_some_and(|first| same(&first.entity, &shape.entity));
            !(is_same && (shape.object.is_none() || instances_stay))
        });
        if instances_stay {
            frame.instances.clear();
        }
        let mut others = first.lights.iter();
        frame.lights.retain(|light| !others.next().is_some_and(|first| same(first, light)));
    }
}

/// Whether two frames have the same plugin with the same parameters at the same place.
fn same(a: &Entity, b: &Entity) -> bool {
    a.name == b.name
        && a.params == b.params
        && a.defaults.same(&b.defaults)
        && a.world_from_object == b.world_from_object
        && a.side == b.side
}
