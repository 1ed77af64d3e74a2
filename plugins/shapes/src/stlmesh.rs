//! `stlmesh`: triangles from an STL file, binary or ASCII.
//!
//! Vertices at the same place become one, so that the surface is watertight where the file's triangles touch; there are no shading
//! normals: the triangles stay flat, as the file describes them. The outer side is the one from which corners are seen in
//! counter-clockwise order, as with `trianglemesh`; the normals that the file states are not used. Several solids of one file make one
//! mesh. What unit the numbers have is not in the file (mostly millimetres), nor which way is up (mostly z). pbrt has no such shape.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | the STL file, relative to the scene's folder |
//!
//! ```bhs
//! WorldBegin
//! Rotate -90 1 0 0
//! Shape "stlmesh" "string filename" "grammar/examples/tetrahedron.stl"
//! ```

use crate::mesh::to_world;
use crate::stl;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Shape;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use std::sync::Arc;

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "stlmesh", summary: "triangles from an STL file, binary or ASCII", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let name = p.require::<String>("filename", "", "the STL file, relative to the scene's folder")?;
    let span = p.span_of("filename");
    let read = match p.context().decode(&name, span, stl::read) {
        Ok(read) => Arc::unwrap_or_clone(read),
        Err(fault) => {
            p.report(Diagnostic::error("bad-file", format!("cannot read `{name}`: {fault}")).at(span, ""));
            return None;
        }
    };
    if let Some(note) = read.note {
        p.report(Diagnostic::warning("wrong-count", format!("`{name}`: {note}")).at(span, ""));
    }
    Some(Box::new(to_world(p, read.mesh)?))
}
