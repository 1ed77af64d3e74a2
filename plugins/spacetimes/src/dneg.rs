//! `dneg`: the wormhole of James, von Tunzelmann, Franklin and Thorne 2015, with a throat of some length and mouths of chosen width. Each of
//! its sides has an isotropic chart, with the same centre.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `center` | point3 | [0 0 0] | scene | centre, under the current transform |
//! | `throat` | float | required | scene | areal radius of the throat, under the current transform |
//! | `length` | float | 0 | scene | whole length of the cylinder between the mouths, under the current transform |
//! | `lensingwidth` | float | required | scene | how far a mouth reaches beyond the throat in areal radius, to where its wall leans by 45 degrees |

use crate::Minkowski;
use crate::graded::{from_index_of, variables_of};
use crate::placement::{Placement, center, in_range, is_length, length};
use bhs_core::Plugin;
use bhs_core::dual::Dual;
use bhs_core::params::Params;
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Ball, Class, Fields, GradedIndex, Metric, Place, Spacetime, Stationary, Stretch, Throat};
use glam::DVec3;
use profile::Profile;
use std::sync::Arc;
use table::Table;

mod profile;
mod table;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> =
    Plugin { name: "dneg", summary: "a wormhole with a throat of chosen length and mouths of chosen width", build };

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let center = center(p);
    let throat = length(p, "throat", "areal radius of the throat, under the current transform");
    let long = p.get("length", 0.0, "scene", "whole length of the cylinder between the mouths, under the current transform");
    let about = "how far a mouth reaches beyond the throat in areal radius, to where its wall leans by 45 degrees";
    let width = length(p, "lensingwidth", about);
    let long = is_length(p, "length", long).then_some(long);
    if width == Some(0.0) {
        p.reject("lensingwidth", "`lensingwidth` is 0", "expected more than 0: light cannot follow an edge");
        return None;
    }
    let placement = Placement::of(p)?;
    let center = placement.point(center);
    let [throat, long, width] = [throat?, long?, width?].map(|x| placement.length(x));
    if !in_range(p, &[center], &[throat, long, width]) {
        return None;
    }
    if throat == 0.0 {
        return Some(Box::new(Minkowski { far_side: true }));
    }
    match Dneg::new(center, throat, long, width) {
        Ok(wormhole) => Some(Box::new(wormhole)),
        Err((name, cause)) => {
            p.reject(name, format!("`{name}` is out of range"), cause);
            None
        }
    }
}

/// A wormhole whose areal radius is `b0` along a cylinder and grows beyond it (`docs/physics.md`, section 8).
#[derive(Clone, Debug)]
pub struct Dneg {
    center: DVec3,
    throat: f64,
    /// Areal radius as a function of proper length, in units of the throat.
    profile: Profile,
    /// The index, in units of the throat.
    table: Arc<Table>,
    breaks: Arc<[f64]>,
}

impl Dneg {
    /// The wormhole with this centre of both charts, areal radius of the throat, whole length of the cylinder and lensing width, all lengths
    /// in scene units and above 0 but for the length of the cylinder, which may be 0.
    ///
    /// # Errors
    /// Which length cannot be drawn, by the name of its parameter, and why.
    pub fn new(center: DVec3, throat: f64, length: f64, lensing_width: f64) -> Result<Self, (&'static str, String)> {
        let (half, width) = (0.5 * length / throat, lensing_width / throat);
        let profile = Profile::new(half, width)?;
        let table = Table::new(&profile);
        // Where the cylinder ends, on this side and on the other.
        let (end, middle) = (profile.cylinder_end(), profile.throat());
        let breaks = if half > 0.0 { vec![throat * middle * middle / end, throat * end] } else { Vec::new() };
        Ok(Self { center, throat, profile, table: Arc::new(table), breaks: breaks.into() })
    }

    /// The chart radius (scene units) at the proper radial length `l` from the middle of the throat (scene units, not negative).
    pub fn chart_radius(&self, l: f64) -> f64 {
        self.throat * self.profile.chart_radius(l / self.throat)
    }

    /// `n^2` and half its gradient.
    #[inline(always)]
    fn index_of<F: Real>(&self, x: Vector<F>) -> (F, Vector<F>) {
        let scale = F::splat(1.0 / self.throat);
        let x = (x - Vector::all(self.center)) * scale;
        // The gradient of the square of the distance is 2 x.
        let (square, slope) = self.table.index(x.length_squared());
        (square, x * (slope * scale))
    }
}

impl Spacetime for Dneg {
    fn at(&self, place: Place) -> Option<Stationary> {
        let rho = (place.x - self.center).length();
        let n = self.index(place.x).0.sqrt();
        (rho >= self.throat * self.profile.throat() && n.is_finite())
            .then_some(Stationary { root: Stretch::isotropic(n), ..Stationary::FLAT })
    }

    fn captures(&self) -> Vec<Ball> {
        Vec::new()
    }

    fn class(&self) -> Class<'_> {
        Class::Index(self)
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn has_far_side(&self) -> bool {
        true
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(Self { center: self.center - origin, ..self.clone() })
    }
}

impl GradedIndex for Dneg {
    from_index_of!();

    fn throat(&self) -> Option<Throat> {
        Some(Throat { center: self.center, radius: self.throat * self.profile.throat() })
    }

    fn breaks(&self) -> &[f64] {
        &self.breaks
    }
}

impl Metric for Dneg {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        Fields::isotropic(Dual::constant(1.0), self.index_of(variables_of(x)).0)
    }
}
