//! How rays meet surfaces, whatever bends them: knows curves, and no spacetime.

pub mod arc;
pub mod polynomial_arc;
