//! Discs of one size on the sky: which of them cover a direction.

use bhs_core::sampling::concentric_disk;
use bhs_elementary::Elementary;
use glam::{DVec3, IVec3, Vec2};
use std::f64::consts::TAU;

/// Small discs around directions, sorted into the cells of a grid through the unit sphere.
pub struct Discs {
    /// `1 - cos` of the angular radius.
    versine: f64,
    /// Length of the edges of the cells.
    cell: f64,
    /// Cells with a disc in them, each with one of its discs, sorted.
    entries: Vec<(u64, u32)>,
}

impl Discs {
    /// Around the unit vectors `centers`, of the angular radius `radius` (rad).
    pub fn new(centers: &[DVec3], radius: f64) -> Self {
        // The chord is shorter than the arc, so that a disc lies within a cube of this half width.
        let half = radius + 1e-9;
        // About one disc in a cell that has any, and a disc in no more than eight.
        let cell = (2.0 * half).max((2.0 * TAU / centers.len().max(1) as f64).sqrt());
        let mut entries = Vec::with_capacity(2 * centers.len());
        for (i, center) in centers.iter().enumerate() {
            let [lo, hi] = [*center - half, *center + half].map(|p| (p / cell).floor().as_ivec3());
            for (x, y, z) in (lo.x..=hi.x).flat_map(|x| (lo.y..=hi.y).flat_map(move |y| (lo.z..=hi.z).map(move |z| (x, y, z)))) {
                entries.push((key(IVec3::new(x, y, z)), i as u32));
            }
        }
        entries.sort_unstable();
        Self { versine: versine(radius), cell, entries }
    }

    /// Solid angle of each (sr).
    pub fn solid_angle(&self) -> f64 {
        TAU * self.versine
    }

    /// The numbers of those that cover the unit vector `direction`, in increasing order.
    pub fn at(&self, direction: DVec3, centers: &[DVec3]) -> impl Iterator<Item = usize> {
        let key = key((direction / self.cell).floor().as_ivec3());
        let first = self.entries.partition_point(|(k, _)| *k < key);
        let here = self.entries[first..].iter().take_while(move |(k, _)| *k == key).map(|(_, i)| *i as usize);
        // 1 - cos, without the loss of digits of a cosine close to 1.
        here.filter(move |i| 0.5 * (direction - centers[*i]).length_squared() <= self.versine)
    }

    /// A direction in the disc around `center`, all alike, from two numbers in [0,1).
    pub fn sample(&self, center: DVec3, u: Vec2) -> DVec3 {
        // A hair within, so that no rounding puts it outside.
        let p = concentric_disk(u).as_dvec2() * (1.0 - 1e-6);
        // By equal areas from the disc to the cap (Lambert): 1 - cos grows with the square of the radius.
        let v = self.versine * p.length_squared();
        let across = (self.versine * (2.0 - v)).sqrt();
        let (s, t) = center.any_orthonormal_pair();
        (center * (1.0 - v) + (s * p.x + t * p.y) * across).normalize()
    }
}

/// `1 - cos(angle)`
fn versine(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sine().powi(2)
}

/// One number for a cell: 21 bits a coordinate.
fn key(cell: IVec3) -> u64 {
    let bits = |c: i32| (i64::from(c) + (1 << 20)) as u64 & ((1 << 21) - 1);
    bits(cell.x) << 42 | bits(cell.y) << 21 | bits(cell.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a walk through all discs.
    #[test]
    fn the_grid_finds_every_disc() {
        // Directions that fill the sphere (golden angle), and some on its axes, where cells meet.
        let spiral = |i: u32, n: u32| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        };
        let mut centers: Vec<DVec3> = (0..500).map(|i| spiral(i, 500)).collect();
        centers.extend([DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Z]);
        for radius in [1e-3, 0.03, 0.17] {
            let discs = Discs::new(&centers, radius);
            let mut found = 0;
            for direction in (0..20_000).map(|i| spiral(i, 20_000)).chain(centers.iter().copied()) {
                let all = |i: &usize| direction.dot(centers[*i]).clamp(-1.0, 1.0).acos() <= radius;
                let expected: Vec<usize> = (0..centers.len()).filter(all).collect();
                let at: Vec<usize> = discs.at(direction, &centers).collect();
                assert_eq!(at, expected, "{radius} {direction}");
                found += at.len();
            }
            assert!(found >= centers.len());
        }
    }

    #[test]
    fn samples_fill_the_disc_evenly() {
        let (center, radius, n) = (DVec3::new(0.3, -0.5, 0.8).normalize(), 0.05f64, 200);
        let discs = Discs::new(&[center], radius);
        let mut inner = 0;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let d = discs.sample(center, Vec2::new((i as f32 + 0.5) / n as f32, (j as f32 + 0.5) / n as f32));
            let angle = (d - center).length();
            assert!(angle <= radius && discs.at(d, &[center]).eq([0]));
            inner += usize::from(angle < 0.6 * radius);
        }
        assert!((inner as f64 / (n * n) as f64 - 0.36).abs() < 2e-3, "{inner}");
    }
}
