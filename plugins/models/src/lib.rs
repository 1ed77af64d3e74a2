//! Files of models that other programs write, as plain data: glTF 2.0 and its binary form GLB.
//!
//! `Model` is a file; `mesh` takes the triangles out of it, `picture` its pictures, `material` what surfaces are, `nodes` where everything stands.
//! The JSON is read and checked by the crate `gltf`; what it describes of the buffers is read here, within bounds: that crate panics where a
//! file lies about them. Nothing here knows scenes or plugins, and no memory is taken that the file's length does not justify.

mod accessor;
pub mod material;
pub mod mesh;
mod model;
pub mod nodes;
pub mod picture;
pub mod tangents;

pub use gltf;
pub use model::{Model, ReadFile, beside};
