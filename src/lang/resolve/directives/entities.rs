//! Directives that make something of the world: textures, materials, lights, shapes, the hole.

use crate::lang::defaults::Target;
use crate::lang::description::{AreaLightEntity, Entity, MaterialEntity, ShapeEntity, TextureEntity};
use crate::lang::resolve::call::Call;
use crate::lang::resolve::{CurrentMaterial, Resolver};
use bhs_core::diagnostics::{Diagnostic, did_you_mean, shorten};
use bhs_core::value::{Param, ParamType, Values};
use std::sync::Arc;

impl Resolver<'_> {
    pub(crate) fn texture(&mut self, call: Call) {
        let Some([kind, plugin]) = call.more.clone() else { return };
        let is_float = match kind.value.as_str() {
            "float" => true,
            "spectrum" => false,
            word => {
                let help = did_you_mean(word, ["float", "spectrum"]).map_or_else(
                    || "a texture is one of \"spectrum\" or \"float\"".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                );
                let message = format!("unknown type of a texture `{}`", shorten(word));
                return self.error("unknown-type", message, kind.span, "", help);
            }
        };
        let name = call.name.clone();
        let known = &mut self.textures[usize::from(is_float)];
        let index = *known.entry(name.value.clone()).or_insert(self.scene.textures.len());
        if let Some(first) = self.scene.textures.get(index) {
            let first = first.name.span;
            self.found.push(
                Diagnostic::error("duplicate-texture", format!("texture `{}` is defined twice", shorten(&name.value)))
                    .at(name.span, "defined again here")
                    .and(first, "first defined here")
                    .help("give one of the two another name"),
            );
            return;
        }
        let entity = Entity { name: plugin, ..self.entity_with_defaults(call, Target::Texture) };
        self.scene.textures.push(TextureEntity { entity, name, is_float });
    }

    /// The plugin that `call` describes, under the current transform, with the defaults that `Attribute` has stated.
    fn entity_with_defaults(&self, call: Call, target: Target) -> Entity {
        Entity { defaults: self.state.attributes.of(target), side: self.state.side, ..call.entity(Arc::clone(&self.state.ctm)) }
    }

    pub(crate) fn material(&mut self, call: Call) {
        let entity = self.entity_with_defaults(call, Target::Material);
        self.state.material = CurrentMaterial::Index(self.scene.materials.len());
        self.scene.materials.push(MaterialEntity { entity, name: None, used: false });
    }

    pub(crate) fn make_named_material(&mut self, mut call: Call) {
        let name = call.name.clone();
        // The plugin's name is the parameter "string type".
        let at = call.params.iter().position(|p| p.name.value == "type");
        call.name = match at.map(|i| call.params.remove(i)) {
            Some(Param { ty, values: Values::Strings(mut s), .. }) if ty.value == ParamType::String && s.len() == 1 => {
                s.remove(0)
            }
            Some(other) => {
                let span = other.ty.span.to(other.span);
                return self.error("wrong-type", "`type` is a string", span, "", "such as \"string type\" \"diffuse\"");
            }
            None if call.faulty => return,
            None => {
                let message = format!("material `{}` has no type", shorten(&name.value));
                let help = "add \"string type\" and the name of a material, such as \"diffuse\"";
                return self.error("missing-parameter", message, name.span, "", help);
            }
        };
        if let Some(first) = self.named.get(&name.value) {
            let first = self.scene.materials[*first].name.as_ref().map_or(name.span, |n| n.span);
            self.found.push(
                Diagnostic::error("duplicate-material", format!("material `{}` is defined twice", shorten(&name.value)))
                    .at(name.span, "defined again here")
                    .and(first, "first defined here")
                    .help("give one of the two another name"),
            );
            return;
        }
        self.named.insert(name.value.clone(), self.scene.materials.len());
        let entity = self.entity_with_defaults(call, Target::Material);
        self.scene.materials.push(MaterialEntity { entity, name: Some(name), used: false });
    }

    pub(crate) fn named_material(&mut self, call: Call) {
        self.state.material = CurrentMaterial::Named(call.name);
    }

    pub(crate) fn area_light_source(&mut self, call: Call) {
        let entity = self.entity_with_defaults(call, Target::Light);
        self.state.area_light = Some(self.scene.area_lights.len());
        self.scene.area_lights.push(AreaLightEntity { entity, used: false });
    }

    pub(crate) fn light_source(&mut self, call: Call) {
        self.not_of_the_object(call.keyword, "a light");
        let entity = self.entity_with_defaults(call, Target::Light);
        self.scene.lights.push(entity);
    }

    pub(crate) fn shape(&mut self, call: Call) {
        match call.name.value.as_str() {
            "gltf" => self.gltf_file(call),
            "objmesh" => self.obj_file(call),
            _ => self.one_shape(call),
        }
    }

    /// A shape that is no file with materials of its own, or one part of such a file.
    pub(in crate::lang) fn one_shape(&mut self, call: Call) {
        let material = match &self.state.material {
            CurrentMaterial::Default => None,
            CurrentMaterial::Index(index) => Some(*index),
            CurrentMaterial::Named(name) => {
                self.pending.push((self.scene.shapes.len(), name.clone()));
                None
            }
        };
        let mut area_light = self.state.area_light;
        if let (Some(light), Some(object)) = (area_light, self.open_object()) {
            // As pbrt-v4.
            self.scene.area_lights[light].used = true;
            area_light = None;
            self.found.push(
                Diagnostic::warning("light-in-object", "area lights do not shine in objects")
                    .at(call.keyword, "this shape is made without light")
                    .and(object, "the object begins here")
                    .help("write the shape out where it stands"),
            );
        }
        self.scene.shapes.push(ShapeEntity {
            entity: self.entity_with_defaults(call, Target::Shape),
            reverse_orientation: self.state.reverse_orientation,
            material,
            area_light,
            object: self.object.map(|(object, ..)| object),
        });
    }

    /// `Spacetime`, and `BlackHole` and `Wormhole`, which mean the same.
    pub(crate) fn spacetime(&mut self, call: Call) {
        self.not_of_the_object(call.keyword, "a spacetime");
        let entity = call.entity(Arc::clone(&self.state.ctm));
        let Some(first) = &self.scene.spacetime else {
            self.scene.spacetime = Some(entity);
            return;
        };
        self.found.push(
            Diagnostic::error("duplicate-directive", "the scene has a spacetime already")
                .at(entity.keyword, "second one")
                .and(first.keyword, "first one")
                .help("remove one of the two; several holes are one spacetime: `majumdar-papapetrou`"),
        );
    }
}
