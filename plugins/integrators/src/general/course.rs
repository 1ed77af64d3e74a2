//! Rays of any metric through a world of surfaces, with an affine parameter.

use crate::general::{Fate, Paths, Surroundings};
use crate::tracing::driver::{Course, Next};
use crate::tracing::extent::free_around;
use crate::tracing::polynomial_arc::PolynomialArc;
use bhs_core::spacetime::{Ball, Spacetime};
use bhs_core::world::World;
use glam::DVec3;

/// Where rays that fall may still be stopped.
#[derive(Clone, Debug)]
pub struct Depths {
    captures: Vec<Ball>,
    /// Around the centre of each, the distance within which nothing stands that could stop a ray.
    empty: Vec<f64>,
}

/// Within this share of a ball of no return nothing is looked for.
const DEEPEST: f64 = 1e-2;

/// How much farther from the centre a ray may come that falls, where the spheres of the distance are no spheres of the chart.
const MARGIN: f64 = 1.5;

/// Square of the lapse at which a ray has come so near to a horizon that it ends there.
const HORIZON: f64 = 1e-4;

impl Depths {
    /// Those of `world` in `spacetime`.
    pub fn new(world: &World, spacetime: &dyn Spacetime) -> Self {
        let captures = spacetime.captures();
        let empty = captures.iter().map(|b| free_around(world, b.center).max(DEEPEST * b.radius)).collect();
        Self { captures, empty }
    }

    /// Whether nothing can stop a ray any more that falls and is at `x`.
    fn are_empty(&self, x: DVec3) -> bool {
        let distance = |b: &Ball| (x - b.center).length();
        let nearest = self.captures.iter().zip(&self.empty).min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b)));
        nearest.is_none_or(|(ball, empty)| MARGIN * distance(ball) < *empty)
    }
}

/// A ray underway.
pub struct Ray<'a> {
    /// Its steps.
    pub paths: Paths<'a>,
    /// What it goes through.
    pub surroundings: &'a Surroundings<'a>,
    /// Where it may still be stopped.
    pub depths: &'a Depths,
}

impl Course for Ray<'_> {
    type Piece = PolynomialArc<f64>;

    fn advance(&mut self) -> (PolynomialArc<f64>, Next) {
        let advance = self.paths.advance();
        let next = match advance.fate {
            Fate::Underway => Next::GoesOn,
            Fate::Crossed => Next::Crosses,
            Fate::Escaped(direction) => Next::Escapes { direction, parameter: self.paths.lambda },
            Fate::Lost => Next::Lost,
            Fate::Captured => {
                let x = DVec3::from(self.paths.light.x);
                let lapse_squared = self.surroundings.hamilton.lapse_squared(x);
                let at_horizon = lapse_squared < HORIZON || lapse_squared.is_nan();
                if at_horizon || self.depths.are_empty(x) { Next::Falls } else { Next::GoesOn }
            }
        };
        (advance.arc, next)
    }
}
