//! What integrators and light transports run on.
//!
//! A [`world::World`] is surfaces with their intersector in a spacetime, all that integrators see; `clearance` tells them where space is free.
//! A [`scene::Scene`] is a world with an integrator, materials and lights, all that light transports see; [`light_sampling`] draws points of its
//! lights, [`forward`] follows light from there, [`stats`] and [`path_log`] are what following its rays leaves behind, [`way`] what a ray shows of its curve. The contracts that speak of these stand here:
//! [`integrator`], [`connections`], [`transport`] and [`layer`]. All other contracts stand in `bhs-core`.
//!
//! Everything is in render space, in the units of `bhs-core`.

pub mod clearance;
pub mod connections;
pub mod forward;
pub mod integrator;
pub mod layer;
pub mod light_sampling;
pub mod patch;
pub mod path_log;
pub mod scene;
mod shading_frame;
pub mod stats;
pub mod transport;
pub mod way;
pub mod world;
