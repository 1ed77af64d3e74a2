//! What a render has found out about where light comes from: at each place, how much of it from which part of the hemisphere.
//!
//! Places are the cells of a grid over the scene, each for six kinds of surfaces, by the axis that their normal is closest to. Where many paths came, the
//! cells are small; where few did, larger ones that hold them are taken in their place, as in an octree that is refined while paths come. The
//! hemisphere over a surface, as the observer there measures it, is unrolled to a square on which Lambert's law is uniform, and a [`Warp`] of that square is
//! what directions are drawn from. It is trained by paths: the light that a path found in a direction, over the density of that direction, adds up to
//! the light from that part of the hemisphere. Light that light sampling finds at the surface itself has no part in it.
//!
//! Matt surfaces draw all their directions so, for a share of the warp is Lambert's law; others mix directions of the warp with those of the material, the more of
//! these the more they are like mirrors.
//!
//! The paths that train it belong to no picture ([`pilot`]), so no sample depends on others, whatever part of a picture is rendered.
//!
//! Sources: Vorba et al. 2014, "On-line Learning of Parametric Mixture Models for Light Transport Simulation"; Mueller, Gross and Novak
//! 2017, "Practical Path Guiding for Efficient Light-Transport Simulation".

pub mod pilot;
mod trial;

use crate::warp::{SQUARES, Warp, WarpSample};
use bhs_core::geometry::Aabb;
use bhs_core::sampling::{concentric_square, cosine_hemisphere};
use bhs_engine::scene::Vertex;
use glam::{DVec3, Vec2, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::f32::consts::FRAC_1_PI;

/// Cells along the longest side of the scene, of the finest grid.
const CELLS: f64 = 32.0;
/// Grids: of each, cells are twice as long as of the one before.
const LEVELS: usize = 4;
/// Lessons that a cell has at least, to be taken by itself.
const LEAST_LESSONS: u32 = 256;
/// Weight of what the cell around it has learned as a prior, in lessons: what few of them say of one square is mostly noise.
const PRIOR_WEIGHT: f32 = 1024.0;
/// Mixing probability: share of the directions that follow what was learned; the others follow Lambert's law.
const MIXING_PROBABILITY: f32 = 0.7;
/// The same share of a surface that is not matt, if its directions are as even as a matt one's.
const SHARE: f32 = 0.5;
/// Density of the mirrored direction (1/sr) at which that is halved: such a surface knows better itself where its light comes from.
const HALVED_AT: f32 = 4.0;
/// Light over density that is not reckoned with.
const MOST_BROUGHT: f32 = 1e30;
/// Less of it is not worth while.
const LEAST_SHARE: f32 = 0.05;

/// What was found at one place.
#[derive(Clone)]
struct Cell {
    lessons: u32,
    /// Radiance over density of the lessons in each square.
    sums: [f32; SQUARES],
}

impl Default for Cell {
    fn default() -> Self {
        Self { lessons: 0, sums: [0.0; SQUARES] }
    }
}

/// What a render has learned.
pub struct Guide {
    /// A corner of the grids, and cells of the finest one per length.
    origin: DVec3,
    per_length: f64,
    /// Cells along each axis, of each grid, the finest first.
    sizes: [[usize; 3]; LEVELS],
    /// Of the cells of the finest grid, by kind of surface: which warp is used.
    slots: Vec<u16>,
    /// The first one stands for not knowing.
    warps: Vec<Warp>,
    /// Of the cells of the finest grid.
    cells: HashMap<u32, Cell>,
}

/// The hemisphere over a vertex, as the guide knows it.
#[derive(Clone, Copy)]
pub struct GuidedHemisphere<'a> {
    warp: &'a Warp,
    slot: u32,
    /// Share of the directions that are drawn from the warp; 0: all are the material's.
    share: f32,
    /// Axes of the square in the shading plane, and the side of the surface.
    x: Vec2,
    y: Vec2,
    side: f32,
}

/// What one path tells of the light at one place.
#[derive(Clone, Copy, Debug)]
pub struct Lesson {
    slot: u32,
    square: u32,
    /// Density of the direction, over that of Lambert's law.
    density: f32,
    /// Light that was found there.
    pub radiance: f32,
}

/// A direction drawn by a guide.
pub struct Guided {
    /// In the shading frame.
    pub wi: Vec3,
    /// Density over that of Lambert's law.
    pub density: f32,
}

