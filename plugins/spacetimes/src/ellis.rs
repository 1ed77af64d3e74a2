//! `ellis`: the wormhole of Ellis and Bronnikov. Each of its sides has an isotropic chart, with the same centre.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `center` | point3 | [0 0 0] | scene | centre, under the current transform |
//! | `throat` | float | required | scene | areal radius of the throat, under the current transform; it is drawn with half of it |

use crate::Minkowski;
use crate::graded::{from_index_of, variables_of};
use crate::placement::{Placement, center, in_range, length};
use bhs_core::Plugin;
use bhs_core::dual::Dual;
use bhs_core::params::Params;
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Ball, Class, Fields, GradedIndex, Metric, Place, Spacetime, Stationary, Stretch, Throat};
use glam::DVec3;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> =
    Plugin { name: "ellis", summary: "a wormhole without tidal surprises: the simplest passage to the far side", build };

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let center = center(p);
    let throat = length(p, "throat", "areal radius of the throat, under the current transform");
    let placement = Placement::of(p)?;
    let wormhole = Ellis { center: placement.point(center), throat: placement.length(throat?) };
    if !in_range(p, &[wormhole.center], &[wormhole.throat]) {
        return None;
    }
    Some(if wormhole.throat == 0.0 { Box::new(Minkowski { far_side: true }) } else { Box::new(wormhole) })
}

/// An Ellis wormhole, `r^2 = l^2 + b0^2` (`docs/physics.md`, section 7).
#[derive(Clone, Copy, Debug)]
pub struct Ellis {
    /// Centre of both charts (scene units).
    pub center: DVec3,
    /// Areal radius `b0` of the throat (scene units), above 0.
    pub throat: f64,
}

impl Ellis {
    /// `n^2` and half its gradient, with `n = 1 + b0^2 / (4 rho^2)`.
    #[inline(always)]
    fn index_of<F: Real>(&self, x: Vector<F>) -> (F, Vector<F>) {
        let x = x - Vector::all(self.center);
        let over = F::splat(1.0) / x.length_squared();
        let excess = over * F::splat(0.25 * self.throat * self.throat);
        let n = F::splat(1.0) + excess;
        // n dn/drho / rho
        let slope = -(n + n) * excess * over;
        (n * n, x * slope)
    }
}

impl Spacetime for Ellis {
    fn at(&self, place: Place) -> Option<Stationary> {
        let rho = (place.x - self.center).length();
        let n = self.index(place.x).0.sqrt();
        (rho >= 0.5 * self.throat && n.is_finite()).then_some(Stationary { root: Stretch::isotropic(n), ..Stationary::FLAT })
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
        Arc::new(Self { center: self.center - origin, ..*self })
    }
}

impl GradedIndex for Ellis {
    from_index_of!();

    fn throat(&self) -> Option<Throat> {
        Some(Throat { center: self.center, radius: 0.5 * self.throat })
    }
}

impl Metric for Ellis {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        Fields::isotropic(Dual::constant(1.0), self.index_of(variables_of(x)).0)
    }
}
