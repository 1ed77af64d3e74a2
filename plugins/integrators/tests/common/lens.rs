//! A spacetime that gives its metric and has no hole: a smooth lens.

use bhs_core::dual::Dual;
use bhs_core::spacetime::{Ball, Class, Fields, Metric, Place, Side, Spacetime, Stationary, stationary};
use glam::DVec3;
use std::sync::Arc;

/// `N = exp(-a g)`, `gamma = 1/N^2`, `g = exp(-r^2 / (2 w^2))`: light has the refractive index `exp(2 a g)`.
#[derive(Clone, Copy, Debug)]
pub struct GaussianLens {
    pub center: DVec3,
    /// a
    pub strength: f64,
    /// w (scene units)
    pub width: f64,
}

impl Spacetime for GaussianLens {
    fn at(&self, place: Place) -> Option<Stationary> {
        if place.side == Side::Far { None } else { stationary(self, place.x) }
    }

    fn captures(&self) -> Vec<Ball> {
        Vec::new()
    }

    fn bends(&self) -> Option<Ball> {
        Some(Ball { center: self.center, radius: self.width })
    }

    fn class(&self) -> Class<'_> {
        Class::General(self)
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(Self { center: self.center - origin, ..*self })
    }
}

impl Metric for GaussianLens {
    fn fields(&self, [x, y, z]: [Dual; 3]) -> Fields {
        let [x, y, z] = [x - self.center.x, y - self.center.y, z - self.center.z];
        let bump = (-0.5 / (self.width * self.width) * (x * x + y * y + z * z)).exp();
        let lapse_squared = (-2.0 * self.strength * bump).exp();
        Fields::isotropic(lapse_squared, lapse_squared.recip())
    }
}
