//! What went wrong, between the threads that do the work and the Python that asked for it.

use bhs::lang::SourceMap;
use bhs::report;
use bhs_core::diagnostics::Diagnostic;
use pyo3::prelude::*;

/// What becomes a `bhs.Error`.
#[derive(Debug)]
pub struct Fault {
    /// As it is drawn for people.
    text: String,
    /// The findings of a scene, as JSON objects.
    diagnostics: Vec<String>,
}

/// Findings as JSON objects.
pub fn to_json(found: &[Diagnostic], sources: &SourceMap) -> Vec<String> {
    found.iter().map(|diagnostic| report::to_json(diagnostic, sources).to_string()).collect()
}

impl Fault {
    /// A fault in one sentence.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), diagnostics: Vec::new() }
    }

    /// What was found wrong with a scene.
    pub fn of_scene(found: &[Diagnostic], sources: &SourceMap) -> Self {
        Self { text: report::render(found, sources, false).trim_end().to_owned(), diagnostics: to_json(found, sources) }
    }
}

impl From<anyhow::Error> for Fault {
    fn from(error: anyhow::Error) -> Self {
        Self::new(format!("{error:#}"))
    }
}

impl From<Fault> for PyErr {
    fn from(Fault { text, diagnostics }: Fault) -> Self {
        let made = Python::attach(|py| {
            py.import("bhs._errors")?.getattr("Error")?.call_method1("_of", (text, diagnostics)).map(Bound::unbind)
        });
        match made {
            Ok(error) => Python::attach(|py| PyErr::from_value(error.into_bound(py))),
            Err(error) => error,
        }
    }
}
