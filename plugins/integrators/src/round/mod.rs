//! Rays from point to point of round static spacetimes: wormholes, one extremal hole, charged holes. One problem in a plane.
//!
//! `profile` is what they differ by, `swept` the angle that a ray sweeps, as a quadrature, `solve` finds the ray of a given angle, `rays` the
//! ones between two places, with their spreads. `charged` offers those around charged holes for light sampling, `graded_index` those of the others.

pub mod charged;
pub mod profile;
pub mod rays;
pub mod solve;
pub mod swept;
