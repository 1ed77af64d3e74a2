//! What the fuzz targets do with their input; `tests/corpus.rs` of the root package runs the same code over the kept inputs.

mod targets;

pub use targets::run;
