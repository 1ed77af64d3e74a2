//! Spectra and the few wavelengths of them that one path carries.
//!
//! A path samples [`N_LAMBDA`] wavelengths over the film's range ("hero" sampling: one random number places all of them,
//! equally spaced in probability; Wilkie et al. 2014, "Hero Wavelength Spectral Sampling"). Wavelengths are in nanometres
//! throughout.

mod visible;

pub use visible::{VisibleWavelengths, WAVELENGTH_BINS};

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Sub};

/// Wavelengths carried by one path.
pub const N_LAMBDA: usize = 4;

/// A function of wavelength (nm): a reflectance, a spectral radiance, a refractive index, ...
pub trait Spectrum: Send + Sync + Debug {
    /// The value at one wavelength (nm), which may lie outside the data and outside the film's range.
    fn at(&self, lambda_nm: f32) -> f32;

    /// An upper bound of the value over `lo..=hi` (nm).
    fn max(&self, lo: f32, hi: f32) -> f32;

    /// The values at all wavelengths of a path.
    #[inline]
    fn sample(&self, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        SampledSpectrum(lambda_nm.map(|l| self.at(l)))
    }

    /// The values where clocks run at the rate `lapse` of one far from the hole; only a spectrum that depends on it differs.
    #[inline]
    fn sample_at(&self, lambda_nm: [f32; N_LAMBDA], _lapse: f32) -> SampledSpectrum {
        self.sample(lambda_nm)
    }

    /// Whether the value is the same at all wavelengths; a refractive index that is not disperses.
    fn is_constant(&self) -> bool {
        false
    }
}

/// What a spectrum is used for. It decides how an `rgb` is raised to a spectrum and what is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpectrumRole {
    /// A reflectance or transmittance: between 0 and 1; `rgb` by smooth upsampling.
    Reflectance,
    /// Emitted light: not negative; `rgb` by upsampling times the illuminant D65.
    Emission,
    /// Any non-negative number, such as a refractive index.
    Unbounded,
}

impl SpectrumRole {
    /// Why `value` cannot be used so, in words that stand under the underlined text.
    pub fn fault(self, value: f64) -> Option<&'static str> {
        match self {
            Self::Reflectance if !(0.0..=1.0).contains(&value) => Some("a reflectance lies between 0 and 1"),
            Self::Emission if value < 0.0 => Some("emitted light is not negative"),
            Self::Unbounded if value < 0.0 => Some("a negative value has no meaning here"),
            // Spectra are evaluated in single precision.
            _ if value > f64::from(f32::MAX) => Some("this number is too large"),
            _ => None,
        }
    }
}

/// Values at the wavelengths of a path.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SampledSpectrum(pub [f32; N_LAMBDA]);

impl SampledSpectrum {
    /// All zero.
    pub const ZERO: Self = Self([0.0; N_LAMBDA]);
    /// All one.
    pub const ONE: Self = Self([1.0; N_LAMBDA]);

    /// The same value at all wavelengths.
    #[inline]
    pub fn splat(value: f32) -> Self {
        Self([value; N_LAMBDA])
    }

    /// Applies `f` to every value.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        // A loop: `array::map` is not inlined everywhere.
        let mut values = self.0;
        for v in &mut values {
            *v = f(*v);
        }
        Self(values)
    }

    /// Joins two spectra value by value.
    #[inline]
    pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut values = self.0;
        for (v, o) in values.iter_mut().zip(other.0) {
            *v = f(*v, o);
        }
        Self(values)
    }

    /// The largest value.
    #[inline]
    pub fn max(self) -> f32 {
        let [a, b, c, d] = self.0;
        a.max(b).max(c.max(d))
    }

    /// The mean of the values.
    #[inline]
    pub fn mean(self) -> f32 {
        self.0.into_iter().sum::<f32>() / N_LAMBDA as f32
    }

    /// Whether every value is zero.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.0.into_iter().all(|v| v == 0.0)
    }

    /// Whether every value is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.into_iter().all(f32::is_finite)
    }
}

impl Add for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}

impl AddAssign for SampledSpectrum {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
}

impl Mul for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}

impl MulAssign for SampledSpectrum {
    #[inline]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl Mul<f32> for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn mul(self, s: f32) -> Self {
        self.map(|v| v * s)
    }
}

impl MulAssign<f32> for SampledSpectrum {
    #[inline]
    fn mul_assign(&mut self, s: f32) {
        *self = *self * s;
    }
}

