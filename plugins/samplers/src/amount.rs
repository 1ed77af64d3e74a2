//! How many samples pixels have, and when they have enough: what samplers share whose samples may end anywhere.

use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::Params;
use bhs_core::sampling::{MOST_SAMPLES, NoiseMeasure, NoiseOver, NoiseTarget};

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

    /// Reads `pixelsamples`, `noise`, `noisemeasure` and `noiseover`.
    pub fn read(p: &Params) -> Self {
        let about = "standard error of luminance below which pixels get no more samples";
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
        let about = "`pixel`: each pixel has less noise than that; `picture`: the root of their mean square is less";
        let over = p.get("noiseover", NoiseOver::Pixel.name().to_owned(), "", about);
        let over = NoiseOver::find(&over).unwrap_or_else(|| {
            p.reject("noiseover", format!("noise is not over a `{over}`"), NoiseOver::EXPECTED);
            NoiseOver::Pixel
        });
        for name in ["noisemeasure", "noiseover"] {
            if noise.is_none() && p.is_given(name) {
                let message = format!("`{name}` does nothing here: all pixels have as many samples without `noise`");
                let warning = Diagnostic::warning("without-noise", message).at(p.span_of(name), "");
                p.report(warning.help("say how much noise is left: \"float noise\" 0.02, or --noise 0.02"));
            }
        }
        let samples = p.get_in(
            "pixelsamples",
            16,
            1..=i64::from(MOST_SAMPLES),
            "",
            "samples per pixel; with `noise` at most, and no limit if not given",
        );
        // Pixels that end by their noise need no other end.
        let samples = if noise.is_some() && !p.is_given("pixelsamples") { MOST_SAMPLES } else { samples as u32 };
        Self { samples, target: noise.map(|noise| NoiseTarget { noise, measure, over }) }
    }
}
