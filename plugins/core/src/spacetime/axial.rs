//! What circular orbits need to know of a hole.

use super::{Class, Spacetime};
use bhs_elementary::Elementary;
use glam::DVec3;

/// A single round or spinning hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axial {
    /// Centre (chart).
    pub center: DVec3,
    /// Unit vector along the axis of the spin, by which space is dragged along `a axis x (x - center)`; `None` without spin.
    pub axis: Option<DVec3>,
    /// Mass (scene units).
    pub mass: f64,
    /// Angular momentum over mass (scene units), negative where the spin is.
    pub a: f64,
    /// Square of the charge, as a length (scene units^2).
    pub charge_squared: f64,
}

impl Axial {
    /// That of a spacetime, if it is one hole drawn with its areal radius or in the chart of Boyer and Lindquist.
    pub fn of<S: Spacetime + ?Sized>(spacetime: &S) -> Option<Self> {
        match spacetime.class() {
            Class::Spherical(hole) => {
                Some(Self { center: hole.center, axis: None, mass: 0.5 * hole.rs, a: 0.0, charge_squared: hole.charge_squared })
            }
            Class::Kerr(hole) => {
                let round = hole.round();
                let axis = (hole.a() != 0.0).then(|| hole.axis());
                let charge_squared = round.charge_squared;
                Some(Self { center: round.center, axis, mass: 0.5 * round.rs, a: hole.a(), charge_squared })
            }
            Class::Flat | Class::Index(_) | Class::General(_) => None,
        }
    }

    /// Boyer and Lindquist's radius, the areal one without spin, at the chart point `x` (scene units); `axis` is that of the spin, and any
    /// without.
    pub fn radius(&self, x: DVec3, axis: DVec3) -> f64 {
        let x = x - self.center;
        let (z, a2) = (axis.dot(x), self.a * self.a);
        let c = x.length_squared() - a2;
        let s = c.hypotenuse(2.0 * self.a * z);
        (if c > 0.0 { 0.5 * (c + s) } else { 2.0 * a2 * z * z / (s - c) }).sqrt()
    }

    /// The chart direction in which that radius grows fastest at `x`, while the polar angle stays: the unit normal of the ellipsoid.
    pub fn outward(&self, x: DVec3) -> DVec3 {
        let axis = self.axis.unwrap_or(DVec3::Y);
        let r = self.radius(x, axis);
        let x = x - self.center;
        // The gradient of (x^2 + y^2)/(r^2 + a^2) + z^2/r^2.
        let up = axis.dot(x);
        ((x - axis * up) / (r * r + self.a * self.a) + axis * (up / (r * r))).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kerr, Spherical};
    use super::*;

    #[test]
    fn radii_are_those_of_the_spacetime() {
        let round = Spherical { center: DVec3::new(1.0, -0.5, 2.0), rs: 2.0, charge_squared: 0.01 };
        let axis = DVec3::new(0.2, 0.9, -0.3).normalize();
        let kerr = Kerr::new(round, axis, -0.8);
        let axial = kerr.axial().unwrap();
        assert_eq!((axial.axis, axial.a, axial.mass, axial.charge_squared), (Some(axis), -0.8, 1.0, 0.01));
        for x in [DVec3::new(4.0, 1.0, -2.0), DVec3::new(1.3, 2.0, 2.2), DVec3::new(-7.0, 8.0, 3.0)] {
            assert!((axial.radius(x, axis) - kerr.radius(x)).abs() < 1e-13);
            assert_eq!(round.axial().unwrap().radius(x, axis), (x - round.center).length());
            let right = kerr.oblate::<f64>(x.into()).e_r;
            assert!((axial.outward(x) - DVec3::from(right)).length() < 1e-13);
            assert!((round.axial().unwrap().outward(x) - (x - round.center).normalize()).length() < 1e-15);
        }
    }
}