impl Guide {
    /// One that knows nothing yet of a scene whose surfaces are within `bounds` (render space).
    pub fn new(bounds: Aabb) -> Self {
        let extent = if bounds.is_empty() { DVec3::ONE } else { bounds.max - bounds.min };
        let per_length = CELLS / extent.max_element().max(f64::MIN_POSITIVE);
        let finest = extent.to_array().map(|e| ((e * per_length).ceil() as usize).clamp(1, CELLS as usize));
        let sizes = std::array::from_fn(|level| finest.map(|n| n.div_ceil(1 << level)));
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.min };
        let slots = vec![0; 6 * finest.iter().product::<usize>()];
        Self { origin, per_length, sizes, slots, warps: vec![Warp::UNIFORM], cells: HashMap::new() }
    }

    /// The hemisphere on the side of `wo` of `vertex`, whose material is not specular.
    #[inline]
    pub fn place(&self, vertex: &Vertex) -> GuidedHemisphere<'_> {
        let place = self.place_at(vertex.hit.point, vertex.axes(), vertex.wo.z.signum());
        let share = if self.slots[place.slot as usize] == 0 { 0.0 } else { share(vertex) };
        GuidedHemisphere { share, ..place }
    }

    /// The hemisphere on the side `side` of a surface with the shading axes `axes` at `point`.
    #[inline]
    fn place_at(&self, point: DVec3, axes: [DVec3; 3], side: f32) -> GuidedHemisphere<'_> {
        let [s, t, n] = axes.map(|a| a.as_vec3());
        let (frame, face) = ShadingSquare::new(s, t, n, side);
        let at = (point - self.origin) * self.per_length;
        let cell: [usize; 3] = std::array::from_fn(|i| (at[i].max(0.0) as usize).min(self.sizes[0][i] - 1));
        let slot = number(self.sizes[0], cell, face);
        let warp = &self.warps[usize::from(self.slots[slot])];
        GuidedHemisphere { warp, slot: slot as u32, share: 1.0, x: frame.x, y: frame.y, side }
    }

    /// Learns from paths. What it says changes with [`Guide::refine`].
    pub fn learn(&mut self, lessons: &[Lesson]) {
        for lesson in lessons {
            let cell = self.cells.entry(lesson.slot).or_default();
            cell.lessons = cell.lessons.saturating_add(1);
            let brought = lesson.radiance / lesson.density;
            // Not what cannot be reckoned with.
            if brought.is_finite() && brought < MOST_BROUGHT {
                cell.sums[lesson.square as usize] += brought;
            }
        }
    }

    /// Draws conclusions from all that was learned.
    pub fn refine(&mut self) {
        self.warps.truncate(1);
        let mut coarser: Vec<HashMap<u32, Cell>> = Vec::new();
        for level in 1..LEVELS {
            let mut coarse: HashMap<u32, Cell> = HashMap::new();
            // In order, for sums of floating point depend on it.
            for (key, cell) in sorted(coarser.last().unwrap_or(&self.cells)) {
                let sum = coarse.entry(self.parent(level, key)).or_default();
                sum.lessons = sum.lessons.saturating_add(cell.lessons);
                sum.sums.iter_mut().zip(&cell.sums).for_each(|(sum, s)| *sum += s);
            }
            coarser.push(coarse);
        }
        // From the coarsest grid down: what is known of a cell, or of the cell around it.
        let mut known: BTreeMap<u32, Known> = BTreeMap::new();
        for level in (0..LEVELS).rev() {
            let mut here = BTreeMap::new();
            for (key, cell) in sorted(if level == 0 { &self.cells } else { &coarser[level - 1] }) {
                let around = if level + 1 < LEVELS { known.get(&self.parent(level + 1, key)).cloned() } else { None };
                let around = around.unwrap_or(Known { warp: 0, shares: [1.0 / SQUARES as f32; SQUARES] });
                here.insert(key, cell.refined(around, &mut self.warps));
            }
            known = here;
        }
        self.slots.fill(0);
        for (key, Known { warp, .. }) in known {
            self.slots[key as usize] = warp;
        }
    }

    /// The cell of the grid `level` that holds the cell `key` of the next finer one.
    fn parent(&self, level: usize, key: u32) -> u32 {
        let [_, ny, nz] = self.sizes[level - 1];
        let (cell, face) = (key as usize / 6, key as usize % 6);
        number(self.sizes[level], [cell / nz / ny, cell / nz % ny, cell % nz].map(|i| i / 2), face) as u32
    }
}

/// What is known of the light at a cell.
#[derive(Clone)]
struct Known {
    warp: u16,
    /// Of each square, in what should come from there.
    shares: [f32; SQUARES],
}

impl Cell {
    /// What is known of it, where `around` is known of the cell around it; new warps are added to `warps`.
    fn refined(&self, around: Known, warps: &mut Vec<Warp>) -> Known {
        let (own, total) = (&self.sums, self.sums.iter().sum::<f32>());
        if self.lessons < LEAST_LESSONS || total <= 0.0 || !total.is_finite() || warps.len() > usize::from(u16::MAX) {
            return around;
        }
        let weight = self.lessons as f32 / (self.lessons as f32 + PRIOR_WEIGHT);
        let shares: [f32; SQUARES] = std::array::from_fn(|i| weight * own[i] / total + (1.0 - weight) * around.shares[i]);
        warps.push(Warp::new(&shares.map(|s| 1.0 - MIXING_PROBABILITY + MIXING_PROBABILITY * SQUARES as f32 * s)));
        Known { warp: (warps.len() - 1) as u16, shares }
    }
}

