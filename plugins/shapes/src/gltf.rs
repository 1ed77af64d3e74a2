//! `gltf`: meshes from a glTF 2.0 file, as JSON or binary (GLB).
//!
//! A `Shape "gltf"` of a whole file brings its meshes with their places, materials and lights: the program reads these before this plugin is made, which
//! then gets `mesh` and `primitive`, one for each part. Points (x, y, z) of the file are (x, y, z) under the current transform, to which a whole
//! file adds that z is turned around: glTF is right-handed.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | the glTF file, relative to the scene's folder |
//! | `materials` | bool | true | | whether the file's own materials count; without them all of it has the material of the scene |
//! | `lights` | bool | true | | whether the file's own lights shine |
//! | `mesh` | integer | none | | only this mesh of the file, from 0, in its own coordinates, with the material of the scene |
//! | `primitive` | integer | 0 | | the part of that mesh, from 0 |
//! | `texcoord` | integer | 0 | | the set of texture coordinates that counts for it |
//! | `texcoord2` | integer | none | | the set that its second texture coordinates are (`uvset` 1 of textures) |
//! | `tangents` | integer | none | | for a normal map: tangents are read, or made by the first (0) or second (1) texture coordinates |
//!
//! ```bhs
//! WorldBegin
//! Shape "gltf" "string filename" "grammar/examples/scene.gltf"
//! ```

use crate::mesh::{fill_normals, to_world};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Shape, WorldGeometry};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_models::mesh::{self, Attributes};
use bhs_models::tangents::fill as fill_tangents;
use bhs_models::{Model, beside};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> =
    Plugin { name: "gltf", summary: "models from a glTF 2.0 file, with materials and lights", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let name = p.require::<String>("filename", "", "the glTF file, relative to the scene's folder");
    p.get("materials", true, "", "whether the file's own materials count; without them all of it has the material of the scene");
    p.get("lights", true, "", "whether the file's own lights shine");
    let about = "only this mesh of the file, from 0, in its own coordinates, with the material of the scene";
    let mesh = p.optional::<i64>("mesh", "", about);
    let part = p.get_in("primitive", 0, 0..=i64::from(u32::MAX), "", "the part of that mesh, from 0");
    let set = p.get_in("texcoord", 0, 0..=i64::from(u32::MAX), "", "the set of texture coordinates that counts for it");
    let about = "the set that its second texture coordinates are (`uvset` 1 of textures)";
    let second = p.optional::<i64>("texcoord2", "", about).and_then(|set| match u32::try_from(set) {
        Ok(set) => Some(set),
        Err(_) => {
            p.reject("texcoord2", "`texcoord2` is out of range", "sets are counted from 0");
            None
        }
    });
    let about = "for a normal map: tangents are read, or made by the first (0) or second (1) texture coordinates";
    let tangents = p.optional::<i64>("tangents", "", about);
    if tangents.is_some_and(|set| !(0..=1).contains(&set)) {
        p.reject("tangents", "`tangents` is out of range", "there are the first texture coordinates, 0, and the second, 1");
    }
    let with = Attributes { uv_set: set as u32, second_uv_set: second, tangents: tangents.is_some() };
    let name = name?;
    let at = p.span_of("filename");
    let fault = |why: String| p.report(Diagnostic::error("bad-file", format!("cannot read `{name}`: {why}")).at(at, ""));
    let model = p.context().share(&name, at, Model::parse).map_err(fault).ok()?;
    let read = |path: &str| p.context().share(&beside(&name, path), at, |bytes| Ok(bytes.to_vec()));
    let triangles = |mesh: usize, part: usize| mesh::triangles(&model, mesh, part, with, &read).map_err(fault).ok();
    let Some(index) = mesh else {
        // Whoever makes this plugin without the program gets all meshes where they are in the file.
        let parts: Vec<(usize, usize)> =
            model.document.meshes().flat_map(|m| (0..m.primitives().len()).map(move |i| (m.index(), i))).collect();
        let made: Option<Vec<WorldGeometry>> =
            parts.into_iter().map(|(mesh, part)| to_world(p, triangles(mesh, part)?)).collect();
        return Some(Box::new(made.filter(|all| !all.is_empty()).or_else(|| {
            fault("it has no mesh".to_owned());
            None
        })?));
    };
    let Ok(index) = usize::try_from(index) else {
        p.reject("mesh", "`mesh` is out of range", "meshes are counted from 0");
        return None;
    };
    let mut mesh = triangles(index, part as usize)?;
    fill_normals(&mut mesh);
    if let Some(set) = tangents {
        fill_tangents(&mut mesh, set == 1);
    }
    if mesh.triangles.is_empty() {
        // As in a scene without it; the file may have others.
        let message = format!("mesh {index} of `{name}`, primitive {part}, has no triangle");
        p.report(Diagnostic::warning("empty-shape", message).at(at, ""));
    }
    Some(Box::new(to_world(p, mesh)?))
}
