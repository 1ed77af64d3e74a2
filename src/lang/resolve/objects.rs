//! `ObjectBegin`, `ObjectEnd`, `ObjectInstance`: shapes that are kept once and stand in many places.

use crate::lang::description::{InstanceEntity, ObjectEntity};
use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use bhs_core::diagnostics::{Diagnostic, Span, shorten};
use std::collections::BTreeMap;

impl Resolver<'_> {
    pub(crate) fn object_begin(&mut self, call: Call) {
        if let Some(open) = self.open_object() {
            self.found.push(
                Diagnostic::error("nested-object", "`ObjectBegin` stands within an object")
                    .at(call.keyword, "")
                    .and(open, "the object begins here")
                    .help("end that object with `ObjectEnd` first; objects cannot hold objects"),
            );
            return;
        }
        let index = self.scene.objects.len();
        let is_second = self.objects.contains_key(&call.name.value);
        if let Some(first) = self.objects.get(&call.name.value) {
            let first = self.scene.objects[*first].name.span;
            self.found.push(
                Diagnostic::error("duplicate-object", format!("object `{}` is defined twice", shorten(&call.name.value)))
                    .at(call.name.span, "defined again here")
                    .and(first, "first defined here")
                    .help("give one of the two another name"),
            );
        }
        // Even a second one of the same name, lest its shapes and its end be taken for something else.
        self.objects.entry(call.name.value.clone()).or_insert(index);
        self.object = Some((index, call.keyword, self.stack.len()));
        self.stack.push((self.state.clone(), call.keyword));
        self.scene.objects.push(ObjectEntity { name: call.name, used: is_second });
    }

    pub(crate) fn object_end(&mut self, call: Call) {
        let Some((_, _, depth)) = self.object else {
            return self.error("stray", "this `ObjectEnd` ends nothing", call.keyword, "", "remove it, or write `ObjectBegin`");
        };
        // What has begun within ends with it.
        for (_, begin) in self.stack.drain(depth + 1..).collect::<Vec<_>>() {
            self.found.push(
                Diagnostic::error("unclosed-attribute", "this `AttributeBegin` is not ended within its object")
                    .at(begin, "")
                    .and(call.keyword, "the object ends here")
                    .help("add `AttributeEnd`"),
            );
        }
        if let Some((state, _)) = self.stack.pop() {
            self.state = state;
        }
        self.object = None;
    }

    pub(crate) fn object_instance(&mut self, call: Call) {
        if let Some(open) = self.open_object() {
            self.found.push(
                Diagnostic::error("nested-object", "`ObjectInstance` stands within an object")
                    .at(call.keyword, "")
                    .and(open, "the object begins here")
                    .help("end that object with `ObjectEnd` first; objects cannot hold objects"),
            );
            return;
        }
        self.scene.instances.push(InstanceEntity {
            object: None,
            name: call.name,
            world_from_object: *self.state.ctm,
            side: self.state.side,
        });
    }

    /// Where the object begins that is being defined.
    pub(in crate::lang) fn open_object(&self) -> Option<Span> {
        self.object.map(|(_, begin, _)| begin)
    }

    /// Says that a directive in an object has its effect outside of it.
    pub(super) fn not_of_the_object(&mut self, keyword: Span, what: &str) {
        if let Some(open) = self.open_object() {
            self.found.push(
                Diagnostic::warning("not-of-object", format!("{what} within an object is no part of it"))
                    .at(keyword, "it is there once, and not once an instance")
                    .and(open, "the object begins here")
                    .help("move it out of the object"),
            );
        }
    }

    /// Objects by name: they may be defined after their instances.
    pub(super) fn finish_objects(&mut self) {
        let mut unknown = BTreeMap::new();
        for instance in &mut self.scene.instances {
            instance.object = self.objects.get(&instance.name.value).copied();
            match instance.object {
                Some(object) => self.scene.objects[object].used = true,
                None => {
                    unknown.entry(instance.name.value.clone()).or_insert(instance.name.span);
                }
            }
        }
        if self.scene.incomplete {
            return;
        }
        for (name, span) in unknown {
            let help = match self.suggestions.near(&name, self.objects.keys().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("define it: ObjectBegin \"{}\" ... ObjectEnd", shorten(&name)),
            };
            self.error("unknown-object", format!("unknown object `{}`", shorten(&name)), span, "", help);
        }
        for object in self.scene.objects.iter().filter(|o| !o.used) {
            let message = format!("object `{}` is never used", shorten(&object.name.value));
            self.found.push(Diagnostic::warning("unused-object", message).at(object.name.span, "no `ObjectInstance` has it"));
        }
    }
}
