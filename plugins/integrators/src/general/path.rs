//! Rays of any metric, step by step, with error control.

use crate::arithmetic::dormand_prince::{error, step};
use crate::arithmetic::root::root;
use crate::arithmetic::space::Space;
use crate::general::escape;
use crate::general::hamilton::{Hamilton, Light};
use crate::tracing::arc::Arc;
use crate::tracing::polynomial_arc::{PolynomialArc, TERMS};
use bhs_core::dual::Dual;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Side, Spacetime, Throat};
use bhs_elementary::Elementary;
use glam::DVec3;

/// Beyond how many times the extent of all that bends light, its masses included, a ray that goes out is taken to leave for ever.
const FAR: f64 = 4.0;

/// How far out a metric is asked for the mass that it shows, over its extent.
const VERY_FAR: f64 = 1e6;

/// A mass of so many times the extent is none: space is not flat far away.
const LARGEST_MASS: f64 = 1e3;

/// How far rays are followed where space is not flat far away, over where they leave what is known of it.
const WHERE_NOT_FLAT: f64 = 1e3;

/// Least length that steps are measured by where there is no hole, over the size of what bends light.
const LEAST_SCALE: f64 = 1e-3;

/// Square of the lapse at which a ray that moves inwards is taken to have reached the horizon.
const HORIZON: f64 = 1e-4;

/// Attempts at one step.
const ATTEMPTS: u32 = 60;

/// What rays of a metric have to be told besides it.
#[derive(Clone, Debug)]
pub struct Surroundings<'a> {
    /// The metric and the direction of time.
    pub hamilton: Hamilton<'a>,
    captures: Vec<Ball>,
    throat: Option<Throat>,
    center: DVec3,
    extent: f64,
    /// Distance from the centre beyond which nothing is.
    limit: f64,
    /// Least length that steps are measured by.
    smooth: f64,
    flat_far_away: bool,
}

impl<'a> Surroundings<'a> {
    /// Those of `spacetime`, through which nothing can be met outside of the ball `reach`; rays lead `backward` to where light comes from, or
    /// forward. `throat` is its passage to the other side.
    pub fn new(spacetime: &'a dyn Spacetime, throat: Option<Throat>, backward: bool, reach: Ball) -> Self {
        let hamilton = Hamilton { metric: spacetime.metric(), backward };
        let captures = spacetime.captures();
        let bends = spacetime.bends();
        let center = match (throat, bends) {
            (Some(throat), _) => throat.center,
            (None, Some(ball)) => ball.center,
            // Nothing says where it is: perhaps among the surfaces.
            (None, None) if captures.is_empty() => reach.center,
            (None, None) => captures.iter().map(|b| b.center).sum::<DVec3>() / captures.len() as f64,
        };
        let size = captures.iter().map(|b| (b.center - center).length() + b.radius);
        let size = size.fold(throat.map_or(0.0, |t| t.radius).max(bends.map_or(0.0, |b| b.radius)), f64::max);
        let smooth = bends.map_or(f64::MIN_POSITIVE, |b| b.radius);
        let size = match (size > 0.0, reach.radius > 0.0) {
            (true, _) => size,
            (false, true) => reach.radius,
            // Nor is there anything to measure it by.
            (false, false) => 1.0,
        };
        let smooth = if captures.is_empty() && throat.is_none() { smooth.max(LEAST_SCALE * size) } else { smooth };
        // N^2 = 1 - 2 M / r + ..., and gamma is like that.
        let r = VERY_FAR * size;
        let fields = hamilton.metric.fields(Dual::variables(center + DVec3::X * r));
        let mass = 0.5 * r * (fields.lapse_squared.value - 1.0).abs().max((fields.gamma[0].value - 1.0).abs());
        let flat_far_away = mass < LARGEST_MASS * size;
        let extent = if flat_far_away { size + mass } else { size };
        let limit = (FAR * extent).max((reach.center - center).length() + reach.radius);
        Self { hamilton, captures, throat, center, extent, limit, smooth, flat_far_away }
    }

    /// The ray from `x` on `side` along the chart direction `d`, with errors of about `tolerance` times the distance from the nearest hole;
    /// `None` where nothing can stand still.
    pub fn start(&'a self, x: DVec3, d: DVec3, side: Side, tolerance: f64) -> Option<Paths<'a>> {
        let light = self.hamilton.start(x, d)?;
        let slope = self.hamilton.slope(light);
        let share = tolerance.power(0.125);
        let usable = slope.x.length().is_finite();
        usable.then_some(Paths { surroundings: self, light, slope, lambda: 0.0, side, share, tolerance, counts: [0; 2] })
    }

    /// The middle of all that bends light.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    fn scale(&self, x: Vector<f64>) -> f64 {
        let to = |center: DVec3| (DVec3::from(x) - center).length();
        let nearest = self.captures.iter().map(|b| to(b.center)).fold(f64::INFINITY, f64::min);
        if nearest.is_finite() { nearest } else { to(self.center) }.max(self.smooth)
    }
}

/// How a ray goes on after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It can be followed further.
    Underway,
    /// It goes on on the other side of the throat, on which the step ends.
    Crossed,
    /// It leaves in this direction; the side is [`Paths::side`].
    Escaped(DVec3),
    /// It falls into a hole.
    Captured,
    /// No step is short enough.
    Lost,
}

/// A step, and how the ray goes on.
#[derive(Clone, Copy, Debug)]
pub struct Advance {
    /// The curve of the step, in the chart of the side where it began.
    pub arc: PolynomialArc<f64>,
    /// How the ray goes on.
    pub fate: Fate,
}

