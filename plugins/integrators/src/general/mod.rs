//! Rays of any stationary metric, by Hamilton's equations: one at a time, slow, and the measure of all other ways. Knows no surfaces.
//!
//! `hamilton` has the equations, `path` the steps, `escape` says where rays go that leave.

mod escape;
pub mod hamilton;
pub mod path;

pub use path::{Advance, Fate, Paths, Surroundings};
