//! `stratified`: jittered samples, one in each cell of a grid.
//!
//! The samples of a pixel lie in the cells of a grid of `xsamples` times `ysamples`, in each pair of dimensions, and so that each
//! dimension by itself is divided into as many parts as there are samples, with one in each (multi-jittered, Chiu, Shirley and Wang 1994;
//! by permutations without memory, Kensler 2013, "Correlated Multi-Jittered Sampling"). Wavelengths are spread evenly over the samples, and over
//! neighbouring pixels.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xsamples` | integer | 4 | | cells across |
//! | `ysamples` | integer | 4 | | cells down |
//! | `jitter` | bool | true | | whether samples lie anywhere in their part of a cell, or in its middle |
//! | `pixelsamples` | integer | none | | in place of `xsamples` and `ysamples`: so many, in a grid as square as can be |
//!
//! ```bhs
//! Sampler "stratified" "integer xsamples" 8 "integer ysamples" 8
//! WorldBegin
//! ```

use crate::{hash, wavelengths};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::sampling::{ONE_MINUS_EPSILON, SET, Sampler, mix64, unit_f32};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Sampler> =
    Plugin { name: "stratified", summary: "jittered samples, one in each cell of a grid", build };

pub(crate) struct Stratified {
    /// Cells across and down.
    pub grid: [u32; 2],
    pub jitter: bool,
    pub seed: u64,
}

/// Most cells on a side, and most samples.
const MOST: i64 = 30_000;

fn build(p: &Params) -> Option<Box<dyn Sampler>> {
    let x = p.get_in("xsamples", 4, 1..=MOST, "", "cells across");
    let y = p.get_in("ysamples", 4, 1..=MOST, "", "cells down");
    let jitter = p.get("jitter", true, "", "whether samples lie anywhere in their part of a cell, or in its middle");
    if p.is_given("noise") {
        let why = "a pixel of this sampler has samples in all cells of its grid, and no other number of them; `sobol` and `independent` take `noise`";
        // Read, so that it is not unknown besides, nor what belongs to it.
        p.optional::<f64>("noise", "", "");
        for name in ["noisemeasure", "noiseover"] {
            p.optional::<String>(name, "", "");
        }
        p.reject("noise", "`stratified` cannot sample until the noise is low", why);
    }
    let about = "in place of `xsamples` and `ysamples`: so many, in a grid as square as can be";
    let grid = match p.optional::<i64>("pixelsamples", "", about) {
        None => [x as u32, y as u32],
        Some(n) if (1..=MOST * MOST).contains(&n) => grid(n as u32),
        Some(n) => {
            p.reject("pixelsamples", "`pixelsamples` is out of range", format!("expected 1 to {}, found {n}", MOST * MOST));
            [1, 1]
        }
    };
    Some(Box::new(Stratified { grid, jitter, seed: p.context().seed }))
}

/// The grid of `n` cells that is nearest to a square.
fn grid(n: u32) -> [u32; 2] {
    let x = (1..=n.isqrt()).rev().find(|x| n.is_multiple_of(*x)).unwrap_or(1);
    [x, n / x]
}

/// Element `i` of a permutation of 0..`n`, number `key` (Kensler 2013, section 3).
fn permute(mut i: u32, n: u32, key: u32) -> u32 {
    let mask = n.next_power_of_two().wrapping_sub(1);
    loop {
        i ^= key;
        i = i.wrapping_mul(0xe170_893d);
        i ^= key >> 16;
        i ^= (i & mask) >> 4;
        i ^= key >> 8;
        i = i.wrapping_mul(0x0929_eb3f);
        i ^= key >> 23;
        i ^= (i & mask) >> 1;
        i = i.wrapping_mul(1 | key >> 27);
        i = i.wrapping_mul(0x6935_fa69);
        i ^= (i & mask) >> 11;
        i = i.wrapping_mul(0x74dc_b303);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0x9e50_1cc3);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0xc860_a3df);
        i &= mask;
        i ^= i >> 5;
        if i < n {
            return (i + key % n) % n;
        }
    }
}

impl Stratified {
    /// Sample `index` of the pair of dimensions that `key` stands for.
    fn pair(&self, index: u32, key: u64) -> [f32; 2] {
        let [m, n] = self.grid;
        let [shuffle, across, down, noise] = [1, 2, 3, 4].map(|k| mix64(key ^ (k << 56)));
        let s = permute(index, m * n, shuffle as u32);
        let (column, row) = (s % m, s / m);
        let jitter = match self.jitter {
            true => {
                let bits = mix64(noise ^ u64::from(s));
                [(bits >> 32) as u32, bits as u32].map(unit_f32)
            }
            false => [0.5; 2],
        };
        // Each row has its own order of the parts of the columns, and each column that of the rows.
        let part_x = permute(row, n, across as u32 ^ column.wrapping_mul(0x9e37_79b9));
        let part_y = permute(column, m, down as u32 ^ row.wrapping_mul(0x85eb_ca6b));
        let x = (f64::from(column) + (f64::from(part_x) + f64::from(jitter[0])) / f64::from(n)) / f64::from(m);
        let y = (f64::from(row) + (f64::from(part_y) + f64::from(jitter[1])) / f64::from(m)) / f64::from(n);
        [x, y].map(|v| (v as f32).min(ONE_MINUS_EPSILON))
    }
}

impl Sampler for Stratified {
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET] {
        // What goes beyond the grid begins another one.
        let count = self.samples_per_pixel();
        let key = hash(self.seed ^ u64::from(index / count), pixel, set);
        let ([a, b], [c, d]) = (self.pair(index % count, key), self.pair(index % count, mix64(key)));
        [a, b, c, d]
    }

    fn wavelengths(&self, pixel: [u32; 2], index: u32) -> f32 {
        let count = self.samples_per_pixel();
        let seed = self.seed ^ u64::from(index / count);
        // In an order of their own: the cells of the grid have another one in each pixel.
        wavelengths::of_count(seed, pixel, permute(index % count, count, mix64(seed) as u32), count)
    }

    fn samples_per_pixel(&self) -> u32 {
        self.grid[0] * self.grid[1]
    }

    fn depends_on_count(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_and_every_part_has_one_sample() {
        for (grid, jitter) in [([4, 4], true), ([5, 3], true), ([1, 7], true), ([6, 2], false)] {
            let sampler = Stratified { grid, jitter, seed: 3 };
            let n = grid[0] * grid[1];
            for (pixel, set) in [([0, 0], 0), ([7, 3], 5)] {
                for pair in [0, 2] {
                    let mut cells = vec![0; n as usize];
                    let mut parts = [vec![0; n as usize], vec![0; n as usize]];
                    for i in 0..n {
                        let numbers = sampler.numbers(pixel, i, set);
                        let [x, y] = [numbers[pair], numbers[pair + 1]];
                        cells[((y * grid[1] as f32) as u32 * grid[0] + (x * grid[0] as f32) as u32) as usize] += 1;
                        for (part, v) in parts.iter_mut().zip([x, y]) {
                            part[(v * n as f32) as usize] += 1;
                        }
                    }
                    assert!(
                        cells.iter().chain(parts.iter().flatten()).all(|c| *c == 1),
                        "{grid:?} {jitter}: {cells:?} {parts:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn grids_are_as_square_as_can_be() {
        for (n, expected) in [(1, [1, 1]), (2, [1, 2]), (16, [4, 4]), (12, [3, 4]), (13, [1, 13]), (200, [10, 20])] {
            assert_eq!(grid(n), expected);
        }
    }
}
