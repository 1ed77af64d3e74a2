//! Lengths and angles of the orbits of camera rays. Where nothing bends light they are 0; around one hole, round or spinning, light has constants of
//! motion; in other spacetimes it has none.

use bhs_core::ray::Arrival;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Class, Kerr, Oblate, Place, Spherical};
use bhs_engine::layer::VisibleSurface;
use glam::DVec3;

/// What bends light.
#[derive(Clone, Copy)]
pub enum Bending {
    /// Nothing.
    Straight,
    /// A hole around which all orbits are plane.
    Hole(Spherical),
    /// A hole that spins.
    Spinning(Kerr),
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
            Class::Kerr(kerr) => Self::Spinning(kerr),
            _ => Self::Otherwise,
        }
    }
}

/// Angle swept around the hole (rad); around one that spins, of light from surfaces only.
pub fn swept_angle(seen: &VisibleSurface) -> Option<f64> {
    match (Bending::of(seen), seen.end.arrival) {
        (Bending::Straight, _) => Some(0.0),
        (Bending::Spinning(kerr), Arrival::Surface(_)) => {
            let scene = seen.scene;
            scene.integrator.swept_angle(&scene.world, &seen.ray, kerr.round().center)
        }
        (Bending::Otherwise | Bending::Spinning(_), _) | (_, Arrival::OutOfSteps) => None,
        (Bending::Hole(_), _) => Some(seen.end.swept),
    }
}

/// `b = r sin(alpha) / sqrt(1 - (1 - f(r)) sin^2(alpha))` with the chart angle alpha to the radial direction (scene units) and the square f
/// of the lapse: the orbit's first integral `u'^2 = 1/b^2 - u^2 f` with `u' = -cot(alpha)/r`.
pub(crate) fn round_impact_parameter(seen: &VisibleSurface, hole: &Spherical) -> f64 {
    let from_center = seen.ray.origin - hole.center;
    let r = from_center.length();
    let sin = from_center.cross(seen.ray.direction).length() / r;
    r * sin / (1.0 - (1.0 - hole.lapse_squared(r)) * sin * sin).sqrt()
}

/// The impact parameter b of the light that is seen (scene units): of an orbit in a plane `L/E`, around a hole that spins `sqrt(Q + L^2)`, and 0 where
/// that has no root, near the axis.
pub fn impact_parameter(seen: &VisibleSurface) -> Option<f64> {
    match Bending::of(seen) {
        Bending::Straight => Some(0.0),
        Bending::Hole(hole) => Some(round_impact_parameter(seen, &hole)),
        Bending::Spinning(_) => {
            let Constants { angular_momentum, carter } = Constants::of(seen)?;
            Some((carter + angular_momentum * angular_momentum).max(0.0).sqrt())
        }
        Bending::Otherwise => None,
    }
}

/// What light of energy 1 keeps on its way around a hole (`docs/physics.md`, section 5): that of the light which arrives, not of the ray that is followed
/// back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Constants {
    /// Angular momentum L about the axis, above 0 for light that moves along `axis x x` (scene units).
    pub angular_momentum: f64,
    /// Carter's Q (scene units^2).
    pub carter: f64,
}

impl Constants {
    /// Those of the light that is seen; 0 where nothing bends light, `None` where no single hole does.
    pub fn of(seen: &VisibleSurface) -> Option<Self> {
        let (center, axis, kerr) = match Bending::of(seen) {
            Bending::Straight => return Some(Self::default()),
            // The axis that everything turns about unless it says otherwise.
            Bending::Hole(hole) => (hole.center, DVec3::Y, None),
            Bending::Spinning(kerr) => (kerr.round().center, kerr.axis(), Some(kerr)),
            Bending::Otherwise => return None,
        };
        let (x, place) = (seen.ray.origin - center, Place { x: seen.ray.origin, side: seen.ray.side });
        let p = seen.scene.world.spacetime().light_step(place, -seen.ray.direction)?.momentum;
        // The chart drawn from the unit sphere of n: the point is `R` times what of n lies across the axis, and `r` times what lies along.
        let (n, across, along, a) = match kerr {
            Some(kerr) => {
                let Oblate { r, square, cos, across, .. } = kerr.oblate(Vector::from(place.x));
                (DVec3::from(across) + axis * cos, square.sqrt(), r, kerr.a())
            }
            None => (x.normalize(), x.length(), x.length(), 0.0),
        };
        let along_axis = axis * axis.dot(p);
        let on_sphere = (p - along_axis) * across + along_axis * along;
        let turning = n.cross(on_sphere);
        let angular_momentum = axis.dot(turning);
        let cos = axis.dot(n);
        // |n'|^2 = Q + L^2 + a^2 cos^2
        let carter = turning.length_squared() - angular_momentum * angular_momentum - a * a * cos * cos;
        Some(Self { angular_momentum, carter })
    }
}