/// The entries of `cells` by their numbers.
fn sorted(cells: &HashMap<u32, Cell>) -> Vec<(u32, &Cell)> {
    let mut all: Vec<(u32, &Cell)> = cells.iter().map(|(key, cell)| (*key, cell)).collect();
    all.sort_unstable_by_key(|(key, _)| *key);
    all
}

/// The number of a cell of a grid of the given size, for a kind of surfaces.
#[inline]
fn number([_, ny, nz]: [usize; 3], [x, y, z]: [usize; 3], face: usize) -> usize {
    ((x * ny + y) * nz + z) * 6 + face
}

/// Share of the directions of `vertex` that are worth being drawn by what was learned.
#[inline]
fn share(vertex: &Vertex) -> f32 {
    let (material, wo) = (vertex.material, vertex.wo);
    if material.is_matt() {
        return 1.0;
    }
    let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
    let share = SHARE / (1.0 + material.pdf(&vertex.shading, wo, mirrored) / HALVED_AT);
    if share >= LEAST_SHARE { share } else { 0.0 }
}

/// Axes of the square in the shading plane.
struct ShadingSquare {
    x: Vec2,
    y: Vec2,
}

impl ShadingSquare {
    /// The frame over the side `side` of a surface with the shading axes `s`, `t` and `n`, the same for all surfaces with the same normal
    /// whatever their axes; and which of six kinds of surfaces it is.
    #[inline]
    fn new(s: Vec3, t: Vec3, n: Vec3, side: f32) -> (Self, usize) {
        let n = n * side;
        let a = n.abs();
        let k = match (a.x >= a.y, a.x >= a.z, a.y >= a.z) {
            (true, true, _) => 0,
            (_, _, true) => 1,
            _ => 2,
        };
        // The axis after the one that the normal is closest to is far from parallel to it.
        let along = [Vec3::Y, Vec3::Z, Vec3::X][k];
        let x = Vec2::new(s.dot(along), t.dot(along)).normalize();
        (Self { x, y: side * x.perp() }, 2 * k + usize::from(n[k] < 0.0))
    }
}

impl<'a> GuidedHemisphere<'a> {
    /// Whether directions are drawn by what was learned: some of them, or all.
    #[inline]
    pub fn guides(&self) -> bool {
        self.share > 0.0
    }

    /// Share of the directions that are: the others are the material's.
    #[inline]
    pub fn share(&self) -> f32 {
        self.share
    }

    /// Draws a direction.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Guided {
        let WarpSample { point, density, .. } = self.warp.sample(u);
        let up = cosine_hemisphere(point);
        let plane = self.x * up.x + self.y * up.y;
        Guided { wi: plane.extend(up.z * self.side), density }
    }

    /// The density of the direction `wi` over that of Lambert's law; `wi` is on this side.
    #[inline]
    pub fn density(&self, wi: Vec3) -> f32 {
        self.warp.density(self.on_square(wi))
    }

    /// The density (1/sr) with which directions of `vertex`, over which this is, are drawn by the guide and the material together.
    #[inline]
    pub fn pdf(&self, vertex: &Vertex, wi: Vec3) -> f32 {
        let learned = if wi.z * self.side > 0.0 { self.share * self.density(wi) * wi.z.abs() * FRAC_1_PI } else { 0.0 };
        if self.share == 1.0 {
            return learned;
        }
        learned + (1.0 - self.share) * vertex.material.pdf(&vertex.shading, vertex.wo, wi)
    }

    /// Where the direction `wi` lies on the square.
    #[inline]
    fn on_square(&self, wi: Vec3) -> Vec2 {
        let plane = wi.truncate();
        concentric_square(Vec2::new(plane.dot(self.x), plane.dot(self.y)))
    }

    /// What is to be learned from a path that goes on in the direction `wi`, which was drawn with the density `pdf` (1/sr); `None` if that is on the other
    /// side. The light is still to be found.
    pub fn lesson(&self, wi: Vec3, pdf: f32) -> Option<Lesson> {
        let density = pdf / (wi.z.abs() * FRAC_1_PI);
        let is_lesson = wi.z * self.side > 0.0 && density > 0.0 && density.is_finite();
        is_lesson.then(|| Lesson { slot: self.slot, square: Warp::square(self.on_square(wi)) as u32, density, radiance: 0.0 })
    }
}

#[cfg(test)]
mod tests;