impl Div<f32> for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn div(self, s: f32) -> Self {
        self.map(|v| v / s)
    }
}

impl Index<usize> for SampledSpectrum {
    type Output = f32;
    #[inline]
    fn index(&self, i: usize) -> &f32 {
        &self.0[i]
    }
}

impl IndexMut<usize> for SampledSpectrum {
    #[inline]
    fn index_mut(&mut self, i: usize) -> &mut f32 {
        &mut self.0[i]
    }
}

/// The wavelengths of one path, as the film sees them, with the density they were drawn from.
///
/// They are the wavelengths *at the camera*. What a surface sees is [`SampledWavelengths::at`] its own place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledWavelengths {
    /// Wavelengths at the camera (nm).
    pub lambda_nm: [f32; N_LAMBDA],
    /// Probability density of each (1/nm).
    pub pdf: [f32; N_LAMBDA],
}

impl SampledWavelengths {
    /// Draws wavelengths over `lo..=hi` (nm) from one number `u` in [0,1): see [`VisibleWavelengths`].
    pub fn visible(u: f32, lo: f32, hi: f32) -> Self {
        VisibleWavelengths::new(lo, hi).sample(u)
    }

    /// The wavelengths as an observer sees them whose `shift` is the ratio of local to camera wavelength.
    #[inline]
    pub fn at(&self, shift: f32) -> [f32; N_LAMBDA] {
        self.lambda_nm.map(|l| l * shift)
    }

    /// The same light where all its wavelengths are `shift` times as long. The densities stay: they are those that the wavelengths were drawn with.
    #[inline]
    #[must_use]
    pub fn shifted(&self, shift: f64) -> Self {
        Self { lambda_nm: self.at(shift as f32), ..*self }
    }

    /// Reduces a path to its first wavelength, because it now goes where that one alone goes (dispersion). From here on surfaces
    /// see that wavelength in all places, and `throughput` is that of the first, in the first place, which counts for the others
    /// too. What the path has found before keeps its wavelengths. A path of one wavelength already stays as it is.
    #[inline]
    pub fn drop_secondary(&mut self, throughput: &mut SampledSpectrum) {
        let first = self.lambda_nm[0];
        if self.lambda_nm[1..].iter().all(|l| *l == first) {
            return;
        }
        self.lambda_nm = [first; N_LAMBDA];
        let carried = throughput[0];
        *throughput = SampledSpectrum::ZERO;
        throughput[0] = carried * N_LAMBDA as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_wavelengths_stay_in_range_and_integrate_to_one() {
        for (lo, hi) in [
            (360.0, 830.0),
            (400.0, 700.0),
            (500.0, 510.0),
            (500.0, 500.001),
            (200.0, 940.0),
            (300.0, 2500.0),
            (1.0, 1e7),
            (9e6, 1e7),
        ] {
            let n = 4096;
            let mut inverse_density = 0.0f64;
            for i in 0..n {
                let w = SampledWavelengths::visible((i as f32 + 0.5) / n as f32, lo, hi);
                for k in 0..N_LAMBDA {
                    assert!(w.lambda_nm[k] >= lo && w.lambda_nm[k] <= hi && w.pdf[k] > 0.0 && w.pdf[k].is_finite());
                    inverse_density += 1.0 / f64::from(w.pdf[k]);
                }
            }
            // The mean of 1/pdf is the length of the range.
            let length = inverse_density / (n * N_LAMBDA) as f64;
            assert!((length / f64::from(hi - lo) - 1.0).abs() < 1e-3, "{length}");
        }
    }

    #[test]
    fn a_path_of_one_wavelength_has_the_same_mean() {
        let n = 4096;
        let mean = |drop: bool| -> f64 {
            let mut sum = 0.0;
            for i in 0..n {
                let w = SampledWavelengths::visible((i as f32 + 0.5) / n as f32, 360.0, 830.0);
                let mut throughput = SampledSpectrum(w.lambda_nm);
                let mut here = w;
                if drop {
                    here.drop_secondary(&mut throughput);
                    let once = throughput;
                    here.drop_secondary(&mut throughput);
                    assert_eq!(throughput, once);
                    assert_eq!(here.lambda_nm, [w.lambda_nm[0]; N_LAMBDA]);
                }
                sum += (0..N_LAMBDA).map(|k| f64::from(throughput[k] / w.pdf[k])).sum::<f64>() / (N_LAMBDA * n) as f64;
            }
            sum
        };
        assert!((mean(true) / mean(false) - 1.0).abs() < 1e-3);
    }
}
