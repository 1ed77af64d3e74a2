//! What the header of an EXR file says about its picture: attributes that OpenEXR itself names, and those of bhs, which begin with `bhs:`.
//!
//! `chromaticities`, `worldToCamera`, `worldToNDC`, `capDate`, `utcOffset` and `comments` are those of OpenEXR's "Standard Optional
//! Attributes" (ImfStandardAttributes.h).

use crate::image::Attribute;
use crate::lang::BuiltScene;
use crate::look::Look;
use crate::render::Rendered;
use bhs_core::camera::CameraMatrices;
use exr::meta::attribute::{Chromaticities, Matrix4x4};
use exr::prelude as exrs;
use glam::{DAffine3, DMat4};
use serde_json::{Value, json};

/// The primaries and the white point of sRGB (IEC 61966-2-1; ITU-R BT.709).
const SRGB: Chromaticities = Chromaticities {
    red: exrs::Vec2(0.64, 0.33),
    green: exrs::Vec2(0.30, 0.60),
    blue: exrs::Vec2(0.15, 0.06),
    white: exrs::Vec2(0.3127, 0.3290),
};

/// What the header says of a picture that does not depend on how far it has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// The hash of the scene.
    pub scene: String,
    /// The integrator's name.
    pub integrator: String,
    /// The light transport's name.
    pub transport: String,
    /// The camera's name, if it has one.
    pub camera: Option<String>,
    /// The scene's variables that come from outside, in words.
    pub variables: String,
    /// The seed.
    pub seed: u64,
    /// How it is shown.
    pub look: Look,
    world_to_camera: Option<Matrix4x4>,
    world_to_ndc: Option<Matrix4x4>,
}

impl Facts {
    /// Those of the current picture of a scene.
    pub fn of(built: &BuiltScene) -> Self {
        let variables: Vec<String> = built.variables.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let matrices = built.camera.matrices().map(|CameraMatrices { camera_from_render, screen_from_camera }| {
            let camera_from_world = camera_from_render * DAffine3::from_translation(-built.scene.world.origin);
            let camera_from_world = DMat4::from(camera_from_world);
            let screen_from_world = screen_from_camera.map(|screen_from_camera| screen_from_camera * camera_from_world);
            (for_row_vectors(camera_from_world), screen_from_world.map(for_row_vectors))
        });
        Self {
            scene: built.hash.clone(),
            integrator: built.integrator_name.clone(),
            transport: built.transport_name.clone(),
            camera: built.camera_name.clone(),
            variables: variables.join(" "),
            seed: built.seed,
            look: built.look,
            world_to_camera: matrices.map(|m| m.0),
            world_to_ndc: matrices.and_then(|m| m.1),
        }
    }

    /// As JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "scene": self.scene,
            "integrator": self.integrator,
            "transport": self.transport,
            "camera": self.camera,
            "variables": self.variables,
            "seed": self.seed,
            "look": self.look.words(),
            "world_to_camera": self.world_to_camera.map(|m| m.map(f64::from)),
            "world_to_ndc": self.world_to_ndc.map(|m| m.map(f64::from)),
        })
    }

    /// From JSON; `None` if it is none.
    pub fn from_json(value: &Value) -> Option<Self> {
        let text = |name: &str| value[name].as_str().map(str::to_owned);
        let matrix = |name: &str| -> Option<Option<Matrix4x4>> {
            if value[name].is_null() {
                return Some(None);
            }
            let numbers = value[name].as_array()?.iter().map(|n| n.as_f64().map(|n| n as f32));
            Some(Some(numbers.collect::<Option<Vec<f32>>>()?.try_into().ok()?))
        };
        Some(Self {
            scene: text("scene")?,
            integrator: text("integrator")?,
            transport: text("transport")?,
            camera: text("camera"),
            variables: text("variables")?,
            seed: value["seed"].as_u64()?,
            look: Look::of_words(|name| value["look"][name].as_str().map(str::to_owned)),
            world_to_camera: matrix("world_to_camera")?,
            world_to_ndc: matrix("world_to_ndc")?,
        })
    }
}

