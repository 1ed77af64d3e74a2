//! How bright a picture is, and which exposure would be right.

use super::{EXPOSURE, Explanation, Level};
use crate::film::Framebuffer;
use crate::lang::BuiltScene;
use crate::look::Exposure;
use bhs_elementary::Elementary;
use bhs_engine::stats::Counters;

/// Bins of a stop's fourth, from this many stops below 1 on.
const LEAST: f64 = -80.0;
const BINS: usize = 800;
const BINS_PER_STOP: f64 = 4.0;

/// What a picture should be like: the middle of its lit pixels, by the logarithm (Reinhard et al. 2002).
const KEY: f64 = 0.18;
/// How far off the exposure is when something is said of it (stops).
const FAR_OFF: f64 = 7.5;
/// A picture that is too dark shows nothing above this...
const DARK: f64 = 1.0 / 32.0;
/// ... but in so many of the lit pixels, and at most in so many at all: fireflies.
const OUTLIERS: f64 = 0.002;
/// A picture that is too bright has hardly a pixel below this.
const BRIGHT: f64 = 16.0;

/// A trace of light, in no more than one of so many pixels.
const TRACE: f64 = 1.0 / 256.0;
const FEW: u64 = 100;

/// What light that grazes a surface leaves by rounding alone, and no less than any picture has (2^-56).
const ROUNDING: f64 = 1.4e-17;

/// The luminance of a picture's pixels.
pub struct Brightness {
    bins: Vec<u64>,
    /// All pixels.
    pixels: u64,
    /// Pixels with light.
    lit: u64,
    /// Of whatever colour, also such as the film cannot show.
    any: bool,
    /// Sum of the logarithms (base 2) of the luminance of lit pixels.
    sum: f64,
}

impl Brightness {
    /// That of a frame as it stands.
    pub fn of(frame: &Framebuffer) -> Self {
        let mut all = Self { bins: vec![0; BINS], pixels: 0, lit: 0, any: false, sum: 0.0 };
        frame.each_color(|[r, g, b], greatest| {
            all.pixels += 1;
            all.any |= greatest > ROUNDING;
            let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            if luminance > 0.0 {
                let stops = luminance.logarithm2();
                all.lit += 1;
                all.sum += stops;
                all.bins[(((stops - LEAST) * BINS_PER_STOP).max(0.0) as usize).min(BINS - 1)] += 1;
            }
        });
        all
    }

    /// Whether there is no light at all, but for a trace of it in a few pixels that the exposure does not show: what rounding lets through an edge.
    pub fn is_black(&self, exposure: Exposure) -> bool {
        let is_trace = || matches!(exposure, Exposure::Stops(stops) if self.percentile(1.0) + stops < TRACE.logarithm2());
        !self.any || (self.lit > 0 && FEW * self.lit <= self.pixels && is_trace())
    }

    /// The luminance below which a share of the lit pixels is, to a fourth of a stop (stops above 1).
    fn percentile(&self, share: f64) -> f64 {
        let wanted = (share * self.lit as f64).ceil() as u64;
        let mut below = 0;
        let bin = self.bins.iter().position(|count| {
            below += count;
            below >= wanted
        });
        LEAST + (bin.unwrap_or(BINS - 1) as f64 + 0.5) / BINS_PER_STOP
    }

    /// Says so if the PNG shows nothing but black, or nothing but white. A night sky may be meant to be dark.
    pub fn explain(&self, built: &BuiltScene, c: &Counters) -> Option<Explanation> {
        if self.lit == 0 {
            return None;
        }
        // What is found for the picture itself is right.
        let Exposure::Stops(exposure) = built.look.exposure else { return None };
        let middle = self.sum / self.lit as f64;
        let right = KEY.logarithm2() - middle;
        let off = exposure - right;
        let is_dark = off < -FAR_OFF && self.percentile(1.0 - OUTLIERS) + exposure < DARK.logarithm2();
        let is_bright = off > FAR_OFF && self.percentile(0.1) + exposure > BRIGHT.logarithm2();
        let how = match (is_dark, is_bright) {
            (true, _) => "dark",
            (_, true) => "bright",
            _ => return None,
        };
        let film = &built.statements.film;
        let place = built.statements.place(film.param("exposure").unwrap_or(film.at));
        let place = place.map(|place| format!(" ({place})")).unwrap_or_default();
        let has_stars = built.scene.light_sampler.lights.iter().any(|light| !light.points().is_empty());
        let level = if is_dark && (has_stars || c.camera_hit == 0) { Level::Note } else { Level::Warning };
        Some(Explanation {
            level,
            code: EXPOSURE,
            text: format!(
                "the PNG is about {:.0} stops too {how}; write \"float exposure\" {right:.1} into the `Film`{place} or --exposure {right:.1} behind the \
                 command, or make the lights {}: the EXR file has all that there is",
                off.abs(),
                if is_dark { "stronger" } else { "weaker" },
            ),
        })
    }
}
