//! `objmesh`: triangles from a Wavefront OBJ file.
//!
//! The file's own materials (`mtllib`, `usemtl`) count where they stand, in place of the scene's: the program reads them before this plugin is
//! made, which then gets `group`, one for each material. Without them all faces of the file make one mesh. Polygons may have any number of
//! corners and need not be convex. A corner without a shading normal (`vn`), or with one that is no number, takes that of its
//! face; texture coordinates (`vt`) are used if every corner has them. The outer side is as with `trianglemesh`. pbrt has no such shape.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | the OBJ file, relative to the scene's folder |
//! | `materials` | bool | true | | whether the file's own materials count; without them all of it has the material of the scene |
//! | `group` | string | none | | only the faces with the material of this name (`usemtl`), which then is that of the scene |
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

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "objmesh", summary: "triangles from a Wavefront OBJ file", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let name = p.require::<String>("filename", "", "the OBJ file, relative to the scene's folder");
    p.get("materials", true, "", "whether the file's own materials count; without them all of it has the material of the scene");
    let about = "only the faces with the material of this name (`usemtl`), which then is that of the scene";
    let group = p.optional::<String>("group", "", about);
    let name = name?;
    let span = p.span_of("filename");
    let read = p.context().share(&name, span, obj::parse).and_then(|file| file.mesh(group.as_deref()));
    let read = match read {
        Ok(read) => read,
        Err(fault) => {
            p.report(Diagnostic::error("bad-file", format!("cannot read `{name}`: {fault}")).at(span, ""));
            return None;
        }
    };
    for what in read.partial {
        let message = format!("the {what} of `{name}` are left out: some corners of faces have none");
        p.report(Diagnostic::warning("partial-attribute", message).at(span, ""));
    }
    warn_of_crossing(p, &name, read.crossing_faces);
    Some(Box::new(to_world(p, read.mesh)?))
}
