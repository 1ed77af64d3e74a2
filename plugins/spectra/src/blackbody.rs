//! `blackbody`: the light of a black body, absolute.
//!
//! Planck's spectral radiance per wavelength, W m^-2 sr^-1 nm^-1:
//! `B = 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1)`, with the exact SI values of h, c and k.
//! Nothing is renormalised (pbrt-v4 scales the peak to 1): 6500 K gives 46,097 at 500 nm; set the light's `scale`.
//!
//! Source: Planck 1901; CODATA 2018.
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | one number | `blackbody` | K | temperature, as the observer beside the surface measures it |
//!
//! ```bhs
//! LightSource "infinite" "blackbody L" 5500 "float scale" 1e-4
//! ```

use crate::planck::{Planck, temperature};
use crate::{Built, Maker};
use bhs_core::Plugin;
use bhs_core::params::{Context, SpectrumMaker};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "blackbody",
    summary: "Planck's absolute radiance of a black body at a temperature [K]",
    build: |_| Some(Box::new(Maker(make))),
};

/// The radiance of a black body.
#[derive(Debug)]
struct Blackbody(Planck);

fn make(param: &Param, role: SpectrumRole, _: &Context) -> Built {
    Ok(Arc::new(Blackbody(Planck::new(temperature(param, role)?))))
}

impl Spectrum for Blackbody {
    fn at(&self, lambda_nm: f32) -> f32 {
        self.0.radiance(f64::from(lambda_nm)) as f32
    }

    fn max(&self, lo: f32, hi: f32) -> f32 {
        self.0.max(lo, hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planck::HOTTEST;

    #[test]
    fn every_wavelength_and_temperature_has_a_finite_radiance() {
        let body = |t: f64| Blackbody(Planck::new(t));
        assert_eq!([0.0, -5.0, 1e-3].map(|l| body(6500.0).at(l)), [0.0; 3]);
        assert!(body(HOTTEST).at(1e-3).is_finite() && body(HOTTEST).max(1e-3, 1e3).is_finite());
        // The same observer everywhere: a black body knows no hole.
        let lambda = [400.0, 500.0, 600.0, 700.0];
        assert_eq!(body(3000.0).sample_at(lambda, 0.3), body(3000.0).sample(lambda));
    }
}
