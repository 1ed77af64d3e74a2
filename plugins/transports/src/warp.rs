//! A distribution over the unit square, constant on the squares of a grid: what directions are drawn from where a guide knows better
//! than the material.
//!
//! The square stands for the hemisphere over a matt surface, by the concentric map: the uniform distribution is the one with density
//! cos(theta)/pi, and any other one has a density relative to that.

use bhs_core::sampling::ONE_MINUS_EPSILON;
use glam::Vec2;

/// Squares along a side.
const SIDE: usize = 8;
/// Squares.
pub const SQUARES: usize = SIDE * SIDE;

/// Shares of rows and of the squares within each row, summed up.
///
/// Aligned so that a row does not straddle two cache lines.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Warp {
    rows: [f32; SIDE],
    columns: [[f32; SIDE]; SIDE],
}

/// A point drawn from a [`Warp`].
#[derive(Clone, Copy, Debug)]
pub struct WarpSample {
    /// The point.
    pub point: Vec2,
    /// Its density.
    pub density: f32,
}

/// The interval of sums that `u` in [0,1) falls into: its number, its start and its width.
#[inline]
fn find(sums: &[f32; SIDE], u: f32) -> (usize, f32, f32) {
    // Without branches: the last sum is 1 and never counts.
    let i = sums[..SIDE - 1].iter().map(|s| usize::from(*s <= u)).sum();
    let (start, width) = interval(sums, i);
    (i, start, width)
}

#[inline]
fn interval(sums: &[f32; SIDE], i: usize) -> (f32, f32) {
    let start = if i == 0 { 0.0 } else { sums[i - 1] };
    (start, sums[i] - start)
}

/// Sums of `weights`, the last of them 1.
fn summed(weights: [f32; SIDE]) -> [f32; SIDE] {
    let total: f32 = weights.iter().sum();
    let mut sum = 0.0;
    let mut sums = weights.map(|w| {
        sum += w / total;
        sum
    });
    sums[SIDE - 1] = 1.0;
    sums
}

impl Warp {
    /// The uniform distribution.
    pub const UNIFORM: Self = {
        const SUMS: [f32; SIDE] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
        Self { rows: SUMS, columns: [SUMS; SIDE] }
    };

    /// The distribution proportional to `weights`, row by row, which are positive.
    pub fn new(weights: &[f32; SQUARES]) -> Self {
        let row = |i: usize| -> [f32; SIDE] { std::array::from_fn(|j| weights[i * SIDE + j]) };
        let rows = summed(std::array::from_fn(|i| row(i).iter().sum()));
        Self { rows, columns: std::array::from_fn(|i| summed(row(i))) }
    }

    /// Turns a uniform point into one of this distribution; neighbours remain neighbours.
    #[inline]
    pub fn sample(&self, u: Vec2) -> WarpSample {
        let (i, x, width) = find(&self.rows, u.x);
        let (j, y, height) = find(&self.columns[i], u.y);
        let within = Vec2::new((u.x - x) / width, (u.y - y) / height);
        let point = (Vec2::new(i as f32, j as f32) + within) / SIDE as f32;
        let density = SQUARES as f32 * width * height;
        WarpSample { point: point.min(Vec2::splat(ONE_MINUS_EPSILON)), density }
    }

    /// The square that `point` lies in.
    #[inline]
    pub fn square(point: Vec2) -> usize {
        let [i, j] = [point.x, point.y].map(|v| ((v * SIDE as f32) as usize).min(SIDE - 1));
        i * SIDE + j
    }

    /// The density at `point`.
    #[inline]
    pub fn density(&self, point: Vec2) -> f32 {
        let [i, j] = [point.x, point.y].map(|v| ((v * SIDE as f32) as usize).min(SIDE - 1));
        SQUARES as f32 * interval(&self.rows, i).1 * interval(&self.columns[i], j).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::sampling::{mix64, unit_f32};

    fn number(i: u64) -> f32 {
        unit_f32((mix64(i) >> 32) as u32)
    }

    /// Weights over four orders of magnitude.
    fn weights() -> [f32; SQUARES] {
        std::array::from_fn(|i| 1e-4 + number(i as u64 + 7).powi(6))
    }

    #[test]
    fn the_density_integrates_to_one_and_is_proportional_to_the_weights() {
        let (warp, weights) = (Warp::new(&weights()), weights());
        let centre = |k: usize| (Vec2::new((k / SIDE) as f32, (k % SIDE) as f32) + 0.5) / SIDE as f32;
        let mean = (0..SQUARES).map(|k| warp.density(centre(k))).sum::<f32>() / SQUARES as f32;
        assert!((mean - 1.0).abs() < 1e-5, "{mean}");
        let total: f32 = weights.iter().sum();
        for (k, weight) in weights.iter().enumerate() {
            let (density, expected) = (warp.density(centre(k)), weight / total * SQUARES as f32);
            assert!((density - expected).abs() < 2e-3 * expected + 1e-5, "{k}: {density} {expected}");
        }
        assert_eq!(Warp::UNIFORM.density(Vec2::new(0.3, 0.99)), 1.0);
    }

    #[test]
    fn samples_have_their_density() {
        let warp = Warp::new(&weights());
        let n = 200_000;
        let mut counts = [0_u32; SQUARES];
        for i in 0..n {
            let s = warp.sample(Vec2::new(number(2 * i + 1000), number(2 * i + 1001)));
            assert!(s.point.cmpge(Vec2::ZERO).all() && s.point.cmplt(Vec2::ONE).all(), "{s:?}");
            counts[Warp::square(s.point)] += 1;
        }
        // Chi square over the squares where enough is expected, the others together.
        let (mut chi, mut cells, mut rest) = (0.0, 0, (0.0, 0.0));
        for (k, count) in counts.iter().enumerate() {
            let centre = (Vec2::new((k / SIDE) as f32, (k % SIDE) as f32) + 0.5) / SIDE as f32;
            let expected = f64::from(warp.density(centre)) / SQUARES as f64 * n as f64;
            if expected < 10.0 {
                rest = (rest.0 + expected, rest.1 + f64::from(*count));
            } else {
                chi += (f64::from(*count) - expected).powi(2) / expected;
                cells += 1;
            }
        }
        if rest.0 > 0.0 {
            chi += (rest.1 - rest.0).powi(2) / rest.0;
            cells += 1;
        }
        let freedom = f64::from(cells - 1);
        assert!(chi < freedom + 4.5 * (2.0 * freedom).sqrt(), "{chi} with {freedom} degrees of freedom");
    }

    #[test]
    fn the_end_of_the_square_stays_within() {
        let last = Vec2::splat(ONE_MINUS_EPSILON);
        for warp in [Warp::UNIFORM, Warp::new(&weights())] {
            let s = warp.sample(last);
            assert!(s.point.cmplt(Vec2::ONE).all() && Warp::square(s.point) == SQUARES - 1 && s.density > 0.0, "{s:?}");
            assert!(warp.density(s.point) == s.density);
        }
    }
}
