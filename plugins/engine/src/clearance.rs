//! How far from everything a point is, at least: what lets curved rays pass over empty space without asking the intersector.
//!
//! A grid of cubic cells over the box around all surfaces. Cells that a surface may touch are marked (conservatively: of a triangle
//! all cells of its box that its plane passes), and every cell gets the largest cube of free cells around it. The answer is
//! a lower bound by construction: a surface is never nearer than it says.

use bhs_core::geometry::{Aabb, Geometry, TriangleMesh};
use bhs_core::real::{Real, Vector};
use glam::{DVec3, UVec3};
use instances::Objects;

mod instances;

/// Lower bounds of the distance to all surfaces.
pub struct Clearance {
    /// The grid's corner, render space.
    min: DVec3,
    /// The grid's box.
    bounds: Aabb,
    /// Side of a cell (scene units), and its inverse.
    cell: f64,
    per_cell: f64,
    size: UVec3,
    /// The same as numbers.
    cells: DVec3,
    /// Of each cell, the least number of steps, diagonal ones included, to a marked one; x fastest.
    steps: Vec<u8>,
    /// The distance within which there is no surface, of each number of steps.
    distances: [f64; 256],
}

/// Cells along the longest side of the box around all surfaces.
const CELLS: f64 = 64.0;
/// Cells that are looked at for all triangles together; what takes more has no free space worth knowing.
const MOST_VISITS: u64 = 50_000_000;
/// How far a surface is taken to reach beyond its coordinates, in cells: far more than rounding.
const MARGIN: f64 = 1e-3;

impl Clearance {
    /// The free space around `geometries`, whose box is `bounds`; `None` where there is nothing, or nothing to gain.
    pub fn new(geometries: &[Geometry], bounds: &Aabb) -> Option<Self> {
        let mut grid = Self::marked(geometries, bounds, CELLS)??;
        grid.spread();
        Some(grid)
    }

    /// The grid, of so many cells along the longest side of the box, with the cells marked that surfaces may touch. `Some(None)` if
    /// there is nothing that could be divided, `None` if too many cells had to be looked at.
    pub(crate) fn marked(geometries: &[Geometry], bounds: &Aabb, cells: f64) -> Option<Option<Self>> {
        if bounds.is_empty() {
            return Some(None);
        }
        let cell = (bounds.max - bounds.min).max_element() / cells;
        if !(cell > 0.0 && cell.recip().is_finite()) {
            return Some(None);
        }
        // One cell more on each side, so that surfaces on the boundary lie within the grid.
        let min = bounds.min - cell;
        let size = ((bounds.max - min) / cell).ceil().as_uvec3() + 1;
        let bounds = Aabb { min, max: min + size.as_dvec3() * cell };
        let count = size.x as usize * size.y as usize * size.z as usize;
        let distances = std::array::from_fn(|steps| steps.saturating_sub(1) as f64 * cell);
        let (per_cell, cells, steps) = (cell.recip(), size.as_dvec3(), vec![u8::MAX; count]);
        let mut grid = Self { min, bounds, cell, per_cell, size, cells, steps, distances };
        let mut objects = Objects::new(geometries);
        let mut visits = 0;
        for geometry in geometries {
            match geometry {
                Geometry::Mesh(mesh) => {
                    for t in 0..mesh.triangles.len() as u32 {
                        visits += grid.mark_triangle(mesh, t);
                        if visits > MOST_VISITS {
                            return None;
                        }
                    }
                }
                Geometry::Analytic(surface) => {
                    let bounds = surface.bounds();
                    grid.mark(&bounds, |middle, half| surface.may_pass(middle, half));
                }
                Geometry::Instance(instance) => {
                    for filled in objects.boxes(instance, cell)? {
                        visits += grid.mark(&filled, |_, _| true);
                        if visits > MOST_VISITS {
                            return None;
                        }
                    }
                }
            }
        }
        Some(Some(grid))
    }

