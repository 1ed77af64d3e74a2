//! `plymesh`: triangles from a PLY file.
//!
//! Text and binary files of both byte orders, each also compressed with gzip, whatever they are called. Vertices have `x y z`
//! and, if the file has them, shading normals `nx ny nz` and texture coordinates (`u v`, `s t`, `texture_u texture_v` or
//! `texture_s texture_t`); faces have the list `vertex_indices` or `vertex_index`. Polygons may have any number of corners and
//! need not be convex; they become triangles (quadrilaterals too: pbrt-v4 makes bilinear patches of them). A normal that is no
//! number is that of the faces around its vertex; a vertex that no face uses may be anything. Everything else in the file is
//! stepped over. The outer side is as with `trianglemesh`.
//!
//! | parameter | type | default | meaning |
//! |---|---|---|---|
//! | `filename` | string | required | the PLY file, relative to the scene's folder |
//!
//! ```bhs
//! WorldBegin
//! Scale 10 10 10
//! Shape "plymesh" "string filename" "dragon_vrip.ply.gz"
//! ```

use crate::mesh::{can_be_numbered, to_world, warn_of_crossing};
use crate::ply;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Shape;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use std::sync::Arc;

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "plymesh", summary: "triangles from a PLY file", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let name = p.require::<String>("filename", "", "the PLY file, relative to the scene's folder")?;
    let span = p.span_of("filename");
    let read = p.context().decode(&name, span, ply::read).and_then(|ply| match ply.mesh.triangles.len() {
        0 => Err("it holds no triangle".into()),
        n => can_be_numbered(n as u64, "triangles").map(|()| ply),
    });
    let ply = match read {
        Ok(ply) => Arc::unwrap_or_clone(ply),
        Err(fault) => {
            p.report(Diagnostic::error("bad-file", format!("cannot read `{name}`: {fault}")).at(span, ""));
            return None;
        }
    };
    if ply.dropped_faces > 0 {
        let message = format!("faces of fewer than 3 corners are left out of `{name}`: {}", ply.dropped_faces);
        p.report(Diagnostic::warning("dropped-faces", message).at(span, ""));
    }
    warn_of_crossing(p, &name, ply.crossing_faces);
    for what in &ply.unread {
        p.report(Diagnostic::warning("unread-element", format!("the {what} of `{name}` are not read")).at(span, ""));
    }
    if ply.goes_on {
        let message = format!("`{name}` goes on after the last element that its header announces");
        p.report(Diagnostic::warning("file-goes-on", message).at(span, "").help("check the counts in its header"));
    }
    Some(Box::new(to_world(p, ply.mesh)?))
}
