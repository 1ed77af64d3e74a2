//! Rays of a refractive index: `x'' = grad(n^2)/2` with `|x'| = n`, of one ray and of eight with one code.
//!
//! `nystroem` has the steps, `dense` makes curves of them, `path` chooses their lengths and passes throats, `escape` says where rays go that
//! leave, `bundle` how they spread, `medium` is what they have to be told of the index. These know no
//! surfaces. `course` is a ray among surfaces, `shadow` follows shadow rays. `connect` finds the rays between two points.

pub mod bundle;
pub mod connect;
pub mod course;
pub mod dense;
mod escape;
pub mod medium;
pub mod nystroem;
pub mod path;
pub mod shadow;
