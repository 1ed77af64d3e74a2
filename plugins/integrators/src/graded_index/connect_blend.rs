//! Indices between two others: for rays that are found by continuation.

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::Real;
use bhs_core::real::Vectors;
use bhs_core::spacetime::GradedIndex;
use glam::{DMat3, DVec3};

/// Flat space with one extremal hole, or without: `n^2 = (1 + mass / rho)^4`.
#[derive(Clone, Copy, Debug)]
pub struct Single {
    /// Centre of the hole (scene units).
    pub center: DVec3,
    /// Its mass (scene units); 0 for flat space.
    pub mass: f64,
}

impl Single {
    /// `U = 1 + mass / rho`, `1 / rho`.
    fn potential(&self, from_center: DVec3) -> (f64, f64) {
        let over = 1.0 / from_center.length().max(f64::MIN_POSITIVE);
        (self.mass.mul_add(over, 1.0), over)
    }
}

impl GradedIndex for Single {
    fn index(&self, x: DVec3) -> (f64, DVec3) {
        if self.mass == 0.0 {
            return (1.0, DVec3::ZERO);
        }
        let x = x - self.center;
        let (u, over) = self.potential(x);
        (u.powi(4), x * (-2.0 * u.powi(3) * self.mass * over.powi(3)))
    }

    fn index_each(&self, x: Vectors) -> (Lanes, Vectors) {
        each(x, |x| self.index(x))
    }

    fn hessian(&self, x: DVec3) -> DMat3 {
        if self.mass == 0.0 {
            return DMat3::ZERO;
        }
        let x = x - self.center;
        let (u, over) = self.potential(x);
        // With the gradient g x: g 1 + x grad g.
        let c = 2.0 * self.mass * u * u * over.powi(3);
        let outer = DMat3::from_cols(x * x.x, x * x.y, x * x.z);
        outer * (3.0 * c * over * over * (u + self.mass * over)) - DMat3::IDENTITY * (c * u)
    }
}

/// The index whose square is that of `start` at `share` = 0, that of `end` at 1, and in between in proportion.
#[derive(Clone, Copy, Debug)]
pub struct Blend<'a> {
    /// Where it begins.
    pub start: Single,
    /// Where it ends.
    pub end: &'a dyn GradedIndex,
    /// How far it is.
    pub share: f64,
}

impl GradedIndex for Blend<'_> {
    fn index(&self, x: DVec3) -> (f64, DVec3) {
        let ((a, g), (b, h)) = (self.start.index(x), self.end.index(x));
        (a + self.share * (b - a), g + self.share * (h - g))
    }

    fn index_each(&self, x: Vectors) -> (Lanes, Vectors) {
        each(x, |x| self.index(x))
    }

    fn hessian(&self, x: DVec3) -> DMat3 {
        self.start.hessian(x) * (1.0 - self.share) + self.end.hessian(x) * self.share
    }
}

fn each(x: Vectors, index: impl Fn(DVec3) -> (f64, DVec3)) -> (Lanes, Vectors) {
    let each: [(f64, DVec3); LANES] = std::array::from_fn(|i| index(x.lane(i)));
    (Lanes::from_fn(|i| each[i].0), Vectors::of(each.map(|e| e.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::spacetime::{Class, Spacetime};
    use bhs_spacetimes::{Hole, MajumdarPapapetrou};

    #[test]
    fn one_hole_is_one_of_several_without_the_others() {
        let (center, mass) = (DVec3::new(0.3, -0.2, 0.1), 0.7);
        let holes = MajumdarPapapetrou::new(&[Hole { center, mass }]);
        let Class::Index(right) = holes.class() else { panic!() };
        let single = Single { center, mass };
        for x in [DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.4, 0.1, 0.6)] {
            let ((a, g), (b, h)) = (single.index(x), right.index(x));
            assert!((a / b - 1.0).abs() < 1e-13 && (g - h).length() < 1e-13 * h.length());
            let (a, b) = (single.hessian(x), right.hessian(x));
            assert!((a - b).to_cols_array().iter().all(|off| off.abs() < 1e-12 * b.x_axis.length()), "{a} {b}");
        }
    }
}
