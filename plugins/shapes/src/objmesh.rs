//! `objmesh`: triangles from a Wavefront OBJ file.
//!
//! All faces of the file make one mesh, whatever groups and materials they are in: it has the material of the scene. Polygons may have any
//! number of corners and need not be convex. A corner without a shading normal (`vn`), or with one that is no number, takes that of its
//! face; texture coordinates (`vt`) are used if every corner has them. The outer side is as with `trianglemesh`. pbrt has no such shape;
//! its parameters are those of `plymesh`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | the OBJ file, relative to the scene's folder |
//!
//! ```bhs
//! WorldBegin
//! Shape "objmesh" "string filename" "teapot.obj"
//! ```

use crate::mesh::{to_world, warn_of_crossing};
use crate::obj;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Shape;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use std::sync::Arc;

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "objmesh", summary: "triangles from a Wavefront OBJ file", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let name = p.require::<String>("filename", "", "the OBJ file, relative to the scene's folder")?;
    let span = p.span_of("filename");
    let read = match p.context().decode(&name, span, obj::read) {
        Ok(read) => Arc::unwrap_or_clone(read),
        Err(fault) => {
            p.report(Diagnostic::error("bad-file", format!("cannot read `{name}`: {fault}")).at(span, ""));
            return None;
        }
    };
    for what in read.partial {
        let message = format!("the {what} of `{name}` are left out: some corners of faces have none");
        p.report(Diagnostic::warning("partial-attribute", message).at(span, ""));
    }
    if read.materials > 0 {
        let materials = if read.materials == 1 { "material" } else { "materials" };
        let message = format!("`{name}` names {} {materials} (`usemtl`), which are not read", read.materials);
        p.report(Diagnostic::warning("dropped-materials", message).at(span, "all of it has the material of the scene"));
    }
    warn_of_crossing(p, &name, read.crossing_faces);
    Some(Box::new(to_world(p, read.mesh)?))
}
