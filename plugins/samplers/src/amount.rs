//! How many samples pixels have, and when they have enough: what samplers share whose samples may end anywhere.

use bhs_core::params::Params;
use bhs_core::sampling::{MOST_SAMPLES, NoiseMeasure, NoiseTarget};

/// How many samples pixels have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Amount {
    /// At most, and without a target of noise as many.
    pub samples: u32,
    /// When a pixel has enough.
    pub target: Option<NoiseTarget>,
}

impl Amount {
    /// So many, whatever their noise.
    #[cfg(test)]
    pub fn fixed(samples: u32) -> Self {
        Self { samples, target: None }
    }

    /// Reads `pixelsamples`, `noise` and `noisemeasure`.
    pub fn read(p: &Params) -> Self {
        let about = "standard error of a pixel's luminance below which it gets no more samples";
        let noise = p.optional::<f64>("noise", "", about);
        if let Some(noise) = noise.filter(|noise| !NoiseTarget::takes(*noise)) {
            p.reject("noise", "`noise` is out of range", format!("{}, found {noise}", NoiseTarget::EXPECTED));
        }
        let about = "`relative`: noise is over the luminance; `shown`: over the white of a screen";
        let measure = match p.get("noisemeasure", "relative".to_owned(), "", about).as_str() {
            "relative" => NoiseMeasure::Relative,
            "shown" => NoiseMeasure::Shown,
            other => {
                p.reject("noisemeasure", format!("there is no measure `{other}`"), "expected `relative` or `shown`");
                NoiseMeasure::Relative
            }
        };
        let samples = p.get_in(
            "pixelsamples",
            16,
            1..=i64::from(MOST_SAMPLES),
            "",
            "samples per pixel; with `noise` at most, and no limit if not given",
        );
        // Pixels that end by their noise need no other end.
        let samples = if noise.is_some() && !p.is_given("pixelsamples") { MOST_SAMPLES } else { samples as u32 };
        Self { samples, target: noise.map(|noise| NoiseTarget { noise, measure }) }
    }
}
