//! Rays of a refractive index through a world of surfaces.

use crate::graded_index::medium::Medium;
use crate::graded_index::path::Paths;
use crate::tracing::driver::{Course, Next};
use crate::tracing::extent::{Extent, free_around};
use crate::tracing::polynomial_arc::PolynomialArc;
use bhs_core::spacetime::{Ball, GradedIndex, Side, Spacetime};
use bhs_core::world::World;
use glam::DVec3;

/// What is told once of a world through which many rays of a refractive index are to be followed.
#[derive(Clone, Debug)]
pub struct Setting<'w> {
    /// The index.
    pub medium: Medium<'w>,
    /// Where surfaces are.
    pub extent: Extent,
    /// Around the hole of each ball of no return, the distance within which nothing stands that could stop a ray.
    empty: Vec<f64>,
}

/// Share of a ball of no return within which nothing is looked for.
const DEEPEST: f64 = 1e-3;

impl<'w> Setting<'w> {
    /// The surfaces of `world` in `spacetime`, whose index is `index`.
    pub fn new(world: &World, spacetime: &'w dyn Spacetime, index: &'w dyn GradedIndex) -> Self {
        let captures = spacetime.captures();
        let empty = captures.iter().map(|b| free_around(world, b.center).max(DEEPEST * b.radius)).collect();
        Self { medium: Medium::new(index, captures), extent: Extent::of(world), empty }
    }

    /// The ray from `x` on `side` along `d`, with errors of about `error` times the distance from what bends it.
    pub fn ray(&self, x: DVec3, d: DVec3, side: Side, error: f64) -> Ray<'_> {
        let far_side = u32::from(side == Side::Far);
        Ray { paths: Paths::new(&self.medium, x.into(), d.into(), far_side, error, self.extent.reach), setting: self }
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

/// A ray underway, in the parameter sigma, in which `|dx/dsigma| = n`.
#[derive(Clone, Debug)]
pub struct Ray<'a> {
    paths: Paths<'a, f64>,
    setting: &'a Setting<'a>,
}

impl Ray<'_> {
    /// The same by the classic Runge-Kutta method, with steps of the length `step` as seen from what is nearest (rad).
    #[must_use]
    pub fn by_runge_kutta(self, step: f64) -> Self {
        Self { paths: self.paths.by_runge_kutta(step), ..self }
    }
}

impl Course for Ray<'_> {
    type Piece = PolynomialArc<f64>;

    fn advance(&mut self) -> (PolynomialArc<f64>, Next) {
        let advance = self.paths.advance(true);
        let next = if advance.escaped {
            match self.paths.directions(true) {
                (direction, true) => Next::Escapes { direction: direction.into(), parameter: self.paths.sigma },
                (_, false) => Next::Lost,
            }
        } else if advance.lost {
            Next::Lost
        } else if advance.crossed {
            Next::Crosses
        } else if advance.captured && self.setting.falls(self.paths.state.x.into(), self.paths.state.v.into()) {
            Next::Falls
        } else {
            Next::GoesOn
        };
        (advance.arc, next)
    }
}
