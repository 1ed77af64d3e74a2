//! GradedRays of a refractive index through a world of surfaces.

use crate::graded_index::medium::{Medium, Refracted};
use crate::graded_index::nystroem::State;
use crate::graded_index::path::Paths;
use crate::tracing::driver::{Course, Next};
use crate::tracing::extent::{Extent, free_around};
use crate::tracing::polynomial_arc::{PolynomialArc, TERMS};
use bhs_core::lanes::set_bits;
use bhs_core::real::{Mask, Vector};
use bhs_core::spacetime::{Ball, GradedIndex, Spacetime};
use bhs_engine::world::World;
use glam::DVec3;

/// What is told once of a world through which many rays of a refractive index are to be followed.
#[derive(Clone, Debug)]
pub struct GradedSetup<'w> {
    /// The index.
    pub medium: Medium<'w>,
    /// Where surfaces are.
    pub extent: Extent,
    /// Around the hole of each ball of no return, the distance within which nothing stands that could stop a ray.
    empty: Vec<f64>,
}

/// Share of a ball of no return within which nothing is looked for.
const DEEPEST: f64 = 1e-3;

impl<'w> GradedSetup<'w> {
    /// The surfaces of `world` in `spacetime`, whose index is `index`.
    pub fn new(world: &World, spacetime: &'w dyn Spacetime, index: &'w dyn GradedIndex) -> Self {
        let captures = spacetime.captures();
        let empty = captures.iter().map(|b| free_around(world, b.center).max(DEEPEST * b.radius)).collect();
        Self { medium: Medium::new(index, captures), extent: Extent::of(world), empty }
    }

    /// The rays from the points `x` of the sides `far_side` (bits) in the directions `d`, with errors of about `error` times the distance from what
    /// bends them.
    pub fn rays<F: Refracted>(&self, x: Vector<F>, d: Vector<F>, far_side: u32, error: F) -> GradedRays<'_, F> {
        let paths = Paths::new(&self.medium, x, d, far_side, error, self.extent.reach);
        let zero = F::splat(0.0);
        let piece = PolynomialArc::new([Vector::all(DVec3::ZERO); TERMS], zero, zero);
        GradedRays { paths, setting: self, piece }
    }

    /// Whether a ray at `x` along `d` that comes no more out of a ball of no return has nothing before it that could stop it.
    fn falls(&self, x: DVec3, d: DVec3) -> bool {
        let falls = |(ball, empty): (&Ball, &f64)| {
            let from_center = x - ball.center;
            let distance = from_center.length();
            distance < ball.radius && distance < *empty && from_center.dot(d) < 0.0
        };
        self.medium.captures.iter().zip(&self.empty).any(falls)
    }
}

/// GradedRays underway, in the parameter sigma, in which `|dx/dsigma| = n`.
#[derive(Clone, Debug)]
pub struct GradedRays<'a, F: Refracted> {
    paths: Paths<'a, F>,
    setting: &'a GradedSetup<'a>,
    piece: PolynomialArc<F>,
}

impl<F: Refracted> GradedRays<'_, F> {
    /// The same by the classic Runge-Kutta method, with steps of the length `step` as seen from what is nearest (rad).
    #[must_use]
    pub fn by_runge_kutta(self, step: f64) -> Self {
        Self { paths: self.paths.by_runge_kutta(step), ..self }
    }
}

impl<F: Refracted> Course<F> for GradedRays<'_, F> {
    type Piece = PolynomialArc<F>;

    fn advance(&mut self, which: F::Mask) -> Next<F> {
        let advance = self.paths.advance(which);
        self.piece = advance.arc;
        let State { x, v, .. } = self.paths.state;
        let mut falls = 0;
        for i in set_bits(advance.captured.bits()) {
            falls |= u32::from(self.setting.falls(x.lane(i), v.lane(i))) << i;
        }
        Next {
            until: self.paths.sigma,
            crosses: advance.crossed,
            escapes: advance.escaped,
            falls: F::Mask::of_bits(falls) & !(advance.escaped | advance.lost | advance.crossed),
            lost: advance.lost & !advance.escaped,
        }
    }

    fn piece(&self) -> &PolynomialArc<F> {
        &self.piece
    }

    fn directions(&mut self, which: F::Mask, mut found: impl FnMut(usize, Option<DVec3>, f64)) {
        let (directions, right) = self.paths.directions(which);
        for i in set_bits(which.bits()) {
            let is_right = right.bits() >> i & 1 == 1;
            found(i, is_right.then(|| directions.lane(i)), self.paths.sigma.lane(i));
        }
    }
}
