//! What only orbits in planes have: rays around one round hole, in the chart of the areal radius.
//!
//! `plane` has the planes, `orbit` the equation and fixed steps, `series` its Taylor series, `steps` long steps by them with error control, of one ray or of eight side by side, `taylor` the same as an orbit,
//! `closed_form` an orbit without charge at any angle at once. These know no surfaces. `arc` makes curves of stretches of orbits; `course` leads
//! orbits along them, `exact` those in closed form. `connect` finds the rays between two points, `connections` offers them for light sampling.

pub mod arc;
pub mod closed_form;
pub mod connect;
pub mod connections;
pub mod course;
pub mod exact;
pub mod orbit;
pub mod plane;
pub(crate) mod series;
pub mod steps;
pub mod taylor;

use bhs_core::spacetime::Spherical;

/// What an orbit has to know of the hole that it goes around.
///
/// From the Schwarzschild radius of a hole without charge this is made by `into()`; what is computed with it then is the same to the bit as by
/// formulas without charge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attraction {
    /// Schwarzschild radius `2 M` (scene units).
    pub rs: f64,
    /// Square of the charge, as a length (scene units^2); at most `rs^2 / 4`.
    pub charge_squared: f64,
    /// 1/r on the outer horizon (1 / scene unit).
    pub horizon: f64,
    /// `1/b^2` of the light that winds around the hole for ever (1 / scene units^2).
    pub critical: f64,
}

impl Attraction {
    /// Whether there is a charge.
    #[inline(always)]
    pub fn is_charged(&self) -> bool {
        self.charge_squared != 0.0
    }

    /// `u''`
    #[inline(always)]
    pub fn force(&self, u: f64) -> f64 {
        let force = u * (1.5 * self.rs * u - 1.0);
        if self.is_charged() { force - 2.0 * self.charge_squared * u * u * u } else { force }
    }

    /// Derivative of `u''` by u.
    #[inline(always)]
    pub fn force_slope(&self, u: f64) -> f64 {
        let slope = 3.0 * self.rs * u - 1.0;
        if self.is_charged() { slope - 6.0 * self.charge_squared * u * u } else { slope }
    }

    /// `1/b^2 - u'^2`: what light must have of `1/b^2` to be at u.
    #[inline(always)]
    pub fn barrier(&self, u: f64) -> f64 {
        u * u * (1.0 - u * (self.rs - self.charge_squared * u))
    }

    /// 1/r on the sphere where light goes round (1 / scene unit).
    pub fn photon_sphere(&self) -> f64 {
        let m = 0.5 * self.rs;
        2.0 / (3.0 * m + (9.0 * m * m - 8.0 * self.charge_squared).sqrt())
    }
}

impl From<f64> for Attraction {
    #[inline(always)]
    fn from(rs: f64) -> Self {
        Self { rs, charge_squared: 0.0, horizon: 1.0 / rs, critical: 4.0 / (27.0 * rs * rs) }
    }
}

impl From<&Spherical> for Attraction {
    fn from(hole: &Spherical) -> Self {
        let &Spherical { rs, charge_squared, .. } = hole;
        if charge_squared == 0.0 {
            return rs.into();
        }
        let charged = Self { rs, charge_squared, horizon: 1.0 / hole.horizon(), critical: 0.0 };
        Self { critical: charged.barrier(charged.photon_sphere()), ..charged }
    }
}
