//! `point`: a light that shines from a point, equally in all directions.
//!
//! The intensity is that which an observer at rest beside it sees. BSDF sampling does not find a point: it is found by light sampling
//! alone, along every geodesic that joins it with a surface. Without a hole the light falls off with the square of the distance;
//! near one as the geodesics spread.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `I` | spectrum | 1 | W sr^-1 nm^-1 | spectral intensity |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `from` | point3 | 0 0 0 | scene | where it is, under the current transform |
//! | `power` | float | none | | instead of the strength of `I`: power weighted by the eye, over all directions |
//!
//! ```bhs
//! WorldBegin
//! LightSource "point" "spectrum I" 4 "point3 from" [0 2 0]
//! ```

use crate::from_point::FromPoint;
use crate::scale;
use bhs_core::light::Light;
use bhs_core::params::{Params, Point3};
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SpectrumRole};
use glam::DVec3;
use std::f64::consts::PI;

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> = Plugin { name: "point", summary: "a point that shines equally in all directions", build };

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let intensity = p.spectrum("I", 1.0, SpectrumRole::Emission, "W sr^-1 nm^-1", "spectral intensity");
    let scale = scale(p);
    let from = p.get("from", Point3(DVec3::ZERO), "scene", "where it is, under the current transform");
    let position = p.context().world_from_object.transform_point3(from.0);
    Some(Box::new(Point(FromPoint::read(p, (intensity, scale), 4.0 * PI, position))))
}

struct Point(FromPoint);

impl Light for Point {
    fn position(&self) -> Option<DVec3> {
        Some(self.0.position)
    }

    fn intensity(&self, _: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        self.0.intensity(1.0, lambda_nm)
    }

    fn power(&self, lo: f32, hi: f32, _: f64) -> f64 {
        self.0.power(lo, hi)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.0.position -= origin;
    }
}
