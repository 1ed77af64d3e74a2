//! Where photons of a light are sent: a density over the unit square that is learned from those that brought light to rough surfaces.

use bhs_core::sampling::{Discrete, ONE_MINUS_EPSILON};
use glam::{DVec2, Vec2};

/// Cells along a side of the square.
const SIDE: usize = 32;
/// Share of photons that do not follow what was learned: nothing is left out for ever.
const BASE: f64 = 0.25;
/// How much of a cell's light its neighbours are taken to have: what a few photons have found has an edge somewhere.
const BLUR: f64 = 0.1;

/// A density over the unit square, relative to an even one.
#[derive(Default)]
pub struct Aim {
    learned: Option<Discrete>,
}

impl Aim {
    /// Number of cells.
    pub const CELLS: usize = SIDE * SIDE;

    /// That in proportion to what each cell of the square has brought; `None`, and a base alone, if that is nothing.
    pub fn learn(brought: &[f64]) -> Self {
        let at = |x: isize, y: isize| {
            let inside = (0..SIDE as isize).contains(&x) && (0..SIDE as isize).contains(&y);
            if inside { brought[y as usize * SIDE + x as usize] } else { 0.0 }
        };
        let blurred = (0..Self::CELLS).map(|i| {
            let (x, y) = ((i % SIDE) as isize, (i / SIDE) as isize);
            let around: f64 = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| at(x + dx, y + dy))).sum();
            at(x, y) + BLUR * around
        });
        let learned = Discrete::new(blurred);
        Self { learned: (learned.total() > 0.0 && learned.total().is_finite()).then_some(learned) }
    }

    /// The cell of a point.
    pub fn cell(point: DVec2) -> usize {
        let [x, y] = [point.x, point.y].map(|x| ((x * SIDE as f64) as usize).min(SIDE - 1));
        y * SIDE + x
    }

    /// A point by what was learned; `None` for one of the base, which is chosen with `choice` in [0,1).
    pub fn sample(&self, choice: f32, u: Vec2) -> Option<DVec2> {
        let learned = self.learned.as_ref().filter(|_| f64::from(choice) >= BASE)?;
        let (cell, rest) = learned.sample(u.x)?;
        let corner = DVec2::new((cell % SIDE) as f64, (cell / SIDE) as f64);
        Some((corner + Vec2::new(rest.min(ONE_MINUS_EPSILON), u.y).as_dvec2()) / SIDE as f64)
    }

    /// The share of the base, and the density at `point` of what was learned, times its share.
    pub fn density(&self, point: DVec2) -> (f64, f64) {
        match &self.learned {
            Some(learned) => (BASE, (1.0 - BASE) * learned.probability(Self::cell(point)) * Self::CELLS as f64),
            None => (1.0, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_their_density() {
        let brought: Vec<f64> = (0..Aim::CELLS).map(|i| if i % 37 == 0 { i as f64 } else { 0.0 }).collect();
        let aim = Aim::learn(&brought);
        let mut counts = vec![0.0; Aim::CELLS];
        let n = 1u32 << 18;
        for i in 0..n {
            let along = |step: f64| (f64::from(i) * step).fract() as f32;
            let u = Vec2::new(along(0.754_877_666), along(0.569_840_291));
            counts[Aim::cell(aim.sample(0.9, u).expect("it has learned"))] += 1.0;
        }
        for (i, count) in counts.into_iter().enumerate() {
            let middle = (DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) + 0.5) / SIDE as f64;
            let expected = aim.density(middle).1 / (1.0 - BASE) / Aim::CELLS as f64 * f64::from(n);
            assert!((count - expected).abs() < 6.0 * expected.sqrt() + 6.0, "{i}: {count} and {expected}");
        }
        assert!(aim.sample(0.1, Vec2::ZERO).is_none() && Aim::learn(&[0.0; Aim::CELLS]).density(DVec2::ZERO) == (1.0, 0.0));
    }
}
