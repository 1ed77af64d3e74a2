//! `Camera`: a scene has one, or several with names.

use crate::lang::description::{CameraEntity, LookAt};
use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use bhs_core::diagnostics::{Diagnostic, Spanned, shorten};
use bhs_core::value::{ParamType, Values};
use std::sync::Arc;

/// The longest name of a camera (bytes): it becomes part of a file's name.
const LONGEST_NAME: usize = 100;

impl Resolver<'_> {
    pub(crate) fn camera(&mut self, mut call: Call) {
        // pbrt: the current transform takes world space to camera space, and "camera" names the way back.
        let world_from_camera = self.state.ctm.inverse();
        self.systems.insert("camera".into(), world_from_camera);
        let Ok(name) = self.camera_name(&mut call) else { return };
        let entity = call.entity(Arc::new(world_from_camera));
        let known = self.cameras.entry(name.as_ref().map(|n| n.value.clone()));
        let index = *known.or_insert(self.scene.cameras.len());
        if let Some(first) = self.scene.cameras.get(index) {
            let (message, second, first) = match (&name, &first.name) {
                (Some(name), Some(old)) => (format!("camera `{}` is defined twice", shorten(&name.value)), name.span, old.span),
                _ => ("the scene has a camera already".to_owned(), entity.keyword, first.entity.keyword),
            };
            self.found.push(
                Diagnostic::error("duplicate-directive", message)
                    .at(second, "second one")
                    .and(first, "first one")
                    .help("remove one of the two, or give them different names, such as \"string name\" \"left\""),
            );
            return;
        }
        let seen = |(span, target)| LookAt { span, target: world_from_camera.transform_point3(target) };
        self.scene.cameras.push(CameraEntity { entity, name, look_at: self.look_at.map(seen) });
    }

    /// Takes the parameter `name` out of `call`, if it is there. An error if it is no name, which is reported.
    fn camera_name(&mut self, call: &mut Call) -> Result<Option<Spanned<String>>, ()> {
        let Some(at) = call.params.iter().position(|p| p.name.value == "name") else { return Ok(None) };
        let param = call.params.remove(at);
        let name = match param.values {
            Values::Strings(mut texts) if param.ty.value == ParamType::String && texts.len() == 1 => texts.remove(0),
            _ => {
                let span = param.ty.span.to(param.span);
                self.error("wrong-type", "`name` is a string", span, "", "such as \"string name\" \"left\"");
                return Err(());
            }
        };
        let forbidden = |c: char| c.is_control() || "/\\:".contains(c);
        if name.value.trim().is_empty() || name.value.len() > LONGEST_NAME || name.value.contains(forbidden) {
            let help = format!("at most {LONGEST_NAME} characters, none of them `/`, `\\` or `:`");
            self.error("bad-value", "a camera's name becomes part of a file's name", name.span, "this cannot be one", help);
            return Err(());
        }
        Ok(Some(name))
    }
}
