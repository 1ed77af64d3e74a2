//! Planck's law, and the temperature that a parameter gives for it.
//!
//! Spectral radiance per wavelength, W m^-2 sr^-1 nm^-1: `B = 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1)`, with the exact
//! SI values of h, c and k.
//!
//! Source: Planck 1901; CODATA 2018.

use crate::{numbers, wrong_value};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use bhs_elementary::Elementary;

/// Planck constant [J s] (exact).
const H: f64 = 6.626_070_15e-34;
/// Speed of light [m/s] (exact).
const C: f64 = 299_792_458.0;
/// Boltzmann constant [J/K] (exact).
const K: f64 = 1.380_649e-23;
/// Wien's displacement constant [nm K]: h c / (k x) with x = 5 (1 - exp(-x)).
const WIEN: f64 = 2.897_771_955e6;
/// Hotter than this (K) single precision may overflow; no surface is.
pub const HOTTEST: f64 = 1e9;

/// The radiance of a black body.
#[derive(Clone, Copy, Debug)]
pub struct Planck {
    /// Temperature (K).
    temperature: f64,
    /// h c / (k T) (nm).
    scale_nm: f64,
}

impl Planck {
    /// Of the given temperature (K).
    pub fn new(temperature: f64) -> Self {
        Self { temperature, scale_nm: H * C / (K * temperature) * 1e9 }
    }

    /// Spectral radiance [W m^-2 sr^-1 nm^-1].
    pub fn radiance(&self, lambda_nm: f64) -> f64 {
        // 2 h c^2 with wavelengths in nm: 1e45 for their fifth power, 1e-9 for the radiance per nm.
        const FIRST: f64 = 2.0 * H * C * C * 1e36;
        if lambda_nm > 0.0 { FIRST / (lambda_nm.powi(5) * (self.scale_nm / lambda_nm).exponential_m1()) } else { 0.0 }
    }

    /// An upper bound of the radiance over `lo..=hi` (nm).
    pub fn max(&self, lo: f32, hi: f32) -> f32 {
        // The curve rises up to Wien's wavelength and falls after it. A hair more than the peak, against round-off.
        let peak = (WIEN / self.temperature).clamp(f64::from(lo), f64::from(hi));
        self.radiance(peak) as f32 * (1.0 + f32::EPSILON)
    }
}

/// The temperature (K) that `param` gives for emitted light, or all that is wrong with it.
pub fn temperature(param: &Param, role: SpectrumRole) -> Result<f64, Vec<Diagnostic>> {
    let [temperature] = *numbers(param) else {
        return Err(vec![wrong_value(param, "one temperature [K]")]);
    };
    let name = &param.name.value;
    let mut found = Vec::new();
    if !(temperature > 0.0 && temperature <= HOTTEST) {
        let cause = if temperature > 0.0 { "hotter than 1e9 K is not supported" } else { "a temperature is greater than 0 K" };
        found.push(Diagnostic::error("bad-value", format!("`{name}` is {temperature} K")).at(param.span, cause));
    }
    if role != SpectrumRole::Emission {
        let message = format!("`{name}` is not emitted light");
        found.push(Diagnostic::error("wrong-type", message).at(param.ty.span, "a black body only describes emission"));
    }
    if found.is_empty() { Ok(temperature) } else { Err(found) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integral_is_stefan_boltzmann() {
        // sigma = 2 pi^5 k^4 / (15 h^3 c^2); radiance integrates to sigma T^4 / pi.
        let sigma = 2.0 * std::f64::consts::PI.powi(5) * K.powi(4) / (15.0 * H.powi(3) * C * C);
        assert!((sigma / 5.670_374_419e-8 - 1.0).abs() < 1e-9);
        for t in [300.0, 2856.0, 6500.0, 30_000.0] {
            let body = Planck::new(t);
            // Midpoint rule over ln(lambda), from far in the exponential tail to far in the Rayleigh-Jeans tail.
            let (lo, hi, n) = ((WIEN / t / 50.0).ln(), (WIEN / t * 1e4).ln(), 200_000);
            let step = (hi - lo) / f64::from(n);
            let sum: f64 = (0..n)
                .map(|i| {
                    let l = (lo + (f64::from(i) + 0.5) * step).exp();
                    body.radiance(l) * l * step
                })
                .sum();
            let exact = sigma * t.powi(4) / std::f64::consts::PI;
            assert!((sum / exact - 1.0).abs() < 1e-9, "{t} K: {}", sum / exact - 1.0);
        }
    }

    #[test]
    fn peak_is_wiens() {
        for t in [1000.0, 5772.0] {
            let body = Planck::new(t);
            let peak = WIEN / t;
            // A maximum: the slope changes sign within 1e-6 of Wien's wavelength.
            let slope = |l: f64| body.radiance(l * (1.0 + 1e-6)) - body.radiance(l * (1.0 - 1e-6));
            assert!(slope(peak * (1.0 - 1e-5)) > 0.0 && slope(peak * (1.0 + 1e-5)) < 0.0);
            assert!(body.max(100.0, 10_000.0) >= body.radiance(peak) as f32);
            assert_eq!(body.max(100.0, 200.0), body.radiance(200.0) as f32 * (1.0 + f32::EPSILON));
        }
    }

    #[test]
    fn values_are_absolute() {
        // The formula in Python's double precision, in SI units.
        let body = Planck::new(6500.0);
        assert!((body.radiance(500.0) / 46_097.184_673_518 - 1.0).abs() < 1e-12, "{}", body.radiance(500.0));
        assert_eq!((body.radiance(0.0), body.radiance(-5.0)), (0.0, 0.0));
    }
}
