//! Lengths and angles of the orbits of camera rays. Where nothing bends light they are 0; where orbits are not plane they have none.

use bhs_core::ray::Arrival;
use bhs_core::spacetime::{Class, Spherical};
use bhs_engine::layer::VisibleSurface;

/// What bends light.
#[derive(Clone, Copy)]
pub enum Bending {
    /// Nothing.
    Straight,
    /// A hole around which all orbits are plane.
    Hole(Spherical),
    /// Another spacetime.
    Otherwise,
}

impl Bending {
    /// What bends the light that is seen.
    #[inline]
    pub fn of(seen: &VisibleSurface) -> Self {
        match seen.scene.world.spacetime().class() {
            Class::Flat => Self::Straight,
            Class::Spherical(hole) => Self::Hole(hole),
            _ => Self::Otherwise,
        }
    }
}

/// Angle swept around the hole (rad).
pub fn swept_angle(seen: &VisibleSurface) -> Option<f64> {
    match (Bending::of(seen), seen.end.arrival) {
        (Bending::Straight, _) => Some(0.0),
        (Bending::Otherwise, _) | (_, Arrival::OutOfSteps) => None,
        (Bending::Hole(_), _) => Some(seen.end.swept),
    }
}

/// `b = r sin(alpha) / sqrt(1 - (1 - f(r)) sin^2(alpha))` with the chart angle alpha to the radial direction (scene units) and the square f
/// of the lapse: the orbit's first integral `u'^2 = 1/b^2 - u^2 f` with `u' = -cot(alpha)/r`.
pub fn impact_parameter(seen: &VisibleSurface, hole: &Spherical) -> f64 {
    let from_center = seen.ray.origin - hole.center;
    let r = from_center.length();
    let sin = from_center.cross(seen.ray.direction).length() / r;
    r * sin / (1.0 - (1.0 - hole.lapse_squared(r)) * sin * sin).sqrt()
}
