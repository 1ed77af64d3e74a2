//! Rays of any metric through a world of surfaces, with an affine parameter.

use crate::general::path::{Fate, Paths, Surroundings};
use crate::tracing::driver::{Course, Next};
use crate::tracing::extent::free_around;
use crate::tracing::polynomial_arc::{PolynomialArc, TERMS};
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Side, Spacetime};
use bhs_engine::world::World;
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
pub struct GeneralRay<'a> {
    /// Its steps; `None` if it begins where nothing can stand still.
    paths: Option<Paths<'a>>,
    surroundings: &'a Surroundings<'a>,
    depths: &'a Depths,
    piece: PolynomialArc<f64>,
    escaped: Option<DVec3>,
}

impl<'a> GeneralRay<'a> {
    /// The ray from `origin` on `side` along `launch`, with errors of about `error` times the distance from what is nearest, and what is told of the
    /// world.
    pub fn new(
        (surroundings, depths): (&'a Surroundings<'a>, &'a Depths),
        origin: DVec3,
        launch: DVec3,
        side: Side,
        error: f64,
    ) -> Self {
        let piece = PolynomialArc::new([Vector::from(DVec3::ZERO); TERMS], 0.0, 0.0);
        Self { paths: surroundings.start(origin, launch, side, error), surroundings, depths, piece, escaped: None }
    }

    fn parameter(&self) -> f64 {
        self.paths.as_ref().map_or(0.0, |paths| paths.lambda)
    }
}

impl Course<f64> for GeneralRay<'_> {
    type Piece = PolynomialArc<f64>;

    fn begin(&self) -> (bool, bool) {
        (self.paths.is_none(), false)
    }

    fn advance(&mut self, _: bool) -> Next<f64> {
        let mut next = Next { until: self.parameter(), crosses: false, escapes: false, falls: false, lost: false };
        let Some(paths) = &mut self.paths else { return Next { lost: true, ..next } };
        let advance = paths.advance();
        self.piece = advance.arc;
        match advance.fate {
            Fate::Underway => {}
            Fate::Crossed => next.crosses = true,
            Fate::Escaped(direction) => {
                self.escaped = Some(direction);
                next.escapes = true;
            }
            Fate::Lost => next.lost = true,
            Fate::Captured => {
                let x = DVec3::from(paths.light.x);
                let lapse_squared = self.surroundings.hamilton.lapse_squared(x);
                let at_horizon = lapse_squared < HORIZON || lapse_squared.is_nan();
                next.falls = at_horizon || self.depths.are_empty(x);
            }
        }
        Next { until: self.parameter(), ..next }
    }

    fn piece(&self) -> &PolynomialArc<f64> {
        &self.piece
    }

    fn directions(&mut self, which: bool, mut found: impl FnMut(usize, Option<DVec3>, f64)) {
        if which {
            found(0, self.escaped, self.parameter());
        }
    }
}
