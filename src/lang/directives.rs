//! The directives of the language: one row each, with what it takes, where it may stand, and the function that runs it.

use crate::lang::attributes::Target;
use crate::lang::description::{AreaLightEntity, Entity, MaterialEntity, ShapeEntity, TextureEntity};
use crate::lang::parse::shorten;
use crate::lang::resolve::{Call, CurrentMaterial, MAX_ATTRIBUTE_DEPTH, Resolver};
use crate::lang::transform::{self, NotAffine};
use bhs_core::diagnostics::{Diagnostic, did_you_mean};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3};

/// Where a directive may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// Before `WorldBegin`.
    Options,
    /// After `WorldBegin`.
    World,
    /// Anywhere.
    Both,
}

/// What follows a directive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Takes {
    /// Nothing.
    Nothing,
    /// So many numbers.
    Numbers(usize),
    /// A text.
    Name,
    /// A text, then parameters.
    NameAndParams,
    /// Three texts (a name, a type, the name of a plugin), then parameters.
    TextureAndParams,
    /// Parameters.
    Params,
}

/// One directive.
pub(crate) struct Row {
    pub keyword: &'static str,
    pub section: Section,
    pub takes: Takes,
    pub run: fn(&mut Resolver, Call),
}

const fn row(keyword: &'static str, section: Section, takes: Takes, run: fn(&mut Resolver, Call)) -> Row {
    Row { keyword, section, takes, run }
}

/// All directives, by name.
pub(crate) const DIRECTIVES: &[Row] = &[
    row("AreaLightSource", Section::World, Takes::NameAndParams, |r, c| r.area_light_source(c)),
    row("Attribute", Section::Both, Takes::NameAndParams, |r, c| r.attribute(c)),
    row("AttributeBegin", Section::World, Takes::Nothing, |r, c| r.attribute_begin(c)),
    row("AttributeEnd", Section::World, Takes::Nothing, |r, c| r.attribute_end(c)),
    row("BlackHole", Section::World, Takes::NameAndParams, |r, c| r.black_hole(c)),
    row("Camera", Section::Options, Takes::NameAndParams, |r, c| r.camera(c)),
    row("ColorSpace", Section::Both, Takes::Name, |r, c| r.color_space(c)),
    row("ConcatTransform", Section::Both, Takes::Numbers(16), |r, c| r.concat_transform(c)),
    row("CoordSysTransform", Section::Both, Takes::Name, |r, c| r.coord_sys_transform(c)),
    row("CoordinateSystem", Section::Both, Takes::Name, |r, c| r.coordinate_system(c)),
    row("Film", Section::Options, Takes::NameAndParams, |r, c| r.film(c)),
    row("Identity", Section::Both, Takes::Nothing, |r, c| r.identity(c)),
    row("Include", Section::Both, Takes::Name, |r, c| r.include(c)),
    row("Integrator", Section::Options, Takes::NameAndParams, |r, c| r.integrator(c)),
    row("LightSource", Section::World, Takes::NameAndParams, |r, c| r.light_source(c)),
    row("LightTransport", Section::Options, Takes::NameAndParams, |r, c| r.light_transport(c)),
    row("LookAt", Section::Both, Takes::Numbers(9), |r, c| r.look_at(c)),
    row("MakeNamedMaterial", Section::World, Takes::NameAndParams, |r, c| r.make_named_material(c)),
    row("Material", Section::World, Takes::NameAndParams, |r, c| r.material(c)),
    row("NamedMaterial", Section::World, Takes::Name, |r, c| r.named_material(c)),
    row("ObjectBegin", Section::World, Takes::Name, |r, c| r.object_begin(c)),
    row("ObjectEnd", Section::World, Takes::Nothing, |r, c| r.object_end(c)),
    row("ObjectInstance", Section::World, Takes::Name, |r, c| r.object_instance(c)),
    row("Option", Section::Options, Takes::Params, |r, c| r.option(c)),
    row("PixelFilter", Section::Options, Takes::NameAndParams, |r, c| r.pixel_filter(c)),
    row("ReverseOrientation", Section::World, Takes::Nothing, |r, c| r.reverse_orientation(c)),
    row("Rotate", Section::Both, Takes::Numbers(4), |r, c| r.rotate(c)),
    row("Sampler", Section::Options, Takes::NameAndParams, |r, c| r.sampler(c)),
    row("Scale", Section::Both, Takes::Numbers(3), |r, c| r.scale(c)),
    row("Shape", Section::World, Takes::NameAndParams, |r, c| r.shape(c)),
    row("Texture", Section::World, Takes::TextureAndParams, |r, c| r.texture(c)),
    row("Transform", Section::Both, Takes::Numbers(16), |r, c| r.transform(c)),
    row("Translate", Section::Both, Takes::Numbers(3), |r, c| r.translate(c)),
    row("WorldBegin", Section::Both, Takes::Nothing, |r, c| r.world_begin(c)),
];

