//! Motions: who moves how. One file, one plugin.
//!
//! A motion is a parameter of what moves, `"string motion" "name"`, and its parameters stand beside that.

mod r#static;
mod velocity;

use bhs_core::Plugin;
use bhs_core::motion::Motion;

/// All motions, by name.
pub const ALL: &[Plugin<dyn Motion>] = &[r#static::PLUGIN, velocity::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: []);
}
