//! The contract between bhs and its plugins.
//!
//! A plugin sees this crate and nothing else of the program: the parameters it is built from ([`params`]), spectra and
//! sampled wavelengths ([`spectrum`]), random numbers ([`sampling`]), geometry ([`geometry`], [`world`]), what light moves
//! through and who observes it there ([`spacetime`], [`observer`]), and one trait for each kind of plugin. There is no input, no output and no panic on a
//! user's data in here.
//!
//! Units: lengths in scene units (G = c = 1), angles in radians, wavelengths in nanometres, spectral radiance in
//! W m^-2 sr^-1 nm^-1. Frames: *chart* is the areal Schwarzschild chart drawn as Euclidean space, *local* is what the static
//! observer at a point measures; *render space* is the chart moved so that the scene lies near the origin.

pub mod camera;
pub mod clearance;
mod clearance_instances;
pub mod composite;
pub mod diagnostics;
pub mod dual;
pub mod geometry;
pub mod image;
pub mod instance;
pub mod integrator;
pub mod intersector;
pub mod lanes;
pub mod layer;
pub mod light;
pub mod light_sampling;
pub mod material;
pub mod motion;
pub mod observer;
pub mod params;
pub mod path_log;
pub mod plugin;
pub mod real;
pub mod sampling;
pub mod scene;
pub mod spacetime;
pub mod spectrum;
pub mod stats;
pub mod texture;
pub mod transport;
pub mod value;
pub mod world;

pub use plugin::Plugin;