/// Directives of pbrt that are not there, and what to do instead.
const ABSENT: &[(&str, &str)] = &[
    ("Accelerator", "remove it; Option \"string intersector\" chooses what finds surfaces"),
    ("ActiveTransform", "remove it; nothing moves during the exposure"),
    ("Import", "write `Include`"),
    ("MakeNamedMedium", "remove it; there are no media"),
    ("MediumInterface", "remove it; there are no media"),
    ("TransformBegin", "write `AttributeBegin`"),
    ("TransformEnd", "write `AttributeEnd`"),
    ("TransformTimes", "remove it; nothing moves during the exposure"),
    ("WorldEnd", "remove it; the world ends with the file"),
];

/// The directive that `keyword` names.
pub(crate) fn find(keyword: &str) -> Option<&'static Row> {
    DIRECTIVES.binary_search_by_key(&keyword, |row| row.keyword).ok().map(|i| &DIRECTIVES[i])
}

/// What to do in place of a directive of pbrt that is not there.
pub(crate) fn absent(keyword: &str) -> Option<&'static str> {
    ABSENT.iter().find(|(name, _)| *name == keyword).map(|(_, advice)| *advice)
}

/// A name that may follow a directive.
pub(crate) fn example_name(keyword: &str) -> &'static str {
    match keyword {
        "AreaLightSource" | "Material" => "diffuse",
        "Attribute" => "shape",
        "BlackHole" => "schwarzschild",
        "Camera" => "perspective",
        "ColorSpace" => "srgb",
        "Film" => "rgb",
        "Include" => "file.bhs",
        "Integrator" => "straight",
        "LightSource" => "infinite",
        "LightTransport" => "path",
        "PixelFilter" => "box",
        "Sampler" => "sobol",
        "Shape" => "sphere",
        "Texture" => "name\" \"spectrum\" \"imagemap",
        _ => "name",
    }
}

/// The words of all directives.
pub(crate) fn keywords() -> impl Iterator<Item = &'static str> {
    DIRECTIVES.iter().map(|row| row.keyword)
}