    /// The middles of the marked cells.
    pub(crate) fn marked_cells(&self) -> impl Iterator<Item = DVec3> + '_ {
        let [nx, ny, _] = self.size.to_array().map(|n| n as usize);
        let middle = move |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64) + 0.5;
        let marked = (0..self.steps.len()).filter(|i| self.steps[*i] == 0);
        marked.map(move |i| self.min + middle(i) * self.cell)
    }

    /// A distance (scene units) from `point`, in any direction, within which there is no surface; 0 where nothing is known.
    #[inline]
    pub fn at(&self, point: DVec3) -> f64 {
        let p = (point - self.min) * self.per_cell;
        let inside = (p.cmpge(DVec3::ZERO) & p.cmplt(self.cells)).all();
        if !inside {
            return self.outside(point);
        }
        // Adding this rounds to the nearest whole number, and leaves it in the lowest bits. A point between two cells may count as in either:
        // they are closed.
        const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
        let [x, y, z] = ((p - 0.5) + ROUND).to_array().map(|c| c.to_bits() as u32);
        self.around(UVec3::new(x, y, z))
    }

    /// The distance from any point of the cell `c` within which there is no surface.
    #[inline]
    fn around(&self, c: UVec3) -> f64 {
        self.distances[usize::from(self.steps[self.index(c)])]
    }

    /// [`Clearance::at`] several points.
    #[inline(always)]
    pub fn at_each<F: Real>(&self, points: Vector<F>) -> F {
        let c = F::splat;
        let zero = c(0.0);
        let Aabb { min, max } = self.bounds;
        let clamp = |at: F, min: f64, max: f64| at.max(c(min)).min(c(max));
        let nearest =
            Vector { x: clamp(points.x, min.x, max.x), y: clamp(points.y, min.y, max.y), z: clamp(points.z, min.z, max.z) };
        let p = (nearest - Vector::all(min)) * c(self.per_cell);
        let cell = |p: F, cells: f64| p.floor().min(c(cells - 1.0));
        // Adding this leaves a whole number in the lowest bits. All numbers here are whole and exact: they are added up in the order in which nothing
        // waits for long.
        const WHOLE: f64 = (1u64 << 52) as f64;
        let row = cell(p.y, self.cells.y).times_plus(c(self.cells.x), cell(p.x, self.cells.x) + c(WHOLE));
        let index = cell(p.z, self.cells.z).times_plus(c(self.cells.x * self.cells.y), row).to_array();
        let distance = F::from_fn(|i| {
            let steps = self.steps.get(index[i].to_bits() as u32 as usize).copied().unwrap_or(0);
            self.distances[usize::from(steps)]
        });
        let away = (points - nearest).length_squared().sqrt();
        // Of what is not a number, nothing is known.
        F::select(away.is_finite(), away.max(distance - away), zero)
    }

    /// [`Clearance::at`] a point outside of the grid: what is known by its distance, or by the nearest point within.
    fn outside(&self, point: DVec3) -> f64 {
        let nearest = point.clamp(self.bounds.min, self.bounds.max);
        let away = point.distance(nearest);
        // Not a number: nothing is known.
        if !away.is_finite() {
            return 0.0;
        }
        let cell = ((nearest - self.min) * self.per_cell).floor().min(self.cells - 1.0);
        away.max(self.around(cell.as_uvec3()) - away)
    }

    /// Side of a cell (scene units).
    pub fn cell(&self) -> f64 {
        self.cell
    }

    fn index(&self, c: UVec3) -> usize {
        (c.z as usize * self.size.y as usize + c.y as usize) * self.size.x as usize + c.x as usize
    }

    /// Marks the cells that a triangle may touch; says how many it has looked at.
    fn mark_triangle(&mut self, mesh: &TriangleMesh, triangle: u32) -> u64 {
        let corners = mesh.corners(triangle);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let bounds = corners.into_iter().fold(Aabb::EMPTY, |bounds, p| bounds.with_point(p));
        self.mark(&bounds, |middle, half| normal.dot(middle - a).abs() <= normal.abs().dot(half))
    }

    /// Marks the cells within `bounds` that `touches` (middle and half the sides of a box) does not rule out.
    fn mark(&mut self, bounds: &Aabb, touches: impl Fn(DVec3, DVec3) -> bool) -> u64 {
        if bounds.is_empty() {
            return 0;
        }
        let cell_of = |p: DVec3| ((p - self.min) * self.per_cell).max(DVec3::ZERO);
        let from = (cell_of(bounds.min) - MARGIN).max(DVec3::ZERO).as_uvec3();
        let to = (cell_of(bounds.max) + MARGIN).as_uvec3().min(self.size - 1);
        let half = DVec3::splat((0.5 + MARGIN) * self.cell);
        for z in from.z..=to.z {
            for y in from.y..=to.y {
                for x in from.x..=to.x {
                    let c = UVec3::new(x, y, z);
                    if touches(self.min + (c.as_dvec3() + 0.5) * self.cell, half) {
                        let index = self.index(c);
                        self.steps[index] = 0;
                    }
                }
            }
        }
        (to + 1 - from).as_u64vec3().element_product()
    }

    /// From marks to steps: once forwards and once backwards through the grid, each cell is at most one step farther than those of its
    /// 26 neighbours that have been passed before (exact for the chessboard distance; Borgefors 1986, "Distance transformations
    /// in digital images").
    fn spread(&mut self) {
        let [nx, ny, nz] = self.size.to_array().map(|n| n as usize);
        for backwards in [false, true] {
            for k in 0..ny * nz {
                let row = if backwards { ny * nz - 1 - k } else { k };
                let (y, z) = (row % ny, row / ny);
                // Rows that have been passed: those of the plane before, and the one before in this plane.
                let (plane, line) = if backwards { (z + 1, y + 1) } else { (z.wrapping_sub(1), y.wrapping_sub(1)) };
                let beside = [(y.wrapping_sub(1), plane), (y, plane), (y + 1, plane), (line, z)];
                for (y, z) in beside.into_iter().filter(|(y, z)| *y < ny && *z < nz) {
                    self.spread_to_row(row * nx, (z * ny + y) * nx, nx);
                }
                let steps = &mut self.steps[row * nx..][..nx];
                for i in 1..nx {
                    let (to, from) = if backwards { (nx - 1 - i, nx - i) } else { (i, i - 1) };
                    steps[to] = steps[to].min(steps[from].saturating_add(1));
                }
            }
        }
    }

    /// The cells of the row that begins at `to` are at most one step farther than their three neighbours in the row at `from`.
    fn spread_to_row(&mut self, to: usize, from: usize, n: usize) {
        // One of the two begins behind the end of the other.
        let (low, high) = self.steps.split_at_mut(to.max(from));
        let (to, from) = if to < from { (&mut low[to..][..n], &high[..n]) } else { (&mut high[..n], &low[from..][..n]) };
        for (i, steps) in to.iter_mut().enumerate() {
            let near = from[i].min(from[i.saturating_sub(1)]).min(from[(i + 1).min(n - 1)]);
            *steps = (*steps).min(near.saturating_add(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::geometry::WorldMesh;
    use bhs_core::geometry::instance::Object;
    use bhs_core::lanes::Lanes;
    use bhs_core::sampling::mix64;
    use glam::{DAffine3, DMat3};
    use std::sync::Arc;

    fn random(i: u64, k: u64) -> f64 {
        (mix64(mix64(i) ^ k) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(i: u64, k: u64) -> DVec3 {
        DVec3::new(random(i, k), random(i, k + 1), random(i, k + 2)) * 2.0 - 1.0
    }

    /// Nearest point of a triangle by brute force: a fine net of its points.
    fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
        let n = 60;
        let mut least = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let q = a + (b - a) * f64::from(i) / f64::from(n) + (c - a) * f64::from(j) / f64::from(n);
                least = least.min((p - q).length());
            }
        }
        least
    }

    #[test]
    fn no_surface_is_nearer_than_it_says() {
        for case in 0..6 {
            let triangles: Vec<[DVec3; 3]> = (0..8)
                .map(|t| {
                    let (at, size) = (point(case, 100 * t), 0.05 + random(case, 100 * t + 50));
                    std::array::from_fn(|k| at + point(case, 100 * t + 10 * (k as u64 + 1)) * size)
                })
                .collect();
            let positions = triangles.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
            let indices = (0..8).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let mesh = TriangleMesh { positions, triangles: indices, ..Default::default() };
            let geometry = Geometry::Mesh(Arc::new(mesh));
            let bounds = geometry.bounds();
            let grid = Clearance::new(&[geometry], &bounds).expect("a grid");
            // The steps of each cell are those to the nearest marked one.
            let cells = || (0..grid.size.z).flat_map(|z| (0..grid.size.y).map(move |y| (y, z)));
            let cells = || cells().flat_map(|(y, z)| (0..grid.size.x).map(move |x| UVec3::new(x, y, z)));
            let marked: Vec<UVec3> = cells().filter(|c| grid.steps[grid.index(*c)] == 0).collect();
            for c in cells().step_by(997) {
                let nearest = marked.iter().map(|m| (m.as_ivec3() - c.as_ivec3()).abs().max_element()).min();
                assert_eq!(nearest, Some(i32::from(grid.steps[grid.index(c)])), "case {case}: {c}");
            }
            let mut free = 0;
            for i in 0..400 {
                let p = point(i, 7 + case) * 2.0;
                let truth = triangles.iter().map(|t| distance(p, *t)).fold(f64::INFINITY, f64::min);
                let said = grid.at(p);
                let several = Lanes::to_array(grid.at_each(Vector::all(p)));
                assert!(several.iter().all(|d| (d - said).abs() <= 1e-15 * said), "case {case}: {p}: {several:?}, {said}");
                // The net's points are up to some hundredths of an edge apart.
                assert!(said <= truth, "case {case}: {p} is {truth} from a surface, not {said}");
                free += u32::from(grid.bounds.clip(p, DVec3::X, 0.0, 0.0).is_some() && said > 0.0);
            }
            assert!(free > 20, "case {case}: {free}");
        }
    }

    #[test]
    fn instances_take_up_what_copies_would() {
        let positions: Vec<DVec3> = (0..60).map(|i| point(i / 3, 40) + 0.3 * point(i, 60)).collect();
        let triangles: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = WorldMesh { positions, triangles, ..Default::default() };
        let object = Arc::new(Object::new(vec![mesh], 0.2));
        let mut geometries = Vec::new();
        for i in 0..12 {
            let turn = DMat3::from_axis_angle(point(i, 70).normalize(), 7.0 * random(i, 71));
            let m = turn * DMat3::from_diagonal(DVec3::new(0.3, -0.2, 0.1) * if i == 0 { 4.0 } else { 1.0 });
            let t = DAffine3::from_mat3_translation(m, 2.0 * point(i, 72));
            geometries.extend(object.place(t, DVec3::new(0.1, 0.2, 0.3)).expect("in range").into_iter().map(Geometry::Instance));
        }
        let bounds = geometries.iter().fold(Aabb::EMPTY, |b, g| b.union(g.bounds()));
        let grid = Clearance::new(&geometries, &bounds).expect("a grid");
        let copies: Vec<Geometry> = geometries
            .iter()
            .map(|g| {
                let positions = (0..20).flat_map(|t| g.corners(t).unwrap()).map(|p| p.as_vec3().to_array()).collect();
                let triangles = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
                Geometry::Mesh(Arc::new(TriangleMesh { positions, triangles, ..Default::default() }))
            })
            .collect();
        let exact = Clearance::new(&copies, &bounds).expect("a grid");
        let (mut said, mut known) = (0.0, 0.0);
        for i in 0..4000 {
            let p = point(i, 80) * 2.5;
            if i < 400 {
                let truth = copies.iter().flat_map(|g| (0..20).map(|t| distance(p, g.corners(t).unwrap())));
                let truth = truth.fold(f64::INFINITY, f64::min);
                assert!(grid.at(p) <= truth, "{p} is {truth} from a surface, not {}", grid.at(p));
            }
            said += grid.at(p);
            known += exact.at(p);
        }
        // Not much is lost.
        assert!(said > 0.85 * known, "{said} {known}");
    }

    #[test]
    fn a_room_is_free_up_to_its_walls() {
        // Floor and ceiling.
        let corners = |y: f32| [[-1.0, y, -1.0], [1.0, y, -1.0], [1.0, y, 1.0], [-1.0, y, 1.0]];
        let positions = [corners(0.0), corners(1.5)].concat();
        let mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], ..Default::default() };
        let geometry = Geometry::Mesh(Arc::new(mesh));
        let bounds = geometry.bounds();
        let grid = Clearance::new(&[geometry], &bounds).expect("a grid");
        for y in [0.01, 0.1, 0.3, 0.75, 1.2, 1.45] {
            let (said, truth) = (grid.at(DVec3::new(0.1, y, -0.3)), y.min(1.5 - y));
            assert!(said <= truth && said > truth - 2.5 * grid.cell, "{y}: {said}");
        }
    }

    #[test]
    fn outside_of_the_box_it_is_the_distance_to_it() {
        let mesh = TriangleMesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        let geometry = Geometry::Mesh(Arc::new(mesh));
        let bounds = geometry.bounds();
        let grid = Clearance::new(&[geometry], &bounds).expect("a grid");
        let said = grid.at(DVec3::new(0.5, 0.5, 10.0));
        assert!(said <= 10.0 && said > 9.9, "{said}");
        assert_eq!(grid.at(DVec3::NAN), 0.0);
        assert_eq!(grid.at(DVec3::INFINITY), 0.0);
        assert!(Clearance::new(&[], &Aabb::EMPTY).is_none());
    }
}
