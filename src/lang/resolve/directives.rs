//! The directives of the language: one row each, with what it takes, where it may stand, and the function that runs it.
//!
//! Those of the options and of the structure of a scene do their work here; `transforms` and `entities` have the others, but for those
//! that have files of their own beside this one (`attributes`, `objects`, `views`).

use crate::lang::resolve::call::Call;
use crate::lang::resolve::{MAX_ATTRIBUTE_DEPTH, Resolver};
use bhs_core::diagnostics::{Diagnostic, shorten};
use bhs_core::spacetime::Side;
use glam::DAffine3;
use std::sync::Arc;

mod entities;
mod transforms;

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
    /// A text and a number.
    NameAndNumber,
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
    row("BlackHole", Section::World, Takes::NameAndParams, |r, c| r.spacetime(c)),
    row("Camera", Section::Options, Takes::NameAndParams, |r, c| r.camera(c)),
    row("ColorSpace", Section::Both, Takes::Name, |r, c| r.color_space(c)),
    row("ConcatTransform", Section::Both, Takes::Numbers(16), |r, c| r.concat_transform(c)),
    row("CoordSysTransform", Section::Both, Takes::Name, |r, c| r.coord_sys_transform(c)),
    row("CoordinateSystem", Section::Both, Takes::Name, |r, c| r.coordinate_system(c)),
    row("Define", Section::Options, Takes::NameAndNumber, |r, c| r.define(c)),
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
    row("Side", Section::World, Takes::Name, |r, c| r.side(c)),
    row("Spacetime", Section::World, Takes::NameAndParams, |r, c| r.spacetime(c)),
    row("Texture", Section::World, Takes::TextureAndParams, |r, c| r.texture(c)),
    row("Transform", Section::Both, Takes::Numbers(16), |r, c| r.transform(c)),
    row("Translate", Section::Both, Takes::Numbers(3), |r, c| r.translate(c)),
    row("WorldBegin", Section::Both, Takes::Nothing, |r, c| r.world_begin(c)),
    row("Wormhole", Section::World, Takes::NameAndParams, |r, c| r.spacetime(c)),
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
        "BlackHole" | "Spacetime" => "schwarzschild",
        "Camera" => "perspective",
        "ColorSpace" => "srgb",
        "Define" => "radius",
        "Film" => "rgb",
        "Include" => "file.bhs",
        "Integrator" => "straight",
        "LightSource" => "infinite",
        "LightTransport" => "path",
        "PixelFilter" => "box",
        "Sampler" => "sobol",
        "Shape" => "sphere",
        "Side" => "far",
        "Wormhole" => "ellis",
        "Texture" => "name\" \"spectrum\" \"imagemap",
        _ => "name",
    }
}

/// The words of all directives.
pub(crate) const KEYWORDS: &[&str] = &{
    let mut words = [""; DIRECTIVES.len()];
    let mut i = 0;
    while i < DIRECTIVES.len() {
        words[i] = DIRECTIVES[i].keyword;
        i += 1;
    }
    words
};

/// What the directives of the options and of structure do.
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
        self.state.ctm = Arc::default();
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
        self.set_once(|s| &mut s.film, "a film", call.entity(Arc::default()));
    }

    pub(crate) fn sampler(&mut self, call: Call) {
        self.set_once(|s| &mut s.sampler, "a sampler", call.entity(Arc::default()));
    }

    pub(crate) fn pixel_filter(&mut self, call: Call) {
        self.set_once(|s| &mut s.filter, "a pixel filter", call.entity(Arc::default()));
    }

    pub(crate) fn integrator(&mut self, call: Call) {
        self.set_once(|s| &mut s.integrator, "an integrator", call.entity(Arc::default()));
    }

    pub(crate) fn light_transport(&mut self, call: Call) {
        self.set_once(|s| &mut s.transport, "a light transport", call.entity(Arc::default()));
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

    /// The side of a wormhole on which what follows is.
    pub(crate) fn side(&mut self, call: Call) {
        match call.name.value.as_str() {
            "near" => self.state.side = Side::Near,
            "far" => self.state.side = Side::Far,
            other => {
                let message = format!("unknown side `{}`", shorten(other));
                self.error("unknown-side", message, call.name.span, "", "expected \"near\" or \"far\"");
            }
        }
    }

    pub(crate) fn reverse_orientation(&mut self, _: Call) {
        self.state.reverse_orientation = !self.state.reverse_orientation;
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
