//! What only holes that spin have: light whose equations separate, in the oblate chart.
//!
//! `orbit` has its constants and its fate, `series` steps of it.

pub mod orbit;
pub mod series;
