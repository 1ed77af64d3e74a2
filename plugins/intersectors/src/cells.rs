//! A grid that tells which of some numbered parts of space a point may lie in.

use bhs_core::geometry::Aabb;
use glam::{DVec3, USizeVec3};

/// Cells along the longest side of the box around all parts.
const CELLS: f64 = 64.0;

/// Pairs of a cell and a part in it; where there are more, the cells are made larger.
const MOST: usize = 8_000_000;

/// The grid.
pub(crate) struct Cells {
    bounds: Aabb,
    per_cell: f64,
    size: USizeVec3,
    /// The same, and what is added to a point's coordinates in cells, so that rounding gives its cell.
    counts: [u32; 3],
    start: DVec3,
    /// A bit for each cell that has parts: small enough to stay at hand.
    filled: Vec<u64>,
    /// Of each cell, where its parts begin in `parts`; x fastest.
    starts: Vec<u32>,
    parts: Vec<u32>,
}

impl Cells {
    /// Over parts with the boxes `boxes`. `may_hold(part, middle, half)` says whether a part may reach into a box within its own.
    pub(crate) fn new(boxes: &[Aabb], may_hold: impl Fn(usize, DVec3, DVec3) -> bool) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        let extent = (bounds.max - bounds.min).max_element().max(f64::MIN_POSITIVE);
        let mut cells = CELLS;
        loop {
            let side = extent / cells;
            let size = ((bounds.max - bounds.min) / side).floor().as_usizevec3() + 2;
            let mut grid = Self {
                bounds,
                per_cell: side.recip(),
                size,
                counts: size.to_array().map(|n| n as u32),
                start: -bounds.min / side - 0.5,
                filled: Vec::new(),
                starts: Vec::new(),
                parts: Vec::new(),
            };
            match grid.filling(boxes, &may_hold) {
                Some(filling) => {
                    grid.fill(filling);
                    return grid;
                }
                None => cells *= 0.5,
            }
        }
    }

    /// Pairs of a cell and a part in it; `None` if they are too many, unless there is one cell only.
    fn filling(&self, boxes: &[Aabb], may_hold: &impl Fn(usize, DVec3, DVec3) -> bool) -> Option<Vec<(u32, u32)>> {
        // A little more than the cell, for rounding.
        let half = DVec3::splat(0.5 * (1.0 + 1e-9) / self.per_cell);
        let mut filling = Vec::new();
        let mut looks = 0;
        for (part, b) in boxes.iter().enumerate() {
            // A point between two cells may count as in either: a little more than the box, for rounding.
            let more = 1e-6 / self.per_cell;
            let [low, high] = [b.min - more, b.max + more].map(|p| self.cell(p));
            for z in low.z..=high.z {
                for y in low.y..=high.y {
                    for x in low.x..=high.x {
                        looks += 1;
                        let middle = self.bounds.min + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) / self.per_cell;
                        if may_hold(part, middle, half) {
                            filling.push((self.index(USizeVec3::new(x, y, z)) as u32, part as u32));
                        }
                    }
                }
            }
            if looks > MOST && self.size.max_element() > 2 {
                return None;
            }
        }
        Some(filling)
    }

    fn fill(&mut self, mut filling: Vec<(u32, u32)>) {
        let count = self.size.element_product();
        self.filled = vec![0; count.div_ceil(64)];
        self.starts = vec![0; count + 1];
        filling.sort_unstable();
        for (cell, _) in &filling {
            self.filled[*cell as usize / 64] |= 1 << (cell % 64);
            self.starts[*cell as usize + 1] += 1;
        }
        for i in 0..count {
            self.starts[i + 1] += self.starts[i];
        }
        self.parts = filling.into_iter().map(|(_, part)| part).collect();
    }

    /// The cell of a point, the nearest one if it lies in none.
    #[inline]
    fn cell(&self, point: DVec3) -> USizeVec3 {
        let c = ((point - self.bounds.min) * self.per_cell).max(DVec3::ZERO);
        // What is too large for a number of a cell becomes the largest one.
        c.as_usizevec3().min(self.size - 1)
    }

    #[inline]
    fn index(&self, c: USizeVec3) -> usize {
        (c.z * self.size.y + c.y) * self.size.x + c.x
    }

    /// The parts that may hold a point.
    #[inline(always)]
    pub(crate) fn at(&self, point: DVec3) -> &[u32] {
        // Adding this rounds to the nearest whole number, and leaves it in the lowest bits. Far outside those may be those of a cell: whoever
        // asks looks at its parts.
        const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
        let p = point * self.per_cell + self.start + ROUND;
        let [x, y, z] = p.to_array().map(|c| c.to_bits() as u32);
        let [nx, ny, nz] = self.counts;
        if x >= nx || y >= ny || z >= nz {
            return &[];
        }
        let i = ((z * ny + y) * nx + x) as usize;
        match self.filled.get(i / 64) {
            Some(bits) if bits >> (i % 64) & 1 == 1 => &self.parts[self.starts[i] as usize..self.starts[i + 1] as usize],
            _ => &[],
        }
    }
}
