//! A picture as it is written: what has been rendered, denoised if that is asked for.

use crate::denoise::{COLORS, Denoiser, Fault, NOISY, STARS};
use crate::develop::Content;
use crate::develop::channels::{self, Found, Known};
use crate::header::{self, Facts};
use crate::image::{Attribute, Picture};
use crate::lang::BuiltScene;
use crate::layers::LayerPicture;
use crate::not_finite;
use crate::render::{Ended, Rendered};
use crate::stats::{Phases, counters_to_json, missed_connections, peak_memory, points_to_json};
use anyhow::Result;
use serde_json::json;
use std::borrow::Cow;

/// What has been rendered, as it is written.
pub struct Finished {
    /// Where it comes from.
    pub rendered: Rendered,
    /// The channels of the film.
    pub picture: Picture,
    /// Its layers as files have them.
    pub layers: Vec<LayerPicture>,
    /// What has denoised it, and all channels that it then has.
    denoised: Option<(String, Picture)>,
}

impl Finished {
    /// As it was rendered.
    pub fn of(rendered: &Rendered) -> Self {
        let layers = rendered.frame.layers().into_iter().map(LayerPicture::as_in_files).collect();
        Self { rendered: rendered.clone(), picture: rendered.frame.picture(), layers, denoised: None }
    }

    /// The same without its noise.
    ///
    /// # Errors
    /// Why it cannot be denoised; it is as it was then.
    pub fn denoise(&mut self, denoiser: &Denoiser) -> Result<(), Fault> {
        let all = denoiser.denoise(&self.with_stars(self.all_channels().into_owned()))?;
        let channels = self.picture.channels.len();
        for (own, pixel) in self.picture.data.chunks_exact_mut(channels).zip(all.pixels()) {
            own.copy_from_slice(&pixel[..channels]);
        }
        self.denoised = Some((denoiser.name(), all));
        Ok(())
    }

    /// `picture` with what stars add to its colours as channels of their own, if it shows any.
    fn with_stars(&self, picture: Picture) -> Picture {
        let Some(points) = self.rendered.frame.points() else { return picture };
        let ([left, top], [width, _]) = (picture.frame.offset, picture.size);
        let mut pixels = (0..).map(|i| [(left + i % width) as u32, (top + i / width) as u32]);
        picture.with_channels(&STARS, |_, into| {
            let light = pixels.next().and_then(|pixel| points.pixel(pixel)).unwrap_or(&[0.0; 3]);
            into.extend(light[..3].iter().map(|v| *v as f32));
        })
    }

    /// All that the EXR file holds.
    pub fn all_channels(&self) -> Cow<'_, Picture> {
        match &self.denoised {
            Some((_, all)) => Cow::Borrowed(all),
            None if self.layers.is_empty() => Cow::Borrowed(&self.picture),
            None => Cow::Owned(self.picture.clone().with_layers(&self.layers)),
        }
    }

    /// What the PNG shows: the picture; or a layer, which is found among its channels as `bhs develop` finds it in the file.
    ///
    /// # Errors
    /// If there is no such layer.
    pub fn content(&self, layer: Option<&str>, false_color: bool) -> Result<Content<'_>> {
        let Some(name) = layer else { return Ok(Content::Colours(Cow::Borrowed(&self.picture))) };
        let all = self.channels_in_the_end();
        let known: Vec<Known> = self.layers.iter().map(|layer| (layer.name, layer.format)).collect();
        let names: Vec<&str> = all.channels.iter().map(String::as_str).collect();
        let found = channels::find(&names, name, &known).map_err(anyhow::Error::msg)?;
        Ok(Content::of(&all, &found, None, false_color).0)
    }

    /// All channels that it has once it is denoised, as if it was: before that its colours are the noisy ones.
    fn channels_in_the_end(&self) -> Cow<'_, Picture> {
        if self.denoised.is_some() {
            return self.all_channels();
        }
        let all = self.with_stars(self.all_channels().into_owned());
        let Some(colors) = all.find(COLORS) else { return Cow::Owned(all) };
        Cow::Owned(all.with_channels(&NOISY, |pixel, into| into.extend(colors.map(|c| pixel[c]))))
    }

    /// What its header says.
    pub fn attributes(&self, built: &BuiltScene) -> Vec<(String, Attribute)> {
        let denoised = self.denoised.iter().map(|(name, _)| (header::DENOISED.to_owned(), Attribute::Text(name.clone())));
        header::attributes(&Facts::of(built), &self.rendered).into_iter().chain(denoised).collect()
    }
}

