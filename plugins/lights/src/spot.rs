//! `spot`: a light that shines from a point into a cone.
//!
//! Within `coneangle - conedeltaangle` of its axis it has the intensity `I`; from there to `coneangle` it falls off to zero as
//! `t^2 (3 - 2 t)` of the cosine, as in pbrt-v4. Directions are those that an observer at rest beside it measures. No path meets it by
//! chance: it takes a light transport that samples lights.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `I` | spectrum | 1 | W sr^-1 nm^-1 | spectral intensity within the inner cone |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `from` | point3 | 0 0 0 | scene | where it is, under the current transform |
//! | `to` | point3 | 0 0 1 | scene | a point that it shines at |
//! | `coneangle` | float | 30 | deg | half of the cone's opening |
//! | `conedeltaangle` | float | 5 | deg | the outer part of that, over which it falls off |
//! | `power` | float | none | | instead of the strength of `I`: power weighted by the eye, over all directions |
//!
//! ```bhs
//! WorldBegin
//! LightSource "spot" "spectrum I" 20 "point3 from" [0 3 0] "point3 to" [0 0 0] "float coneangle" 20
//! ```

use crate::from_point::FromPoint;
use crate::{aim, scale};
use bhs_core::light::Light;
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SpectrumRole};
use bhs_elementary::Elementary;
use glam::DVec3;
use std::f64::consts::PI;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> = Plugin { name: "spot", summary: "a point that shines into a cone", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let about = "spectral intensity within the inner cone";
    let intensity = p.spectrum("I", 1.0, SpectrumRole::Emission, "W sr^-1 nm^-1", about);
    let scale = scale(p);
    let aim = aim(p, ["where it is, under the current transform", "a point that it shines at"]);
    let angle = p.get_in("coneangle", 30.0, 0.001..=180.0, "deg", "half of the cone's opening");
    let delta = p.get_in("conedeltaangle", 5.0, 0.0..=180.0, "deg", "the outer part of that, over which it falls off");
    let cos = |degrees: f64| degrees.max(0.0).to_radians().cosine();
    let cone = Cone { outer: cos(angle), inner: cos(angle - delta) };
    let (position, axis) = aim.unwrap_or_default();
    let source = FromPoint::read(p, (intensity, scale), cone.solid_angle(), position);
    aim.map(|_| Box::new(Spot { source, axis, cone }) as Box<dyn Light>)
}

/// A cone with a soft edge, by the cosines of its half angles.
#[derive(Clone, Copy)]
struct Cone {
    outer: f64,
    inner: f64,
}

impl Cone {
    /// Share of the full intensity in a direction at an angle of cosine `cos` to the axis.
    fn falloff(self, cos: f64) -> f64 {
        if cos <= self.outer {
            return 0.0;
        }
        if cos >= self.inner {
            return 1.0;
        }
        let t = (cos - self.outer) / (self.inner - self.outer);
        t * t * (3.0 - 2.0 * t)
    }

    /// The integral of the falloff over all directions (sr): over the edge its mean is 1/2.
    fn solid_angle(self) -> f64 {
        2.0 * PI * ((1.0 - self.inner) + 0.5 * (self.inner - self.outer))
    }
}

struct Spot {
    source: FromPoint,
    /// Unit direction of the middle of the cone, local.
    axis: DVec3,
    cone: Cone,
}

impl Light for Spot {
    fn position(&self) -> Option<DVec3> {
        Some(self.source.position)
    }

    fn intensity(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        self.source.intensity(self.cone.falloff(direction.dot(self.axis)) as f32, lambda_nm)
    }

    fn power(&self, lo: f32, hi: f32, _: f64) -> f64 {
        self.source.power(lo, hi)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.source.position -= origin;
    }
}
