//! The contract between bhs and its plugins.
//!
//! A plugin sees this crate: the parameters it is built from ([`params`]), spectra and sampled wavelengths ([`spectrum`]), random numbers
//! ([`sampling`]), rays ([`ray`]), geometry ([`geometry`]), spacetimes and the observers in them ([`spacetime`], [`observer`]), and
//! one trait for each kind of plugin. Integrators, light transports and layers, which follow rays through a world of surfaces or see what these
//! meet, see `bhs-engine` too. There is no input, no output and no panic on a user's data in here.
//!
//! [`real`], [`lanes`] and [`dual`] are arithmetic: numbers one at a time, of eight rays side by side, and with derivatives. They stand here
//! because the contracts of spacetimes ([`spacetime::GradedIndex`], [`spacetime::Metric`]) are in terms of them. [`quadrature`] has integrals.
//!
//! Units: lengths in scene units (G = c = 1), angles in radians, wavelengths in nanometres, spectral radiance in
//! W m^-2 sr^-1 nm^-1. Frames: *chart* is the chart of the spacetime drawn as Euclidean space, *local* is what the static
//! observer at a point measures; *render space* is the chart moved so that the scene lies near the origin.

pub mod camera;
pub mod diagnostics;
pub mod dual;
pub mod equal_area;
pub mod geometry;
pub mod image;
pub mod intersector;
pub mod lanes;
pub mod light;
pub mod material;
pub mod motion;
pub mod observer;
pub mod params;
pub mod plugin;
pub mod quadrature;
pub mod ray;
pub mod real;
pub mod sampling;
pub mod spacetime;
pub mod spectrum;
pub mod texture;
pub mod value;

pub use plugin::Plugin;
