//! What rays of a refractive index have to be told of it.

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::Vectors;
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Ball, GradedIndex, Throat};
use glam::{DMat3, DVec3};

/// Numbers that an index can be asked with: one or eight.
pub trait Refracted: Real {
    /// `n^2` and half its gradient.
    fn index(of: &dyn GradedIndex, x: Vector<Self>) -> (Self, Vector<Self>);

    /// The columns of half the matrix of second derivatives of `n^2`.
    fn hessian(of: &dyn GradedIndex, x: Vector<Self>) -> [Vector<Self>; 3];
}

impl Refracted for f64 {
    #[inline(always)]
    fn index(of: &dyn GradedIndex, x: Vector<Self>) -> (Self, Vector<Self>) {
        let (square, gradient) = of.index(x.into());
        (square, gradient.into())
    }

    #[inline(always)]
    fn hessian(of: &dyn GradedIndex, x: Vector<Self>) -> [Vector<Self>; 3] {
        let DMat3 { x_axis, y_axis, z_axis } = of.hessian(x.into());
        [x_axis.into(), y_axis.into(), z_axis.into()]
    }
}

impl Refracted for Lanes {
    #[inline(always)]
    fn index(of: &dyn GradedIndex, x: Vectors) -> (Self, Vectors) {
        of.index_each(x)
    }

    #[inline(always)]
    fn hessian(of: &dyn GradedIndex, x: Vectors) -> [Vectors; 3] {
        let each: [DMat3; LANES] = std::array::from_fn(|i| of.hessian(x.lane(i)));
        [each.map(|m| m.x_axis), each.map(|m| m.y_axis), each.map(|m| m.z_axis)].map(Vectors::of)
    }
}

/// Beyond how many times the extent of all that bends light, its masses included, a ray that goes out is followed in the distance's inverse.
const FAR: f64 = 4.0;

/// Breaks nearer together than this are one, relative to their distance from the middle.
const SAME: f64 = 1e-9;

/// How far out an index is asked for the mass that it shows, over its extent.
const VERY_FAR: f64 = 1e6;

/// A refractive index, and where it is not smooth.
#[derive(Clone, Debug)]
pub struct Medium<'a> {
    /// The index.
    pub index: &'a dyn GradedIndex,
    /// Balls of which no light comes back that moves inwards there.
    pub captures: Vec<Ball>,
    /// The passage to the other side.
    pub throat: Option<Throat>,
    /// Distances from the centre of the throat at which a derivative of the index jumps, or does so in the mirror of the throat.
    pub breaks: Vec<f64>,
    /// The middle of all that bends light.
    pub center: DVec3,
    /// Distance from there beyond which the index is that of a mass in the middle with small corrections.
    pub far: f64,
}

impl<'a> Medium<'a> {
    /// The index `index`, whose holes are in `captures`.
    pub fn new(index: &'a dyn GradedIndex, captures: Vec<Ball>) -> Self {
        let throat = index.throat();
        let mut breaks = index.breaks().to_vec();
        if let Some(Throat { radius, .. }) = throat {
            breaks.extend(index.breaks().iter().map(|b| radius * radius / b));
        }
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| *a - *b <= SAME * *b);
        let center = match throat {
            Some(throat) => throat.center,
            None => captures.iter().map(|b| b.center).sum::<DVec3>() / captures.len().max(1) as f64,
        };
        let of_hole = |b: &Ball| (b.center - center).length() + b.radius;
        let of_throat = throat.map_or(0.0, |t| index.breaks().iter().copied().fold(t.radius, f64::max));
        let extent = captures.iter().map(of_hole).fold(of_throat, f64::max);
        // n^2 = 1 + 4 M / r + ...
        let r = VERY_FAR * if extent > 0.0 { extent } else { 1.0 };
        let mass = 0.25 * (index.index(center + DVec3::X * r).0 - 1.0).abs() * r;
        Self { index, captures, throat, breaks, center, far: FAR * (extent + mass) }
    }

    /// The squared index and the acceleration at `x`.
    #[inline(always)]
    pub fn at<F: Refracted>(&self, x: Vector<F>) -> (F, Vector<F>) {
        F::index(self.index, x)
    }

    /// Distance from the nearest hole or from the middle of the throat: what errors of positions are measured by.
    #[inline(always)]
    pub fn scale<F: Real>(&self, x: Vector<F>) -> F {
        let to = |center: DVec3| (x - Vector::all(center)).length_squared();
        let mut nearest = match (self.captures.first(), self.throat) {
            (Some(hole), None) => to(hole.center),
            _ => to(self.center),
        };
        for hole in self.captures.iter().skip(1) {
            nearest = nearest.min(to(hole.center));
        }
        nearest.sqrt().max(F::splat(f64::MIN_POSITIVE))
    }
}
