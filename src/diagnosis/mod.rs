//! Why a picture is black, or as good as: what its counters, its pixels and some rays of its own say, in one sentence with the place in the scene's
//! text and what to try.
//!
//! Nothing here changes a scene or a picture. [`before`] finds what can be known without rendering, [`after`] reads a picture: only one that shows
//! nothing, or far too much, costs more than a look at its pixels. Each file has one group of causes.

mod brightness;
mod enclosure;
mod glass;
mod lights;
mod method;
mod probe;
mod shadows;
mod shapes;
mod view;

use crate::lang::BuiltScene;
use crate::render::{Job, Rendered};
use bhs_core::diagnostics::Diagnostic;
use brightness::Brightness;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// How much it matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// It may be what is wanted.
    Note,
    /// The picture shows nothing.
    Warning,
}

/// Code of an exposure that shows nothing: of the PNG of the colours alone.
pub const EXPOSURE: &str = "exposure";

/// What is said of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// How much it matters.
    pub level: Level,
    /// Stable name of the cause.
    pub code: &'static str,
    /// The sentence.
    pub text: String,
}

impl Explanation {
    fn warning(code: &'static str, text: impl Into<String>) -> Self {
        Self { level: Level::Warning, code, text: text.into() }
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let level = match self.level {
            Level::Note => "note",
            Level::Warning => "warning",
        };
        write!(f, "{level}: {}", self.text)
    }
}

/// Whether a finding of [`before`] says that the picture will be black: one picture of several may be so by right.
pub fn is_about_the_picture(found: &Diagnostic) -> bool {
    SAID.contains(&found.code) || found.code == NOT_FOUND
}

/// What has been found of the frames of a film. One frame may be black by right, as where a light is faded in: only the second one of them is told
/// of, and no other.
#[derive(Debug, Default)]
pub struct BlackFrames {
    /// How often each cause was found.
    counts: Mutex<BTreeMap<&'static str, usize>>,
    told_at: usize,
}

impl BlackFrames {
    /// Of a film of so many frames.
    pub fn new(frames: usize) -> Self {
        Self { counts: Mutex::default(), told_at: frames.min(2) }
    }

    /// Counts a frame of which `code` was found; whether that is to be told.
    pub fn tells(&self, code: &'static str) -> bool {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let count = counts.entry(code).or_default();
        *count += 1;
        *count == self.told_at
    }
}

/// Findings that say already why nothing is lit or seen.
const SAID: [&str; 4] = ["no-light", lights::ZERO, lights::WAVELENGTHS, method::MAX_DEPTH];

/// Code of a light that the method does not find; others may be found.
const NOT_FOUND: &str = "light-not-found";

/// What is known of a scene before it is rendered, of its current camera: warnings.
pub fn before(built: &BuiltScene) -> Vec<Diagnostic> {
    if !built.transport.shows_light() {
        return Vec::new();
    }
    let mut found = Vec::new();
    let has_light = !built.warnings.iter().any(|d| d.code == "no-light");
    if has_light {
        // The most basic one: the others are of no account before it is mended.
        found.extend(lights::dark(built).or_else(|| method::no_scattering(built)));
    }
    shapes::within_horizons(built, &mut found);
    glass::inside_out(built, &mut found);
    found
}

/// What is to be said of the picture of the current camera, if anything is. `built.warnings` has what was found [`before`].
pub fn after(built: &BuiltScene, rendered: &Rendered) -> Option<Explanation> {
    let c = &rendered.counters;
    let is_read = rendered.samples > 0 && c.not_finite == 0 && 2 * c.camera_out_of_steps < c.paths;
    if !is_read || !built.transport.shows_light() || built.warnings.iter().any(|d| SAID.contains(&d.code)) {
        return None;
    }
    let brightness = Brightness::of(&rendered.frame);
    let job = Job::of(built);
    if !brightness.is_black(built.look.exposure) {
        return view::nothing_met(built, &job, c, Level::Note).or_else(|| brightness.explain(built, c));
    }
    // Where light changes its wavelength, what is seen comes before what shines.
    let shifts = lights::may_shift(built);
    let wavelengths = |asked: bool| asked.then(|| lights::dark_everywhere(built)).flatten();
    let found = wavelengths(!shifts)
        .or_else(|| view::only_the_hole(built, &job, c))
        .or_else(|| view::nothing_met(built, &job, c, Level::Warning))
        .or_else(|| wavelengths(shifts));
    if found.is_some() || no_light_is_found(built) {
        return found;
    }
    let survey = shadows::Survey::of(built, &job);
    let cause = survey.and_then(|survey| {
        let specular = survey.specular_only(built);
        specular.or_else(|| enclosure::around_the_camera(built, &survey)).or_else(|| survey.explain(built))
    });
    cause.or_else(|| brightness.explain(built, c))
}

/// Whether it has been said of all lights that the method does not find them.
fn no_light_is_found(built: &BuiltScene) -> bool {
    let sampler = &built.scene.light_sampler;
    let missed = built.warnings.iter().filter(|d| d.code == NOT_FOUND).count();
    missed > 0 && sampler.emitters.is_empty() && missed >= sampler.lights.len()
}

/// A shape in words, with its place: "the `sphere` at scene.bhs:3:7".
fn shape_words(built: &BuiltScene, index: u32) -> String {
    let Some((plugin, at)) = built.statements.shape(index) else { return "a shape".to_owned() };
    let place = built.statements.place(at).map(|place| format!(" at {place}")).unwrap_or_default();
    format!("the `{plugin}`{place}")
}

/// A light in words: number `light` of those that light sampling chooses from.
fn light_words(built: &BuiltScene, light: u32) -> String {
    let sampler = &built.scene.light_sampler;
    if let Some(emitter) = sampler.emitters.get(light as usize) {
        let index = built.scene.shapes[emitter.geometry as usize].index;
        return format!("the area light of {}", shape_words(built, index));
    }
    let statement = built.statements.lights.get(light as usize - sampler.emitters.len());
    let Some(statement) = statement else { return "the light".to_owned() };
    let place = built.statements.place(statement.at).map(|place| format!(" at {place}")).unwrap_or_default();
    format!("the light `{}`{place}", statement.plugin)
}

/// A number in few digits.
fn few_digits(x: f64) -> String {
    let rounded = format!("{x:.3}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if (1e-2..1e6).contains(&x.abs()) || x == 0.0 { short.to_owned() } else { format!("{x:.2e}") }
}
