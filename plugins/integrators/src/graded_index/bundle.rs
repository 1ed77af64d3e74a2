//! How rays spread: neighbours of a ray of a refractive index, in the first order.
//!
//! With `J` the derivative of the ray's points by an angle of its launch, `J'' = (grad grad n^2 / 2) J`, `J(0) = 0`, `J'(0) = n e`.

use crate::graded_index::medium::{Medium, Refracted};
use crate::graded_index::nystroem::{State, step};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::Throat;

/// Rays with two neighbours each, launched aside at right angles to them and to each other. They are to be led along the steps of
/// [`crate::graded_index::path::Paths`], whose lengths are right for them as well.
#[derive(Clone, Copy, Debug)]
pub struct Bundle<F: Real> {
    /// Points, and their derivatives by both angles.
    state: State<[Vector<F>; 3]>,
}

impl<F: Refracted> Bundle<F> {
    /// The bundles of rays at `ray`, which begin there.
    pub fn new(medium: &Medium<'_>, ray: &State<Vector<F>>) -> Self {
        let zero = ray.x * F::splat(0.0);
        let n = ray.v.length();
        let aside: Vec<_> = (0..F::COUNT).map(|i| ray.v.lane(i).normalize().any_orthonormal_pair()).collect();
        let [first, second] = [Vector::from_fn(|i| aside[i].0), Vector::from_fn(|i| aside[i].1)];
        let x = [ray.x, zero, zero];
        Self { state: State { x, v: [ray.v, first * n, second * n], a: force(medium, x, ray.x) } }
    }

    /// The bundles further on by `h` in the parameter, within one step of the rays.
    #[inline(always)]
    #[must_use]
    pub fn after(&self, medium: &Medium<'_>, h: F) -> Self {
        let State { x, v, .. } = self.state;
        // Ends of steps may lie on a break of the medium, where second derivatives jump and belong to the step on this side of it only.
        let middle = x[0].plus(v[0], F::splat(0.5) * h);
        let inside = |x: Vector<F>| x.plus(middle - x, F::splat(INSIDE));
        let start = State { a: force(medium, x, inside(x[0])), ..self.state };
        Self { state: step(|x| force(medium, x, inside(x[0])), &start, h).end }
    }

    /// The bundles of the rays `which`, which are on the throat, on the other side of it; the others as they are.
    #[must_use]
    pub fn through(&self, medium: &Medium<'_>, throat: &Throat, which: F::Mask) -> Self {
        let c = F::splat;
        let center = Vector::all(throat.center);
        let [x, neighbors @ ..] = self.state.x;
        let [v, slopes @ ..] = self.state.v;
        // The inversion x -> R^2 x / |x|^2 where |x| = R: its derivative is a reflection; and its second derivative.
        let from_center = x - center;
        let over = c(1.0) / from_center.length_squared();
        let reflected = |d: Vector<F>| d.plus(from_center, c(-2.0) * from_center.dot(d) * over);
        let second = |a: Vector<F>, b: Vector<F>| {
            let (xa, xb, ab) = (from_center.dot(a) * over, from_center.dot(b) * over, a.dot(b) * over);
            (from_center * (c(8.0) * xa * xb - c(2.0) * ab)).plus(a, c(-2.0) * xb).plus(b, c(-2.0) * xa)
        };
        let mut state = self.state;
        (state.x[0], state.v[0]) = (x, reflected(v));
        for i in 0..2 {
            let j = neighbors[i];
            // The parameter of a neighbour, which is not on the throat, runs at another pace: as n^2 of both sides.
            let pace = c(4.0) * from_center.dot(j) * over;
            state.x[i + 1] = reflected(j);
            state.v[i + 1] = (reflected(slopes[i]) + second(j, v)).plus(reflected(v), pace);
        }
        state.a = force(medium, state.x, x);
        Self { state: state.or(&self.state, which) }
    }

    /// Area across the ray over solid angle of its launch, in the chart: in flat space, the square of the distance.
    #[inline(always)]
    pub fn spread(&self) -> F {
        let [_, a, b] = self.state.x;
        let v = self.state.v[0];
        (a.cross(b).dot(v)).abs() / v.length()
    }

    /// Derivatives of the points by the angles (rad) of launches aside, as [`Bundle::new`] has chosen the two directions:
    /// `any_orthonormal_pair` of the launch.
    pub fn aside(&self) -> [Vector<F>; 2] {
        let [_, a, b] = self.state.x;
        [a, b]
    }

    /// The points that the bundles are at.
    pub fn points(&self) -> Vector<F> {
        self.state.x[0]
    }
}

/// How far inside of a step second derivatives are asked for, as a share of the way to its middle.
const INSIDE: f64 = 1e-6;

/// Acceleration at a point, and what neighbours have of it, with the second derivatives at the point `at`.
#[inline(always)]
fn force<F: Refracted>(medium: &Medium<'_>, [x, a, b]: [Vector<F>; 3], at: Vector<F>) -> [Vector<F>; 3] {
    let [c0, c1, c2] = F::hessian(medium.index, at);
    let along = |j: Vector<F>| (c0 * j.x).plus(c1, j.y).plus(c2, j.z);
    [medium.at(x).1, along(a), along(b)]
}
