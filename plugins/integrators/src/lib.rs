//! How light travels: the integrators of light rays. One file, one plugin.
//!
//! What the curved ones share: `orbit` (steps of an orbit and their dense output), `closed_form` and `taylor` (orbits), `chords`,
//! `refine` and `resolve` (from steps to hits), `flight` (one ray from start to end), `packet` with `packet_orbit`,
//! `packet_leaps` and `packet_hits` (several rays side by side), `connect` and `joined`
//! (rays between two points), `connect_sky` (rays to a direction of the sky), `arithmetic`.
//!
//! `graded_index` follows the rays of refractive indices, `general` those of any metric by Hamilton's equations; both give curves as
//! `tracing::arc` has them. `tracing` leads any such ray through a world of surfaces; `in_spacetime` is the integrators in spacetimes other than
//! flat space and the plain hole.

pub mod arithmetic;
pub mod chords;
pub mod connect;
mod connect_lanes;
pub mod connect_sky;
mod connect_solve;
pub mod flight;
pub mod general;
pub mod graded_index;
mod in_spacetime;
pub mod joined;
mod micro_steps;
mod packet;
mod packet_hits;
mod packet_leaps;
pub mod refine;
mod resolve;
pub mod round;
mod schwarzschild_adaptive;
mod schwarzschild_exact;
mod schwarzschild_rk4;
pub mod spherical;
mod straight;
pub mod tracing;

pub use general::General;
pub use schwarzschild_adaptive::Adaptive;
pub use schwarzschild_exact::Exact;
pub use schwarzschild_rk4::Rk4;
pub use spherical::{closed_form, orbit, taylor};
pub use straight::Straight;

use bhs_core::Plugin;
use bhs_core::integrator::Integrator;

/// All integrators, by name.
pub const ALL: &[Plugin<dyn Integrator>] = &[
    general::PLUGIN,
    micro_steps::PLUGIN,
    schwarzschild_adaptive::PLUGIN,
    schwarzschild_exact::PLUGIN,
    schwarzschild_rk4::PLUGIN,
    straight::PLUGIN,
];

/// Short names of some of them, and what they stand for.
pub const SHORT_NAMES: &[(&str, &str)] =
    &[("adaptive", "schwarzschild-adaptive"), ("exact", "schwarzschild-exact"), ("rk4", "schwarzschild-rk4")];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL],
        helpers: ["chords", "connect", "connect_lanes", "connect_sky", "connect_solve", "flight", "joined", "packet", "packet_hits", "packet_leaps",             "refine", "resolve"]);
}