/// A ray underway.
#[derive(Clone, Debug)]
pub struct Paths<'a> {
    surroundings: &'a Surroundings<'a>,
    /// Where it is.
    pub light: Light,
    slope: Light,
    /// The affine parameter (scene units).
    pub lambda: f64,
    /// The side on which it is.
    pub side: Side,
    /// Length of the next step over the distance from what is nearest.
    share: f64,
    tolerance: f64,
    /// Steps, attempts of them.
    pub counts: [u32; 2],
}

impl Paths<'_> {
    /// One step.
    pub fn advance(&mut self) -> Advance {
        let nothing = PolynomialArc::new([Vector::from(DVec3::ZERO); TERMS], self.lambda, 0.0);
        if let Some(direction) = self.leaves() {
            return Advance { arc: nothing, fate: Fate::Escaped(direction) };
        }
        self.counts[0] += 1;
        let hamilton = self.surroundings.hamilton;
        let f = |y| hamilton.slope(y);
        let scale = self.surroundings.scale(self.light.x);
        let per_share = scale / self.slope.x.length();
        let tolerance = self.tolerance * self.blur();
        for _ in 0..ATTEMPTS {
            self.counts[1] += 1;
            let h = self.share * per_share;
            let tried = step(f, self.light, self.slope, h);
            let p = self.light.p.length();
            let errors = tried.errors.map(|e| (e.x.length() / scale).max(e.p.length() / p));
            let failure = error(errors) / tolerance;
            let factor = (0.85 * failure.max(1e-8).power(-0.125)).clamp(0.2, 5.0);
            self.share *= if factor.is_nan() { 0.2 } else { factor };
            if failure <= 1.0 {
                let dense = tried.dense(f, h);
                let mut c = [Vector::from(DVec3::ZERO); TERMS];
                for (c, term) in c.iter_mut().zip(&dense) {
                    *c = term.x;
                }
                let arc = PolynomialArc::new(c, self.lambda, h);
                let before = self.light;
                (self.light, self.slope) = (tried.end, tried.slope());
                return self.finish(arc, &before, &dense);
            }
        }
        Advance { arc: nothing, fate: Fate::Lost }
    }

    /// How much less than elsewhere is asked for of a ray that is about to reach a horizon, where its momentum has no limit, and rounding errors
    /// with it.
    fn blur(&self) -> f64 {
        let (x, d) = (DVec3::from(self.light.x), DVec3::from(self.slope.x));
        let inwards = (x - self.surroundings.center).dot(d) < 0.0;
        if inwards { 1.0 + 0.01 / self.surroundings.hamilton.lapse_squared(x).max(HORIZON) } else { 1.0 }
    }

    fn finish(&mut self, arc: PolynomialArc<f64>, before: &Light, dense: &[Light]) -> Advance {
        let around = self.surroundings;
        if let Some(throat) = around.throat {
            let from_center = |x: Vector<f64>| DVec3::from(x) - throat.center;
            let inside = |x| from_center(x).length() < throat.radius;
            let inwards = from_center(before.x).dot(around.hamilton.slope(*before).x.into()) < 0.0;
            if inside(self.light.x) && (inwards || !inside(before.x)) {
                return self.turn(&throat, arc, dense);
            }
        }
        self.lambda = arc.end();
        let fate = if self.falls() { Fate::Captured } else { Fate::Underway };
        Advance { arc, fate }
    }

    /// Ends the step on the throat.
    fn turn(&mut self, throat: &Throat, arc: PolynomialArc<f64>, dense: &[Light]) -> Advance {
        let off = |s: f64| (DVec3::from(arc.point(s)) - throat.center).length() - throat.radius;
        let s = if off(arc.start()) <= 0.0 { arc.start() } else { root(off, arc.start(), arc.end(), false) };
        let share = (s - arc.start()) / (arc.end() - arc.start());
        let at = dense.iter().rev().copied().reduce(|sum, c| c.plus(sum, share)).expect("a polynomial has terms");
        let x = throat.center + (DVec3::from(at.x) - throat.center).normalize() * throat.radius;
        self.light = Light { x: x.into(), p: throat.turned(x, at.p.into()).into(), t: at.t };
        self.slope = self.surroundings.hamilton.slope(self.light);
        (self.lambda, self.side) = (s, self.side.other());
        Advance { arc: arc.until(s), fate: Fate::Crossed }
    }

    /// Whether the ray falls into a hole.
    fn falls(&self) -> bool {
        let around = self.surroundings;
        let (x, d) = (DVec3::from(self.light.x), DVec3::from(self.slope.x));
        let into = |b: &Ball| (x - b.center).length() < b.radius && (x - b.center).dot(d) < 0.0;
        let lapse = around.hamilton.lapse_squared(x);
        around.captures.iter().any(into)
            || around.hamilton.metric.swallows(x, d)
            || ((lapse < HORIZON || lapse.is_nan()) && (x - around.center).dot(d) < 0.0)
    }

    /// The direction in which the ray leaves, if it does.
    fn leaves(&self) -> Option<DVec3> {
        let around = self.surroundings;
        let (x, d) = (DVec3::from(self.light.x), DVec3::from(self.slope.x));
        let from_center = x - around.center;
        let r = from_center.length();
        if r <= around.limit || from_center.dot(d) <= 0.0 {
            return None;
        }
        if around.flat_far_away {
            return escape::direction(&around.hamilton, &self.light, around.center, around.extent, self.tolerance);
        }
        let gone = r > WHERE_NOT_FLAT * around.limit || around.hamilton.lapse_squared(x) < HORIZON;
        gone.then(|| d.normalize())
    }
}