/// What each directive does.
impl Resolver<'_> {
    pub(crate) fn include(&mut self, call: Call) {
        match self.sources.include(&call.name.value, call.name.span) {
            Ok(file) => self.file(file),
            Err(fault) => {
                self.found.push(*fault);
                self.scene.incomplete = true;
            }
        }
    }

    pub(crate) fn world_begin(&mut self, call: Call) {
        if let Some(first) = self.world {
            self.found.push(
                Diagnostic::error("duplicate-directive", "the world begins twice")
                    .at(call.keyword, "second `WorldBegin`")
                    .and(first, "first `WorldBegin`"),
            );
            return;
        }
        self.world = Some(call.keyword);
        self.state.ctm = DAffine3::IDENTITY;
        self.systems.insert("world".into(), DAffine3::IDENTITY);
    }

    pub(crate) fn option(&mut self, call: Call) {
        if call.params.is_empty() && !call.faulty {
            self.error("missing-parameter", "`Option` needs a parameter", call.keyword, "", "such as \"integer seed\" 1");
        }
        self.scene.options.extend(call.params);
    }

    pub(crate) fn color_space(&mut self, call: Call) {
        let name = call.name.value.as_str();
        if name == "srgb" {
            return;
        }
        let help = "convert the colours to linear sRGB, which is what `rgb` means without `ColorSpace`";
        let message = match name {
            "aces2065-1" | "dci-p3" | "rec2020" => format!("the colour space `{name}` is not supported"),
            _ => format!("unknown colour space `{}`", shorten(name)),
        };
        self.error("unsupported", message, call.name.span, "there is srgb alone", help);
    }

    pub(crate) fn film(&mut self, call: Call) {
        self.set_once(|s| &mut s.film, "a film", call.entity(DAffine3::IDENTITY));
    }

    pub(crate) fn sampler(&mut self, call: Call) {
        self.set_once(|s| &mut s.sampler, "a sampler", call.entity(DAffine3::IDENTITY));
    }

    pub(crate) fn pixel_filter(&mut self, call: Call) {
        self.set_once(|s| &mut s.filter, "a pixel filter", call.entity(DAffine3::IDENTITY));
    }

    pub(crate) fn integrator(&mut self, call: Call) {
        self.set_once(|s| &mut s.integrator, "an integrator", call.entity(DAffine3::IDENTITY));
    }

    pub(crate) fn light_transport(&mut self, call: Call) {
        self.set_once(|s| &mut s.transport, "a light transport", call.entity(DAffine3::IDENTITY));
    }

    pub(crate) fn identity(&mut self, _: Call) {
        self.state.ctm = DAffine3::IDENTITY;
    }

    pub(crate) fn translate(&mut self, call: Call) {
        self.apply(DAffine3::from_translation(call.point(0)), call.numbers_span);
    }

    pub(crate) fn scale(&mut self, call: Call) {
        let factors = call.point(0);
        if factors.cmpeq(DVec3::ZERO).any() {
            return self.error(
                "bad-transform",
                "a scale of 0 flattens what follows",
                call.numbers_span,
                "",
                "use 1 to keep a size",
            );
        }
        self.apply(DAffine3::from_scale(factors), call.numbers_span);
    }

    pub(crate) fn rotate(&mut self, call: Call) {
        let (degrees, axis) = (call.numbers[0], DVec3::new(call.numbers[1], call.numbers[2], call.numbers[3]));
        match transform::rotate(degrees, axis) {
            Some(t) => self.apply(t, call.numbers_span),
            None => {
                let help = "write Rotate degrees x y z";
                self.error("bad-transform", "the axis of `Rotate` has no direction", call.numbers_span, "", help);
            }
        }
    }

    pub(crate) fn look_at(&mut self, call: Call) {
        match transform::look_at(call.point(0), call.point(1), call.point(2)) {
            Some(t) => self.apply(t, call.numbers_span),
            None => {
                let message = "`LookAt` gives no view: eye and target coincide, or up points along the view";
                let help = "write LookAt with the eye, the target, and a direction that is up in the picture";
                self.error("bad-transform", message, call.numbers_span, "", help);
            }
        }
    }

    pub(crate) fn transform(&mut self, call: Call) {
        if let Some(t) = self.matrix(&call) {
            self.state.ctm = t;
        }
    }

    pub(crate) fn concat_transform(&mut self, call: Call) {
        if let Some(t) = self.matrix(&call) {
            self.apply(t, call.numbers_span);
        }
    }

    fn matrix(&mut self, call: &Call) -> Option<DAffine3> {
        let numbers: &[f64; 16] = call.numbers.as_slice().try_into().ok()?;
        let (message, help) = match transform::matrix(numbers) {
            Ok(t) => return Some(t),
            Err(NotAffine::Projective) => (
                "this matrix is projective, not a transform of space",
                "matrices are written column by column, as in pbrt: numbers 4, 8 and 12 are 0, and the translation is in 13, 14, 15",
            ),
            Err(NotAffine::Singular) => ("this matrix flattens space", "its three axes must span space"),
        };
        self.error("bad-transform", message, call.numbers_span, "", help);
        None
    }

    pub(crate) fn coordinate_system(&mut self, call: Call) {
        self.systems.insert(call.name.value, self.state.ctm);
    }

    pub(crate) fn coord_sys_transform(&mut self, call: Call) {
        if let Some(t) = self.systems.get(&call.name.value) {
            self.state.ctm = *t;
        } else if !self.scene.incomplete {
            let near = did_you_mean(&call.name.value, self.systems.keys().map(String::as_str));
            let help = near.map_or_else(|| "name one with `CoordinateSystem`".to_owned(), |n| format!("did you mean `{n}`?"));
            let message = format!("unknown coordinate system `{}`", shorten(&call.name.value));
            self.error("unknown-coordinate-system", message, call.name.span, "", help);
        }
    }

    pub(crate) fn attribute_begin(&mut self, call: Call) {
        if self.stack.len() < MAX_ATTRIBUTE_DEPTH {
            return self.stack.push((self.state.clone(), call.keyword));
        }
        if self.too_deep == 0 {
            let message = format!("`AttributeBegin` is nested more than {MAX_ATTRIBUTE_DEPTH} deep");
            self.error("attribute-depth", message, call.keyword, "", "end the ones before it with `AttributeEnd`");
        }
        self.too_deep += 1;
    }

    pub(crate) fn attribute_end(&mut self, call: Call) {
        if self.too_deep > 0 {
            self.too_deep -= 1;
            return;
        }
        if let Some((_, begin, _)) = self.object.filter(|(_, _, depth)| depth + 1 == self.stack.len()) {
            self.found.push(
                Diagnostic::error("stray", "this `AttributeEnd` ends nothing within its object")
                    .at(call.keyword, "")
                    .and(begin, "the object begins here")
                    .help("remove it, or end the object with `ObjectEnd` before it"),
            );
            return;
        }
        match self.stack.pop() {
            Some((state, _)) => self.state = state,
            None => self.error("stray", "this `AttributeEnd` ends nothing", call.keyword, "", "remove it"),
        }
    }

    pub(crate) fn reverse_orientation(&mut self, _: Call) {
        self.state.reverse_orientation = !self.state.reverse_orientation;
    }

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
        if let Some(first) = self.scene.textures.iter().find(|t| t.name.value == name.value && t.is_float == is_float) {
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
        Entity { defaults: self.state.attributes.of(target), ..call.entity(self.state.ctm) }
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

    pub(crate) fn black_hole(&mut self, call: Call) {
        self.not_of_the_object(call.keyword, "a black hole");
        let entity = call.entity(self.state.ctm);
        self.set_once(|s| &mut s.black_hole, "a black hole", entity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_nothing_is_both_there_and_absent() {
        assert!(DIRECTIVES.is_sorted_by_key(|row| row.keyword));
        assert!(ABSENT.is_sorted());
        assert!(ABSENT.iter().all(|(name, _)| find(name).is_none()));
    }
}
