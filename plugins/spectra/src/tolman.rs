//! `tolman`: the light of a black body in thermal equilibrium with a black hole's field, absolute.
//!
//! What is in equilibrium in a static field is the hotter the deeper it lies: its local temperature is `T0 / sqrt(f(r))`, `f = 1 - rs/r`,
//! where T0 is the temperature far from the hole. The radiance is Planck's at that temperature, as for `blackbody`. A closed room
//! whose walls, and a surface around the hole, all emit like this looks like one black body at `T0 / sqrt(f)` of the camera, in every direction: no lens
//! shows. Where nothing shifts (no hole, or `"bool redshift" false`) it is `blackbody`.
//!
//! Source: Tolman 1930, "On the Weight of Heat and Thermal Equilibrium in General Relativity"; Tolman and Ehrenfest 1930.
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | one number | `tolman` | K | temperature far from the hole |
//!
//! ```bhs
//! LookAt 0 0 -4  0 0 0  0 1 0
//! WorldBegin
//! BlackHole "schwarzschild" "float rs" 1
//! AreaLightSource "diffuse" "tolman L" 3000 "float scale" 1e-3 "bool twosided" true
//! Shape "sphere" "float radius" 8
//! ```

use crate::planck::{Planck, temperature};
use crate::{Built, Maker};
use bhs_core::Plugin;
use bhs_core::params::{Context, SpectrumMaker};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "tolman",
    summary: "a black body in equilibrium near a hole, by its temperature far away [K]",
    build: |_| Some(Box::new(Maker(make))),
};

/// The radiance of a black body whose temperature follows the clocks at its place.
#[derive(Debug)]
struct Tolman {
    /// Temperature far from the hole (K).
    temperature: f64,
}

fn make(param: &Param, role: SpectrumRole, _: &Context) -> Built {
    Ok(Arc::new(Tolman { temperature: temperature(param, role)? }))
}

impl Tolman {
    /// The black body beside an observer whose clock runs at the rate `lapse`.
    fn beside(&self, lapse: f32) -> Planck {
        Planck::new(self.temperature / f64::from(lapse))
    }
}

impl Spectrum for Tolman {
    /// Far from the hole.
    fn at(&self, lambda_nm: f32) -> f32 {
        self.beside(1.0).radiance(f64::from(lambda_nm)) as f32
    }

    /// Far from the hole; there is no bound of what is close to it.
    fn max(&self, lo: f32, hi: f32) -> f32 {
        self.beside(1.0).max(lo, hi)
    }

    fn sample_at(&self, lambda_nm: [f32; N_LAMBDA], lapse: f32) -> SampledSpectrum {
        let body = self.beside(lapse);
        SampledSpectrum(lambda_nm.map(|l| body.radiance(f64::from(l)) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_hotter_where_clocks_run_slower() {
        let lambda = [400.0, 500.0, 600.0, 700.0];
        let body = Tolman { temperature: 3000.0 };
        assert_eq!(body.sample_at(lambda, 1.0), body.sample(lambda));
        // At r = 4/3 rs clocks run half as fast. The formula in Python's double precision at 6000 K.
        let found = body.sample_at(lambda, 0.5)[1];
        assert!((found / 31_756.907 - 1.0).abs() < 1e-5, "{found}");
    }

    #[test]
    fn shifted_light_does_not_tell_where_it_comes_from() {
        // L lambda^5 is constant along a ray: what leaves at lambda * lapse arrives far away as L lapse^5 at lambda.
        let body = Tolman { temperature: 4000.0 };
        let far = [450.0f32, 550.0, 650.0, 750.0];
        for lapse in [0.9f32, 0.5, 0.1] {
            let near = body.sample_at(far.map(|l| l * lapse), lapse) * lapse.powi(5);
            for (near, far) in near.0.into_iter().zip(body.sample(far).0) {
                assert!((near / far - 1.0).abs() < 2e-6, "lapse {lapse}: {near} {far}");
            }
        }
    }
}
