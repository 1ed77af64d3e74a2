//! The module `bhs._bhs`, on which the Python package `bhs` is built: scenes, pictures and rays with plain arguments and arrays. What users see, with
//! its documentation, is written in Python (`python/lib/bhs`).
//!
//! All work is done by threads that do not hold the interpreter ([`watched`]); the library `bhs` does it.

mod arguments;
mod fault;
mod picture;
mod rays;
mod render;
mod scene;
mod tools;
mod watched;

use pyo3::prelude::*;

/// The module.
#[pymodule(name = "_bhs")]
mod module {
    #[pymodule_export]
    use super::picture::Picture;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::tools::{choose_vectors, compare, develop, run, vectors};

    /// The version of bhs.
    #[pymodule_export]
    #[allow(non_upper_case_globals)] // as Python writes it
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
