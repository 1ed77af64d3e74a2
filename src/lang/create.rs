//! One plugin, as a directive asks for it.

use crate::lang::description::Entity;
use crate::registry::{Kind, Registry};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Context, Params};

/// Makes a plugin under the transform of its directive.
pub(super) fn create<T: Kind + ?Sized>(
    e: &Entity,
    registry: &Registry,
    context: Context,
    found: &mut Vec<Diagnostic>,
) -> Option<Box<T>> {
    registry.create::<T>(e, Context { world_from_object: *e.world_from_object, ..context }, found)
}

/// The same with what the directive itself reads: see [`Registry::create_with`].
pub(super) fn create_with<T: Kind + ?Sized, D>(
    e: &Entity,
    registry: &Registry,
    context: Context,
    found: &mut Vec<Diagnostic>,
    read: impl FnOnce(&Params) -> Option<D>,
) -> (Option<Box<T>>, Option<D>) {
    registry.create_with::<T, D>(e, Context { world_from_object: *e.world_from_object, ..context }, found, read)
}
