//! Adaptive sampling: which pixels take part in a wave, by the noise that waves before it have left.
//!
//! The noise of a pixel is the standard error of its luminance, over that luminance or over what a screen shows ([`NoiseMeasure`]). What is known
//! of it is known of batches of samples ([`PixelNoise`](crate::film::PixelNoise)). Whether a pixel goes on is asked of its **neighbours**, of a square of
//! two pixels to each side: by their variances, as many samples as it has itself would leave so much noise. Its own samples are asked too, but have to
//! say so by more.
//!
//! That is because a pixel that stopped by its own samples would stop where they happen to be alike, which with light that is found by chance is where they
//! are dark: its mean would be too dark, with any number of samples. Its neighbours' samples know nothing of its own. All samples of a pixel weigh the same,
//! whenever they were made, and each decision is made by waves that are over. `tests/adaptive.rs` holds the mean of many renders against that
//! of renders in which all pixels have as many samples.
//!
//! Where each pixel has to have so little noise ([`NoiseOver::Pixel`]), samples go as its variance: the mean square of the noise is then what as many equal samples
//! leave. Where the picture as a whole has to ([`NoiseOver::Picture`]), they go as the square root of the variance, which of all ways to spread them leaves
//! the least ("Neyman allocation"; Neyman 1934).

use crate::develop::Developer;
use crate::film::Framebuffer;
use crate::look::Look;
use bhs_core::sampling::{NoiseMeasure, NoiseOver, NoiseTarget};
use rayon::prelude::*;
use std::sync::PoisonError;

/// How far the neighbours of a pixel go that are asked (pixels): 24 of them make a variance that is known to some 20 %.
const REACH: usize = 2;
/// By how much a pixel's own noise is above the target before its own samples decide that it goes on.
const OWN: f64 = 3.0;
/// A luminance below this share of the picture's mean counts as this.
const DARK: f64 = 0.02;

/// When pixels have samples enough.
#[derive(Clone, Copy, Debug)]
pub struct NoiseGoal {
    /// The noise that they may have.
    pub target: NoiseTarget,
    /// How the picture is shown.
    pub look: Look,
}

/// The noise of a picture, and what is left to be done for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoiseFound {
    /// Pixels that have more of it than they may have.
    pub above: u64,
    /// All pixels.
    pub pixels: u64,
    /// Root of its mean square, of all pixels that have noise that is known.
    pub rms: f64,
    /// Samples that the picture has in the end, all pixels together, as far as can be foreseen.
    pub expected: u64,
}

/// What has been found of each pixel, row by row.
struct Pixels {
    width: usize,
    height: usize,
    samples: Vec<u32>,
    /// Variance of one sample, in the square of the measure; none where it is not known.
    variance: Vec<Option<f64>>,
}

impl NoiseGoal {
    /// The noise of the picture as it stands.
    pub fn find(&self, frame: &Framebuffer) -> NoiseFound {
        self.judge(frame, |_, _| {})
    }

    /// Decides which pixels take part in the next wave: those that have more noise than they may have. Nobody is at work on a tile.
    pub fn plan(&self, frame: &Framebuffer) -> NoiseFound {
        self.judge(frame, |pixel, above| {
            let mut tile = frame.tile_of(pixel).lock().unwrap_or_else(PoisonError::into_inner);
            let i = tile.index(pixel);
            tile.noise[i].under_way = above;
        })
    }

    /// Calls `each` with every pixel of the frame, and whether it has more noise than it may have.
    fn judge(&self, frame: &Framebuffer, mut each: impl FnMut([u32; 2], bool)) -> NoiseFound {
        let pixels = self.pixels(frame);
        let [x0, _, y0, _] = frame.crop();
        let limit = self.target.noise * self.target.noise;
        let mut found = NoiseFound { pixels: frame.pixel_count(), ..NoiseFound::default() };
        let (mut squares, mut known) = (0.0, 0_u64);
        let judged: Vec<Judged> = (0..pixels.samples.len()).into_par_iter().map(|i| pixels.judged(i)).collect();
        let per_deviation = match self.target.over {
            NoiseOver::Pixel => None,
            NoiseOver::Picture => Some(samples_per_deviation(&judged, limit)),
        };
        for (i, pixel) in judged.iter().enumerate() {
            let needed = match per_deviation {
                None => pixel.variance / limit,
                Some(samples) => samples * pixel.variance.sqrt(),
            };
            let above = needed > pixel.count;
            found.above += u64::from(above);
            found.expected += if above { needed.min(1e9 * pixel.count).ceil() as u64 } else { u64::from(pixels.samples[i]) };
            if let Some(own) = pixels.variance[i] {
                squares += own / pixel.count;
                known += 1;
            }
            each([x0 + (i % pixels.width) as u32, y0 + (i / pixels.width) as u32], above);
        }
        found.rms = (squares / known.max(1) as f64).sqrt();
        found
    }

