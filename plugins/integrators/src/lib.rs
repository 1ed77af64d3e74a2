//! How light travels: the integrators of light rays. One file, one plugin.
//!
//! `tracer` knows which way of following rays belongs to which class of spacetimes: `spherical` orbits in planes, `graded_index` the rays of a
//! refractive index, `general` those of any metric by Hamilton's equations. Each gives curves as `tracing::arc` has them, and `tracing` leads them
//! through a world of surfaces. `connections` are the rays between two points, those of round spacetimes but the plain hole in `round`, those among
//! several holes in `several`. `arithmetic` is what they compute with.

mod adaptive;
pub mod arithmetic;
mod connections;
mod exact;
pub mod general;
pub mod graded_index;
pub mod kerr;
mod micro_steps;
mod rk4;
pub mod round;
pub mod several;
pub mod spherical;
mod straight;
mod tolerance;
mod tracer;
pub mod tracing;

pub use adaptive::Adaptive;
pub use exact::Exact;
pub use general::General;
pub use micro_steps::MicroSteps;
pub use rk4::Rk4;
pub use spherical::{closed_form, orbit, taylor};
pub use straight::Straight;
pub use tolerance::Tolerance;

use bhs_core::Plugin;
use bhs_engine::integrator::IntegratorBuilder;

/// All integrators, by name.
pub const ALL: &[Plugin<dyn IntegratorBuilder>] =
    &[adaptive::PLUGIN, exact::PLUGIN, general::PLUGIN, micro_steps::PLUGIN, rk4::PLUGIN, straight::PLUGIN];

/// Other names of some of them, under which they were known first, and what they stand for.
pub const OTHER_NAMES: &[(&str, &str)] =
    &[("schwarzschild-adaptive", "adaptive"), ("schwarzschild-exact", "exact"), ("schwarzschild-rk4", "rk4")];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["connections", "tolerance", "tracer"]);
}
