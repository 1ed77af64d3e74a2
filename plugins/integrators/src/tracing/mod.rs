//! How rays meet surfaces, whatever bends them: knows curves, and no spacetime.
//!
//! `arc` is all that is seen of a curve, `polynomial_arc` one kind of it. `driver` follows a ray from piece to piece, `chords` puts chords of a
//! piece to the surfaces of one side, `extent` says how precisely, `meeting` finds where the curve itself meets what a chord of it meets.

pub mod arc;
pub mod chords;
pub mod driver;
pub mod extent;
pub mod meeting;
pub mod polynomial_arc;