/// What the header says of a picture that has been rendered.
pub fn attributes(facts: &Facts, rendered: &Rendered) -> Vec<(String, Attribute)> {
    let mut all = Attributes(Vec::new());
    all.standard(facts, rendered);
    let c = &rendered.counters;
    all.text("bhs:version", env!("CARGO_PKG_VERSION"));
    all.text("bhs:scene", &facts.scene);
    all.text("bhs:integrator", &facts.integrator);
    all.text("bhs:transport", &facts.transport);
    if let Some(name) = &facts.camera {
        all.text("bhs:camera", name);
    }
    if !facts.variables.is_empty() {
        all.text("bhs:variables", &facts.variables);
    }
    all.number("bhs:seed", facts.seed as f64);
    if u128::from(facts.seed) != facts.seed as f64 as u128 {
        // Double precision, the widest number that OpenEXR has, holds all whole numbers up to 2^53.
        all.text("bhs:seedDigits", &facts.seed.to_string());
    }
    // As it was asked for: who develops the file has the picture from which `auto` follows.
    let look = &facts.look;
    look.words().iter().for_each(|(name, word)| all.text(&format!("bhs:{name}"), word));
    all.number("bhs:spp", f64::from(rendered.samples));
    if let Some(noise) = rendered.noise {
        all.number("bhs:meanSpp", rendered.mean_samples());
        all.number("bhs:noise", noise.rms);
    }
    all.number("bhs:firstSample", 0.0);
    all.number("bhs:lastSample", f64::from(rendered.most_samples.saturating_sub(1)));
    all.text("bhs:stopped", rendered.ended.name());
    all.number("bhs:seconds", rendered.seconds);
    all.number("bhs:queriesPerGeodesic", c.queries as f64 / c.geodesics.max(1) as f64);
    all.number("bhs:samplesNotFinite", c.not_finite as f64);
    let beyond = rendered.frame.beyond_single_precision();
    all.number("bhs:valuesTooLarge", beyond.iter().map(|b| b.pixels as f64).sum());
    all.0
}

/// The attribute that says what has denoised a picture.
pub const DENOISED: &str = "bhs:denoised";

/// Why the render of a picture ended, as the header of its file says; `None` if it does not, or is not that of a picture.
pub fn stopped(path: &std::path::Path) -> Option<String> {
    text(path, "bhs:stopped")
}

/// Whether the header of a file says that its picture has been denoised.
pub fn is_denoised(path: &std::path::Path) -> bool {
    text(path, DENOISED).is_some()
}

/// The text of an attribute.
fn text(path: &std::path::Path, name: &str) -> Option<String> {
    let meta = exr::meta::MetaData::read_from_file(path, false).ok()?;
    let all = meta.headers.first()?;
    match all.own_attributes.other.get(&exr::meta::attribute::Text::from(name))? {
        exr::meta::attribute::AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

/// Attributes under way.
struct Attributes(Vec<(String, Attribute)>);

impl Attributes {
    fn put(&mut self, name: &str, value: Attribute) {
        self.0.push((name.to_owned(), value));
    }

    fn text(&mut self, name: &str, text: &str) {
        self.put(name, Attribute::Text(text.to_owned()));
    }

    fn number(&mut self, name: &str, number: f64) {
        self.put(name, Attribute::Number(number));
    }

    /// Those that OpenEXR names.
    fn standard(&mut self, facts: &Facts, rendered: &Rendered) {
        self.put("chromaticities", Attribute::Chromaticities(SRGB));
        for (name, matrix) in [("worldToCamera", facts.world_to_camera), ("worldToNDC", facts.world_to_ndc)] {
            if let Some(matrix) = matrix {
                self.put(name, Attribute::Matrix(matrix));
            }
        }
        let now = chrono::Local::now();
        self.text("capDate", &now.format("%Y:%m:%d %H:%M:%S").to_string());
        self.put("utcOffset", Attribute::Single(-now.offset().local_minus_utc() as f32));
        let comments = format!(
            "bhs {}: {} samples a pixel by `{}` along `{}` in {:.1} s",
            env!("CARGO_PKG_VERSION"),
            rendered.spp(),
            facts.transport,
            facts.integrator,
            rendered.seconds,
        );
        self.text("comments", &comments);
    }
}

/// The numbers of a matrix for column vectors as OpenEXR keeps them: row by row of the one for row vectors, which is its transpose. That
/// is the order of its columns.
fn for_row_vectors(matrix: DMat4) -> Matrix4x4 {
    matrix.to_cols_array().map(|x| x as f32)
}
