//! What only holes that spin have: light whose equations separate, in the oblate chart.
//!
//! `orbit` has its constants and its fate, `series` steps of it; these know no surfaces. `arc` makes curves of steps, `course` leads light along them. `connect` finds the light
//! that joins two points, `connections` offers it to light sampling.

pub mod arc;
pub mod connect;
pub mod connections;
pub mod course;
pub mod orbit;
pub mod series;