    fn pixels(&self, frame: &Framebuffer) -> Pixels {
        let [width, height] = frame.size_of_picture().map(|n| n as usize);
        let (mut samples, mut estimates) = (vec![0; width * height], vec![None; width * height]);
        frame.each_pixel(|at, tile, i| {
            if let Some(noise) = tile.noise.get(i) {
                (samples[at], estimates[at]) = (noise.samples, noise.estimate());
            }
        });
        let known = || estimates.iter().flatten();
        let mean = known().map(|[luminance, _]| luminance).sum::<f64>() / known().count().max(1) as f64;
        let developer = (self.target.measure == NoiseMeasure::Shown).then(|| Developer::new(&self.look, &frame.picture()));
        let scale = |luminance: f64| match &developer {
            None => 1.0 / luminance.max(DARK * mean).max(f64::MIN_POSITIVE),
            Some(developer) => slope(developer, luminance),
        };
        let relative = |[luminance, variance]: [f64; 2]| {
            let scale = scale(luminance);
            // Beyond what a number holds there is no end to the noise.
            (variance.sqrt() * scale).powi(2).min(f64::MAX / 1e3)
        };
        let variance = estimates.iter().map(|estimate| estimate.map(relative)).collect();
        Pixels { width, height, samples, variance }
    }
}

/// What is thought of a pixel.
struct Judged {
    /// Samples that it has, one at least.
    count: f64,
    /// Variance of one sample.
    variance: f64,
}

/// How many samples a pixel is to have for each unit of the standard deviation of one of them, so that the mean square of the noise of all pixels is `limit`.
/// Pixels keep what they have. Infinite if no number of samples is enough.
///
/// If the pixels that have more than that were known, the number would follow from the others. Those that have more than too high a number are some of
/// them, and of these follows a lower one that is still not too low: it is found after a few rounds.
fn samples_per_deviation(pixels: &[Judged], limit: f64) -> f64 {
    let mut per_deviation = f64::INFINITY;
    loop {
        let mut left = limit * pixels.len() as f64;
        let mut deviations = 0.0;
        for pixel in pixels {
            let deviation = pixel.variance.sqrt();
            if pixel.count > per_deviation * deviation {
                left -= pixel.variance / pixel.count;
            } else {
                deviations += deviation;
            }
        }
        let lower = deviations / left;
        // What all the others leave cannot be more than the limit, but for the last digits.
        if !(lower < per_deviation && left > 0.0) {
            return if deviations > 0.0 { per_deviation } else { 0.0 };
        }
        per_deviation = lower;
    }
}

impl Pixels {
    /// What its neighbours say of a pixel, and its own samples, where they say much more.
    fn judged(&self, i: usize) -> Judged {
        let own = self.variance[i].unwrap_or_default();
        Judged { count: f64::from(self.samples[i]).max(1.0), variance: self.around(i).max(own / (OWN * OWN)) }
    }

    /// The mean variance of the pixels around one, without its own.
    fn around(&self, i: usize) -> f64 {
        let (x, y) = (i % self.width, i / self.width);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(self.height) {
            for column in x.saturating_sub(REACH)..(x + REACH + 1).min(self.width) {
                let other = row * self.width + column;
                if let Some(variance) = self.variance[other].filter(|_| other != i) {
                    (sum, count) = (sum + variance, count + 1.0);
                }
            }
        }
        sum / count.max(1.0)
    }
}

/// By how much what a screen shows of a grey changes with its luminance.
fn slope(developer: &Developer, luminance: f64) -> f64 {
    let shown = |l: f64| f64::from(developer.display([l as f32; 3])[1]);
    // Wide enough for single precision, and for curves with corners.
    let step = (0.01 * luminance.abs()).max(1e-4);
    let (low, high) = ((luminance - step).max(0.0), luminance + step);
    (shown(high) - shown(low)) / (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_go_as_the_deviation_and_pixels_keep_what_they_have() {
        let pixels = |given: &[[f64; 2]]| given.iter().map(|&[count, variance]| Judged { count, variance }).collect::<Vec<_>>();
        // No pixel has more than it needs: the closed form, sum of deviations over pixels and limit.
        let per_deviation = samples_per_deviation(&pixels(&[[1.0, 4.0], [1.0, 16.0], [1.0, 0.0]]), 0.1);
        assert!((per_deviation - 6.0 / 0.3).abs() < 1e-12, "{per_deviation}");
        // Some have: by bisection.
        let all: Vec<[f64; 2]> = (1..200).map(|i| [f64::from(16 + i * 37 % 64), f64::from(i * 71 % 113).powi(2)]).collect();
        for limit in [1.0, 10.0, 40.0] {
            let left = |c: f64| all.iter().map(|[n, v]| v / n.max(c * v.sqrt())).sum::<f64>() / all.len() as f64;
            let (mut low, mut high) = (0.0, 1e6);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if left(middle) > limit { low = middle } else { high = middle }
            }
            let found = samples_per_deviation(&pixels(&all), limit);
            assert!((found - high).abs() < 1e-9 * high, "{limit}: {found} {high}");
        }
        // Enough of them, no noise, no end to it.
        assert!(samples_per_deviation(&pixels(&[[64.0, 1.0], [64.0, 2.0]]), 1.0) * 2_f64.sqrt() < 64.0);
        assert_eq!(samples_per_deviation(&pixels(&[[16.0, 0.0]]), 0.1), 0.0);
        assert!(samples_per_deviation(&pixels(&[[16.0, f64::MAX], [16.0, f64::MAX]]), 1e-3) > 1e100);
    }
}
