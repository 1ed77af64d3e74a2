//! How light travels: the integrators of light rays. One file, one plugin; `orbit` and `chords` are what the curved ones share.

mod chords;
pub mod orbit;
mod schwarzschild_rk4;
mod straight;

pub use schwarzschild_rk4::Rk4;

use bhs_core::Plugin;
use bhs_core::integrator::Integrator;

/// All integrators, by name.
pub const ALL: &[Plugin<dyn Integrator>] = &[schwarzschild_rk4::PLUGIN, straight::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["orbit", "chords"]);
}
