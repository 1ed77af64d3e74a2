//! glTF files: nodes to shapes and instances, materials and lights as directives.

use super::{ModelFile, few};
use crate::lang::ast::Directive;
use crate::lang::params::{boolean_of, directive, named, string_of};
use crate::lang::resolve::call::Call;
use crate::lang::resolve::{Resolver, State};
use crate::lang::transform::is_invertible;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::params::share;
use bhs_core::value::{Param, ParamType, Values};
use bhs_models::gltf::Document;
use bhs_models::mesh::readable;
use bhs_models::nodes::{Nodes, nodes};
use bhs_models::{Model, gltf as document};
use glam::{DAffine3, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use surfaces::{Made, Surfaces};

mod lights;
mod surfaces;

/// Takes the right-handed coordinates of glTF files to those of scenes.
pub(super) fn turned() -> DAffine3 {
    DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0))
}

/// A part of a mesh that is shown: its number, what it is made of, and the set of texture coordinates.
struct Part {
    primitive: usize,
    made: Made,
}

impl Resolver<'_> {
    /// `Shape "gltf"`: all that a file has, unless the scene names a mesh of it.
    pub(in crate::lang) fn gltf_file(&mut self, call: Call) {
        let is_one = call.params.iter().any(|p| p.name.value == "mesh");
        let Some(filename) = string_of(&call.params, "filename").filter(|_| !is_one).cloned() else {
            return self.one_shape(call);
        };
        // What is wrong with it is told by the shape.
        let Ok(model) = share(&*self.sources, &filename.value, filename.span, Model::parse) else { return self.one_shape(call) };
        let number = self.model_number();
        let file = ModelFile { path: &filename.value, at: filename.span, prefix: format!("{} {number}", filename.value) };
        let nodes = nodes(&model);
        self.tell_left_out(&file, &model, &nodes);

        let with_materials = boolean_of(&call.params, "materials") != Some(false);
        let mut surfaces = Surfaces::new(&file, &model, &*self.sources, with_materials);
        let mut unread: BTreeMap<&str, usize> = BTreeMap::new();
        let shown: BTreeSet<usize> = nodes.placed.iter().filter_map(|p| Some(p.node.mesh()?.index())).collect();
        let mut parts: BTreeMap<usize, Vec<Part>> = BTreeMap::new();
        for mesh in model.document.meshes().filter(|mesh| shown.contains(&mesh.index())) {
            for primitive in mesh.primitives() {
                match readable(&primitive) {
                    Ok(()) => {
                        let part = Part { primitive: primitive.index(), made: surfaces.of(&primitive) };
                        parts.entry(mesh.index()).or_default().push(part);
                    }
                    Err(what) => *unread.entry(what).or_default() += 1,
                }
            }
        }
        let (directives, said) = surfaces.finish();
        self.found.extend(said);
        for (what, count) in &unread {
            let parts = if *count == 1 { "part" } else { "parts" };
            let message = format!("{count} {parts} of `{}` cannot be read: {what}", file.path);
            self.found.push(file.warning("left-out", message, "the picture lacks them"));
        }
        let has_lights = boolean_of(&call.params, "lights") != Some(false);
        if parts.is_empty() && !(has_lights && nodes.placed.iter().any(|p| p.node.light().is_some())) {
            let why = unread.keys().next().map_or("it has no mesh in its scene", |_| "none of its meshes can be read");
            let message = format!("nothing of `{}` can be shown: {why}", file.path);
            let help = "export it without compression, with meshes of triangles";
            return self.found.push(Diagnostic::error("bad-file", message).at(file.at, "").help(help));
        }

        let before = self.state.clone();
        let state = self.state_of_model();
        self.state = state.clone();
        directives.into_iter().for_each(|d| self.directive(d));
        self.place(&file, &call, &nodes, (&parts, has_lights), &state);
        self.state = before;
    }

    /// Puts everything where it stands.
    fn place(
        &mut self,
        file: &ModelFile,
        call: &Call,
        nodes: &Nodes,
        (parts, has_lights): (&BTreeMap<usize, Vec<Part>>, bool),
        state: &State,
    ) {
        let base = *state.ctm * turned();
        // What moves, shines or stands in an object itself is written out.
        let moves = call.params.iter().any(|p| p.name.value == "motion");
        let may_share = !moves && state.area_light.is_none() && self.open_object().is_none();
        let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
        nodes.placed.iter().filter_map(|p| p.node.mesh()).for_each(|mesh| *uses.entry(mesh.index()).or_default() += 1);
        let object_name = |mesh: usize| format!("{}: mesh {mesh}", file.prefix);
        let is_shared = |mesh: usize| may_share && uses.get(&mesh).is_some_and(|n| *n > 1) && parts.contains_key(&mesh);
        for (mesh, parts) in parts.iter().filter(|(mesh, _)| is_shared(**mesh)) {
            let own = || parts.iter().filter(|part| part.made.light.is_empty());
            if own().next().is_none() {
                continue;
            }
            self.state = state.at(DAffine3::IDENTITY);
            self.directive(named("ObjectBegin", &object_name(*mesh), file.at));
            own().for_each(|part| self.part(call, (*mesh, part), file.at));
            self.directive(directive("ObjectEnd", file.at));
        }
        let mut flat = 0;
        for placed in &nodes.placed {
            let here = state.at(base * placed.world_from_node);
            let is_seen =
                placed.node.mesh().is_some_and(|mesh| parts.contains_key(&mesh.index())) || placed.node.light().is_some();
            if is_seen && !is_invertible(&here.ctm) {
                flat += 1;
                continue;
            }
            if let Some(mesh) = placed.node.mesh().map(|mesh| mesh.index())
                && let Some(parts) = parts.get(&mesh)
            {
                let shared = is_shared(mesh);
                if shared && parts.iter().any(|part| part.made.light.is_empty()) {
                    self.state = here.clone();
                    self.directive(named("ObjectInstance", &object_name(mesh), file.at));
                }
                for part in parts.iter().filter(|part| !shared || !part.made.light.is_empty()) {
                    self.state = here.clone();
                    self.part(call, (mesh, part), file.at);
                }
            }
            if let Some(light) = placed.node.light().filter(|_| has_lights) {
                self.state = here;
                self.directive(lights::directive(&light, file.at));
            }
        }
        if flat > 0 {
            let message = format!("{flat} nodes of `{}` have no size, and are not there", file.path);
            self.found.push(file.warning("left-out", message, "their transforms flatten space"));
        }
    }

    /// A part of a mesh, in the current state.
    fn part(&mut self, call: &Call, (mesh, part): (usize, &Part), at: Span) {
        part.made.light.iter().cloned().for_each(|d: Directive| self.directive(d));
        if let Some(material) = &part.made.material {
            self.directive(named("NamedMaterial", material, at));
        }
        let number = |name: &str, value: usize| {
            let values = Values::Numbers { values: vec![value as f64], whole: true };
            Param { ty: Spanned::new(ParamType::Integer, at), name: Spanned::new(name.to_owned(), at), values, span: at }
        };
        let [first, second] = part.made.uv_sets;
        let own = [number("mesh", mesh), number("primitive", part.primitive), number("texcoord", first.unwrap_or(0) as usize)];
        let second = second.map(|set| number("texcoord2", set as usize));
        let tangents = part.made.normal_map.map(|set| number("tangents", set));
        let params = call.params.iter().cloned().chain(own).chain(second).chain(tangents).collect();
        self.one_shape(call.with_params(params));
    }

    /// Says what the picture will lack of a file.
    fn tell_left_out(&mut self, file: &ModelFile, model: &Model, nodes: &Nodes) {
        let document = &model.document;
        let mut lacks: Vec<String> = Vec::new();
        if nodes.placed.iter().any(|p| p.node.skin().is_some()) {
            lacks.push("skins: figures stand as they were modelled, not as they are posed".to_owned());
        }
        if has_targets(document) {
            lacks.push("morph targets: meshes have their first shape".to_owned());
        }
        if document.animations().len() > 0 {
            lacks.push("animations: everything stands where it was exported".to_owned());
        }
        if !model.unknown_extensions.is_empty() {
            lacks.push(format!("extensions that it requires: {}", few(model.unknown_extensions.iter().map(String::as_str))));
        }
        if nodes.repeated > 0 {
            lacks.push(format!("{} nodes that have several parents", nodes.repeated));
        }
        if nodes.bent > 0 {
            lacks.push(format!("transforms of {} nodes, which are none of space", nodes.bent));
        }
        for what in lacks {
            self.found.push(file.warning("left-out", format!("`{}`: not read are {what}", file.path), ""));
        }
    }
}

fn has_targets(document: &Document) -> bool {
    let of = |p: document::Primitive| p.morph_targets().next().is_some();
    document.meshes().any(|mesh| mesh.primitives().any(of))
}
