//! The density by which the wavelengths of paths are drawn.

use super::{N_LAMBDA, SampledWavelengths};
use bhs_elementary::Elementary;
use std::sync::Arc;

/// Bins of a density that follows what light a scene has: some 4 nm of the visible range.
pub const WAVELENGTH_BINS: usize = 128;

/// The density by which wavelengths are drawn over a range: it follows the eye's sensitivity, if the eye sees all of the range.
///
/// Proportional to `1/cosh^2(0.0072 (lambda - 538 nm))`, renormalised to the range (as in pbrt-v4, after Radziszewski et al. 2009,
/// "An Improved Technique for Full Spectral Rendering"). Where that is less than a hundredth of its peak, beyond some 950 nm, and over
/// ranges too narrow for its digits, wavelengths are drawn evenly. Nowhere zero, so unbiased for any film.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleWavelengths {
    range_nm: [f32; 2],
    density: Density,
}

#[derive(Clone, Debug, PartialEq)]
enum Density {
    /// The hyperbolic tangent, of which 1/cosh^2 is the derivative, at the lower end, and how much it rises to the upper one.
    Eye {
        tanh_lo: f32,
        rise: f32,
    },
    Even,
    /// The numbers at which the bins of equal width begin, from 0, and 1 at the end.
    Bins(Arc<[f32; WAVELENGTH_BINS + 1]>),
}

impl VisibleWavelengths {
    /// Steepness (1/nm) and centre (nm) of the density.
    const A: f32 = 0.0072;
    const CENTRE: f32 = 538.0;
    /// Least density over its peak, and least rise of its integral, for which single precision is good enough.
    const LEAST: f32 = 1e-2;

    /// Over `lo..=hi` (nm).
    pub fn new(lo: f32, hi: f32) -> Self {
        let [tanh_lo, tanh_hi] = [lo, hi].map(|l| (Self::A * (l - Self::CENTRE)).hyperbolic_tangent());
        let rise = tanh_hi - tanh_lo;
        let least = (1.0 - tanh_lo * tanh_lo).min(1.0 - tanh_hi * tanh_hi);
        let density = if least >= Self::LEAST && rise >= Self::LEAST { Density::Eye { tanh_lo, rise } } else { Density::Even };
        Self { range_nm: [lo, hi], density }
    }

    /// The same range, of whose bins of equal width each is drawn with the share that `shares` has of its sum, and evenly within; `None` unless all are above
    /// 0, so that it is unbiased for any film.
    pub fn with_shares(&self, shares: &[f64; WAVELENGTH_BINS]) -> Option<Self> {
        let sum: f64 = shares.iter().sum();
        let mut starts = [0.0; WAVELENGTH_BINS + 1];
        let mut below = 0.0;
        for (start, share) in starts.iter_mut().zip(shares) {
            *start = (below / sum) as f32;
            below += share;
        }
        starts[WAVELENGTH_BINS] = 1.0;
        let are_bins = sum.is_finite() && starts.windows(2).all(|ends| ends[0] < ends[1]);
        are_bins.then(|| Self { density: Density::Bins(Arc::new(starts)), ..*self })
    }

    /// Number of the bin of a wavelength of the range (nm).
    pub fn bin(&self, lambda_nm: f32) -> usize {
        let [lo, hi] = self.range_nm;
        (((lambda_nm - lo) / (hi - lo) * WAVELENGTH_BINS as f32) as usize).min(WAVELENGTH_BINS - 1)
    }

    /// Where the bin `i` begins (nm), and the one before it ends.
    pub fn edge(&self, i: usize) -> f32 {
        let [lo, hi] = self.range_nm;
        lo + (hi - lo) * i as f32 / WAVELENGTH_BINS as f32
    }

    /// The share of each bin.
    pub fn shares(&self) -> [f64; WAVELENGTH_BINS] {
        let below = |i: usize| match &self.density {
            Density::Eye { tanh_lo, rise } => {
                f64::from(((Self::A * (self.edge(i) - Self::CENTRE)).hyperbolic_tangent() - tanh_lo) / rise)
            }
            Density::Even => i as f64 / WAVELENGTH_BINS as f64,
            Density::Bins(starts) => f64::from(starts[i]),
        };
        std::array::from_fn(|i| below(i + 1) - below(i))
    }

    /// Draws the wavelengths of a path from one number `u` in [0,1).
    #[inline]
    pub fn sample(&self, u: f32) -> SampledWavelengths {
        let [lo, hi] = self.range_nm;
        let u: [f32; N_LAMBDA] = std::array::from_fn(|i| (u + i as f32 / N_LAMBDA as f32).fract());
        match &self.density {
            Density::Eye { tanh_lo, rise } => {
                let tanh = u.map(|u| tanh_lo + u * rise);
                SampledWavelengths {
                    // The inverse of tanh is ln((1 + t)/(1 - t))/2.
                    lambda_nm: tanh.map(|t| (Self::CENTRE + ((1.0 + t) / (1.0 - t)).logarithm() * (0.5 / Self::A)).clamp(lo, hi)),
                    // 1/cosh^2 = 1 - tanh^2
                    pdf: tanh.map(|t| Self::A * (1.0 - t * t) / rise),
                }
            }
            Density::Bins(starts) => {
                let bins = u.map(|u| starts.partition_point(|start| *start <= u).clamp(1, WAVELENGTH_BINS) - 1);
                let width = (hi - lo) / WAVELENGTH_BINS as f32;
                let share = bins.map(|bin| starts[bin + 1] - starts[bin]);
                SampledWavelengths {
                    lambda_nm: std::array::from_fn(|k| {
                        (lo + width * (bins[k] as f32 + (u[k] - starts[bins[k]]) / share[k])).clamp(lo, hi)
                    }),
                    pdf: share.map(|share| share / width),
                }
            }
            Density::Even => {
                SampledWavelengths { lambda_nm: u.map(|u| (lo + u * (hi - lo)).clamp(lo, hi)), pdf: [1.0 / (hi - lo); N_LAMBDA] }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_drawn_as_they_are_and_integrate_to_the_range() {
        let plain = VisibleWavelengths::new(360.0, 830.0);
        let eye = plain.shares();
        assert!((eye.iter().sum::<f64>() - 1.0).abs() < 1e-6);
        // A line near 589 nm, and the eye's density.
        let line = plain.bin(589.3);
        let mixed =
            plain.with_shares(&std::array::from_fn(|i| 0.3 * eye[i] + if i == line { 0.7 } else { 0.0 })).expect("none is 0");
        let n = 1 << 16;
        let (mut in_line, mut inverse) = (0, 0.0);
        for i in 0..n {
            let w = mixed.sample((i as f32 + 0.5) / n as f32);
            for k in 0..N_LAMBDA {
                assert!((360.0..=830.0).contains(&w.lambda_nm[k]) && w.pdf[k] > 0.0);
                in_line += usize::from(mixed.bin(w.lambda_nm[k]) == line);
                inverse += 1.0 / f64::from(w.pdf[k]);
            }
        }
        let drawn = (N_LAMBDA * n) as f64;
        assert!((in_line as f64 / drawn - mixed.shares()[line]).abs() < 1e-3);
        assert!((inverse / drawn / 470.0 - 1.0).abs() < 1e-3, "{inverse}");
        assert!(plain.with_shares(&[0.0; WAVELENGTH_BINS]).is_none());
    }
}
