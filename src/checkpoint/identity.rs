//! What a checkpoint belongs to: whatever decides which number every sample adds.

use crate::lang::BuiltScene;
use serde_json::{Value, json};

/// What a render is of. Two renders with the same identity add the same samples to the same pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity(Value);

/// Whatever has to be the same, in the order in which it is compared: its name in the file, and what a person calls it.
const PARTS: &[(&str, &str)] = &[
    ("version", "version of bhs"),
    ("scene", "scene (its text, or a file that it reads)"),
    ("seed", "seed"),
    ("camera", "camera"),
    ("integrator", "integrator"),
    ("transport", "light transport"),
    ("resolution", "film resolution"),
    ("window", "film crop window"),
    ("channels", "film channels"),
    ("layers", "film layers"),
    ("wavelengths", "film wavelengths"),
    ("first_sample", "first sample"),
    ("kind", "kind of render"),
    ("adaptive", "kind of sampling (`noise`)"),
];

impl Identity {
    /// That of the current camera of a scene.
    pub fn of(built: &BuiltScene) -> Self {
        Self::of_samples(built, "picture", built.film.crop(), 0)
    }

    /// That of a part of it: a window of its film, from a sample on. One that covers all of the picture is a part all the same.
    pub fn of_part(built: &BuiltScene, window: [u32; 4], first_sample: u32) -> Self {
        Self::of_samples(built, "part", window, first_sample)
    }

    fn of_samples(built: &BuiltScene, kind: &str, window: [u32; 4], first_sample: u32) -> Self {
        let film = &*built.film;
        let layers: Vec<&str> = built.layers.iter().map(|layer| layer.name).collect();
        Self(json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": built.hash,
            "seed": built.seed,
            "camera": built.camera_name,
            "integrator": built.integrator_name,
            "transport": built.transport_name,
            "resolution": film.resolution(),
            "window": window,
            "channels": film.channels(),
            "layers": layers,
            "wavelengths": film.lambda_range(),
            "first_sample": first_sample,
            "kind": kind,
            "adaptive": kind == "picture" && built.sampler.noise_target().is_some(),
            "samples": built.sampler.samples_per_pixel(),
        }))
    }

    /// As a value of JSON.
    pub fn value(&self) -> &Value {
        &self.0
    }

    /// What two pictures of the same scene differ in, in words, but for the parts that `ignored` names; `None` if in nothing else.
    pub fn first_difference(&self, other: &Self, ignored: &[&str]) -> Option<String> {
        let parts = PARTS.iter().chain(&[("samples", "number of samples a pixel")]);
        let differing = parts.filter(|(key, _)| !ignored.contains(key)).find(|(key, _)| self.0[*key] != other.0[*key]);
        differing.map(|(key, name)| format!("it is of another {name}: {}, not {}", words(&other.0[*key]), words(&self.0[*key])))
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        self.0.to_string()
    }

    /// From JSON; `None` if it is none.
    pub fn from_json(text: &[u8]) -> Option<Self> {
        serde_json::from_slice(text).ok().filter(Value::is_object).map(Self)
    }

    /// What a render of this identity cannot take over from one of the identity `other`, in words; `None` if it can take over all.
    /// With `fixed_samples` they have to have the same number of samples a pixel too.
    pub fn difference(&self, other: &Self, fixed_samples: bool) -> Option<String> {
        for (key, name) in PARTS {
            let (own, others) = (&self.0[key], &other.0[key]);
            if own != others {
                return Some(format!("it is of another {name}: {}, not {}", words(others), words(own)));
            }
        }
        let (own, others) = (&self.0["samples"], &other.0["samples"]);
        (fixed_samples && own != others).then(|| {
            format!(
                "the sampler of the scene places samples by their number, and cannot go on from {others} to {own} samples a pixel; \
                 `independent` and `sobol` can"
            )
        })
    }
}

/// A value as a person reads it.
fn words(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        // A hash need not be read to its end.
        Value::String(text) if text.len() > 16 => format!("{}...", text.chars().take(12).collect::<String>()),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
