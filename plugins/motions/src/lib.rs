//! Motions: who moves how. One file, one plugin.
//!
//! A motion is a parameter of what moves, `"string motion" "name"`, and its parameters stand beside that.

mod axis;
mod infalling;
mod keplerian;
mod rotating;
mod r#static;
mod velocity;
mod zamo;

use bhs_core::Plugin;
use bhs_core::motion::Motion;

/// All motions, by name.
pub const ALL: &[Plugin<dyn Motion>] =
    &[infalling::PLUGIN, keplerian::PLUGIN, rotating::PLUGIN, r#static::PLUGIN, velocity::PLUGIN, zamo::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["axis"]);
}
