//! How rays meet surfaces, whatever bends them: knows curves, and no spacetime.
//!
//! `arc` is all that is seen of a curve, `polynomial_arc` one kind of it. `driver` follows rays from piece to piece, one or eight side by side;
//! `packet` puts chords of their pieces to the surfaces, `leaps` passes over free space, `packet/hits` resolves what most chords meet and `resolve`
//! the rest, `meeting` finds where a curve itself meets what a chord of it meets, `departure` has rays that begin exactly on a surface, `shadow` asks
//! what stands between two points, `extent` says how precisely all that is done. `places` and `surfaces` are what these speak of.

pub mod arc;
mod departure;
pub mod driver;
pub mod extent;
mod leaps;
pub mod meeting;
mod packet;
pub mod parts;
pub mod places;
pub mod polynomial_arc;
mod resolve;
pub mod shadow;
pub mod surfaces;
