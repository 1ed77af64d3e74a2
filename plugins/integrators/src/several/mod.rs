//! Rays from point to point among several extremal holes.
//!
//! `masses` follows rays with their neighbours, `newton` makes them end where they are to end, `images` says which of them are looked for.

pub mod images;
pub mod masses;
pub mod newton;
