//! Causes in how light is gathered.

use crate::lang::BuiltScene;
use bhs_core::diagnostics::Diagnostic;

/// Code of paths without a bounce.
pub const MAX_DEPTH: &str = "max-depth-zero";

/// With `maxdepth` 0 what does not emit is black.
pub fn no_scattering(built: &BuiltScene) -> Option<Diagnostic> {
    let transport = &built.statements.transport;
    if transport.number("maxdepth") != Some(0.0) {
        return None;
    }
    let dark = built.scene.shapes.iter().find(|shape| shape.emitter.is_none())?;
    let message = "with `maxdepth` 0 no surface scatters light: all that does not emit itself is black";
    let found = Diagnostic::warning(MAX_DEPTH, message).at(transport.param("maxdepth")?.span, "");
    let shape = built.statements.shape(dark.index);
    let found = match shape {
        Some((_, at)) => found.and(at.span, "such as this shape"),
        None => found,
    };
    Some(found.help("write \"integer maxdepth\" 5, or leave it out"))
}
