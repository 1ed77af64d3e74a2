//! What Python functions are given, as the library takes it.

use crate::fault::Fault;
use bhs::lang::variables::parse_definition;
use bhs::lang::{LARGEST_SEED, Overrides, Variables};
use bhs::look::{LookChanges, bloom, tone_curve};
use bhs::memory::picture::TooLarge;
use bhs_core::sampling::{NoiseOver, NoiseTarget};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::time::Duration;

/// Numbers for the variables of a scene, as `-D` takes them.
pub fn variables(given: &BTreeMap<String, f64>) -> Result<Variables, Fault> {
    let read = |(name, value): (&String, &f64)| {
        parse_definition(&format!("{name}={value:?}")).map_err(|why| Fault::new(format!("variable `{name}`: {why}")))
    };
    Ok(Variables::defined(&given.iter().map(read).collect::<Result<Vec<_>, _>>()?))
}

/// What `Scene.render` is told, by the names of its parameters.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct RenderOptions {
    spp: Option<u32>,
    noise: Option<f64>,
    noise_over: Option<String>,
    /// Samples a pixel at least, with `noise` or `time`.
    pub min_spp: Option<u32>,
    seed: Option<u64>,
    resolution: Option<[u32; 2]>,
    crop: Option<[f64; 4]>,
    camera: Option<String>,
    layers: Vec<String>,
    integrator: Option<String>,
    transport: Option<String>,
    quick: bool,
    look: LookWords,
    /// Seconds.
    pub time: Option<f64>,
    /// How many threads.
    pub threads: Option<u32>,
    /// Whether noise is taken out.
    pub denoise: bool,
}

impl RenderOptions {
    /// What is changed of the scene.
    pub fn overrides(&self) -> Result<Overrides, Fault> {
        if self.seed.is_some_and(|seed| seed > LARGEST_SEED) {
            return Err(Fault::new(format!("seed: expected a whole number up to {LARGEST_SEED}")));
        }
        if self.resolution.is_some_and(|size| size.iter().any(|side| !(1..=65_536).contains(side))) {
            return Err(Fault::new("resolution: expected width and height in pixels, from 1 to 65536 each"));
        }
        if self.noise.is_some_and(|noise| !NoiseTarget::takes(noise)) {
            return Err(Fault::new(format!("noise: {}", NoiseTarget::EXPECTED)));
        }
        let noise_over = self.noise_over.as_deref().map(|name| NoiseOver::find(name).ok_or(NoiseOver::EXPECTED)).transpose();
        let noise_over = noise_over.map_err(|expected| Fault::new(format!("noise_over: {expected}")))?;
        if self.min_spp == Some(0) {
            return Err(Fault::new("min_spp: expected at least 1"));
        }
        let guides = bhs::denoise::LAYERS.iter().filter(|_| self.denoise).map(|name| (*name).to_owned());
        Ok(Overrides {
            spp: self.spp,
            noise: self.noise,
            noise_over,
            seed: self.seed,
            resolution: self.resolution,
            crop: self.crop,
            camera: self.camera.clone(),
            layers: self.layers.iter().cloned().chain(guides).collect(),
            integrator: self.integrator.clone(),
            transport: self.transport.clone(),
            quick: self.quick,
            look: self.look.changes()?,
            too_large: TooLarge::Refuse,
            ..Overrides::default()
        })
    }

    /// What the picture may take.
    pub fn limit(&self) -> Result<Option<Duration>, Fault> {
        let read = |seconds| {
            Duration::try_from_secs_f64(seconds).map_err(|_| Fault::new("time: expected a number of seconds, such as 300 or 0.5"))
        };
        self.time.map(read).transpose()
    }
}

/// How a picture is shown, by the names that the command line has for it, in words.
#[derive(FromPyObject)]
#[pyo3(transparent)]
pub struct LookWords(BTreeMap<String, String>);

impl LookWords {
    /// What is changed.
    pub fn changes(&self) -> Result<LookChanges, Fault> {
        let mut changes = LookChanges::default();
        for (name, word) in &self.0 {
            let read = match name.as_str() {
                "exposure" => word.parse().map(|exposure| changes.exposure = Some(exposure)),
                "tonecurve" => tone_curve(word).map(|curve| changes.curve = Some(curve)),
                "white" => word.parse().map(|white| changes.white = Some(white)),
                "bloom" => bloom(word).map(|radius| changes.bloom = Some(radius)),
                "bits" => word.parse().map(|bits| changes.bits = Some(bits)),
                _ => Err("expected exposure, tonecurve, white, bloom or bits".to_owned()),
            };
            read.map_err(|why| Fault::new(format!("{name}={word}: {why}")))?;
        }
        Ok(changes)
    }
}
