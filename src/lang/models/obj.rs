//! OBJ files with the materials that they name.

use super::mtl::MtlTranslator;
use super::{ModelFile, few};
use crate::lang::params::{boolean_of, string_of};
use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::params::share;
use bhs_core::value::{Param, ParamType, Values};
use bhs_shapes::mtl::{self, Mtl};
use bhs_shapes::obj;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

impl Resolver<'_> {
    /// `Shape "objmesh"`: one shape for each material of the file, unless the scene says otherwise.
    pub(in crate::lang) fn obj_file(&mut self, call: Call) {
        let is_one = call.params.iter().any(|p| p.name.value == "group") || boolean_of(&call.params, "materials") == Some(false);
        let Some(filename) = string_of(&call.params, "filename").filter(|_| !is_one).cloned() else {
            return self.one_shape(call);
        };
        // What is wrong with it is told by the shape.
        let Ok(read) = share(&*self.sources, &filename.value, filename.span, obj::parse) else { return self.one_shape(call) };
        let groups = read.groups();
        if groups.iter().all(|name| name.is_empty()) {
            return self.one_shape(call);
        }
        let number = self.model_number();
        let file = ModelFile { path: &filename.value, at: filename.span, prefix: format!("{} {number}", filename.value) };
        let libraries = self.libraries(&file, &read.libraries);
        let known: HashMap<&str, &mtl::Material> =
            libraries.iter().flat_map(|l| &l.materials).map(|m| (m.name.as_str(), m)).rev().collect();
        let unknown: Vec<&str> = groups.iter().copied().filter(|name| !name.is_empty() && !known.contains_key(name)).collect();
        if !unknown.is_empty() && (!libraries.is_empty() || read.libraries.is_empty()) {
            let message = match read.libraries.is_empty() {
                true => {
                    format!("`{}` names materials and no file of them (`mtllib`): {}", file.path, few(unknown.iter().copied()))
                }
                false => format!("materials of `{}` are in no file that it names: {}", file.path, few(unknown.iter().copied())),
            };
            self.found.push(file.warning("lost-materials", message, "what has them has the current material"));
        }
        let mut translator =
            MtlTranslator { file: &file, sources: &*self.sources, lost: BTreeSet::new(), unread: BTreeSet::new() };
        let made: Vec<_> =
            groups.iter().map(|name| known.get(name).map(|m| translator.material(m)).unwrap_or_default()).collect();
        let MtlTranslator { lost, unread, .. } = translator;
        if !lost.is_empty() {
            let message = format!("pictures of `{}` are not there: {}", file.path, few(lost.iter().map(String::as_str)));
            self.found.push(file.warning("lost-pictures", message, "its materials do without them"));
        }
        if !unread.is_empty() {
            let message = format!(
                "statements of the materials of `{}` are not read: {}",
                file.path,
                few(unread.iter().map(String::as_str))
            );
            self.found.push(file.warning("unread-statements", message, "the picture lacks what they add"));
        }
        let (before, state) = (self.state.clone(), self.state_of_model());
        for (name, directives) in groups.into_iter().zip(made) {
            self.state = state.clone();
            directives.into_iter().for_each(|d| self.directive(d));
            self.one_shape(call.with_params(with_group(&call.params, name, file.at)));
        }
        self.state = before;
    }

    /// The files of materials that are there; a warning names those that are not.
    fn libraries(&mut self, file: &ModelFile, lines: &[String]) -> Vec<Arc<Mtl>> {
        let mut names: Vec<String> = Vec::new();
        let mut lost: Vec<String> = Vec::new();
        for line in lines {
            // The name of one file, spaces and all, or those of several.
            let whole = file.find(line, self.sources);
            let words = line.split_whitespace().filter(|_| whole.is_none());
            let found: Vec<(&str, Option<String>)> = words.map(|word| (word, file.find(word, self.sources))).collect();
            if whole.is_none() && found.iter().all(|(_, path)| path.is_none()) {
                lost.push(line.clone());
                continue;
            }
            lost.extend(found.iter().filter(|(_, path)| path.is_none()).map(|(word, _)| (*word).to_owned()));
            names.extend(whole.into_iter().chain(found.into_iter().filter_map(|(_, path)| path)));
        }
        let mut read = Vec::new();
        for name in names {
            match share(&*self.sources, &name, file.at, mtl::parse) {
                Ok(library) => {
                    for note in &library.notes {
                        self.found.push(file.warning("material-note", format!("`{name}`: {note}"), ""));
                    }
                    read.push(library);
                }
                Err(why) => {
                    let message = format!("cannot read `{name}`, which has materials of `{}`: {why}", file.path);
                    self.found.push(file.warning("lost-materials", message, "what has them has the current material"));
                }
            }
        }
        if !lost.is_empty() {
            let message = format!("the materials of `{}` are not there: {}", file.path, few(lost.iter().map(String::as_str)));
            self.found.push(file.warning("lost-materials", message, "what has them has the current material"));
        }
        read
    }
}

/// The parameters of a shape, and the one material that it is made of.
fn with_group(params: &[Param], group: &str, span: Span) -> Vec<Param> {
    let text = |text: &str| Spanned::new(text.to_owned(), span);
    let values = Values::Strings(vec![text(group)]);
    let group = Param { ty: Spanned::new(ParamType::String, span), name: text("group"), values, span };
    params.iter().cloned().chain([group]).collect()
}
