//! Parts of pictures, rendered by themselves and joined to the very bytes of the whole.
//!
//! A part is some samples of all pixels of a window ([`Cover`]). That parts add up is due to three things: a sample depends on seed, pixel and
//! number alone; it touches one pixel alone; and sums are exact ([`crate::film::ExactSums`]), so that their order does not matter. Stars,
//! which are in no sum, stand in the parts that have sample 0.

mod choice;
mod cover;
pub mod file;
pub mod join;
pub mod joined;

pub use choice::PartArgs;
pub use cover::{Cover, Windowed};