/// The channels of the layer `name` that a picture of a scene is going to have, as [`Finished::content`] finds it.
///
/// # Errors
/// What there is instead.
pub fn find_layer(built: &BuiltScene, is_denoised: bool, name: &str) -> Result<Found, String> {
    let known: Vec<Known> = built.layers.iter().map(|layer| (layer.name, layer.format)).collect();
    let film = built.film.channels();
    let mut names: Vec<&str> = film.iter().map(String::as_str).collect();
    names.extend(known.iter().flat_map(|(_, format)| format.channels));
    if is_denoised {
        names.extend(NOISY);
        let draws_stars = built.scene.draws_points && built.transport.shows_light();
        names.extend(STARS.iter().filter(|_| draws_stars));
    }
    channels::find(&names, name, &known)
}

/// What a render took, as JSON.
pub fn stats_json(built: &BuiltScene, rendered: &Rendered, phases: &Phases) -> serde_json::Value {
    let mut all = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": built.hash,
        "seed": built.seed,
        "integrator": built.integrator_name,
        "transport": built.transport_name,
        "camera": built.camera_name,
        "variables": serde_json::Map::from_iter(built.variables.iter().map(|(name, value)| (name.clone(), json!(value)))),
        "samples_per_pixel": rendered.samples,
        "most_samples_per_pixel": rendered.most_samples,
        "mean_samples_per_pixel": rendered.mean_samples(),
        "noise": rendered.noise.map(|found| json!({ "rms": found.rms, "pixels_above": found.above })),
        "interrupted": matches!(rendered.ended, Ended::Stopped(_)),
        "stopped": rendered.ended.name(),
        "seconds": phases.to_json(),
        "processor_seconds": phases.processor_to_json(),
        "peak_memory_bytes": peak_memory(),
        "instances": built.load.instances,
        "triangles": built.load.triangles,
        "zero_area_triangles_dropped": built.load.zero_area_triangles,
        "counts": counters_to_json(&rendered.counters),
        "not_finite": not_finite::to_json(rendered.counters.not_finite, &rendered.not_finite, &rendered.frame),
    });
    if let Some(points) = rendered.frame.points() {
        all["stars"] = points_to_json(&points.counters);
    }
    all
}

/// Share of rays to light samples from which on it is told that they were not found: the picture has more noise then. `--stats` has any.
const TOLD: f64 = 0.25;

/// What is said of a render that has ended: notes and warnings.
pub fn notes(rendered: &Rendered) -> Vec<String> {
    let c = &rendered.counters;
    let mut notes = Vec::new();
    let missed = missed_connections(c);
    if missed.iter().any(|share| *share >= TOLD) {
        let shares: Vec<String> = missed.iter().map(|share| format!("{:.1} %", 100.0 * share)).collect();
        let sought = c.connections_sought;
        notes.push(format!(
            "note: of {sought} light samples the rays were not found, image by image, for {}; their light is left to BSDF sampling, with more noise",
            shares.join(", ")
        ));
    }
    if c.out_of_steps > 0 {
        notes.push(format!(
            "warning: {} rays ran out of steps and count as black; raise the integrator's `maxsteps`",
            c.out_of_steps
        ));
    }
    notes
}
