//! Spacetimes: what light moves through. One file, one plugin.
//!
//! A spacetime of no mass, or a wormhole without a throat, is flat ([`Minkowski`]), whatever its name. Formulas: `docs/physics.md`.
//!
//! `placement` reads lengths and places under the current transform, `round` is what the two round holes have in common, `graded` what
//! graded indices have in common.

mod dneg;
mod ellis;
mod graded;
mod kerr;
mod majumdar_papapetrou;
mod minkowski;
mod placement;
mod reissner_nordstrom;
mod round;
mod schwarzschild;

pub use bhs_core::spacetime::Kerr;
pub use bhs_core::spacetime::Minkowski;
pub use dneg::Dneg;
pub use ellis::Ellis;
pub use majumdar_papapetrou::{Hole, MajumdarPapapetrou};

use bhs_core::Plugin;
use bhs_core::spacetime::Spacetime;

/// All spacetimes, by name.
pub const ALL: &[Plugin<dyn Spacetime>] = &[
    dneg::PLUGIN,
    ellis::PLUGIN,
    kerr::PLUGIN,
    majumdar_papapetrou::PLUGIN,
    minkowski::PLUGIN,
    reissner_nordstrom::PLUGIN,
    schwarzschild::PLUGIN,
];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["graded", "placement", "round"]);
}
