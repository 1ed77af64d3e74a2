//! What a render has found out about where light comes from: at each place, how much of it from which part of the hemisphere.
//!
//! Places are the cells of a grid over the scene, each for six kinds of surfaces, by the axis that their normal is closest to. The
//! hemisphere over a surface is unrolled to a square on which Lambert's law is uniform, and a [`Warp`] of that square is what
//! directions are drawn from. It is trained by paths: the light that a path found in a direction, over the density of that direction, adds up to
//! the light from that part of the hemisphere, cosine included. Light that light sampling finds has no part in it.
//!
//! What is learned counts from the next wave of a render on, so that no sample depends on those of its own wave; sums are of
//! integers, so that they do not depend on the order in which threads add to them.
//!
//! Sources: Vorba et al. 2014, "On-line Learning of Parametric Mixture Models for Light Transport Simulation"; Mueller, Gross and Novak
//! 2017, "Practical Path Guiding for Efficient Light-Transport Simulation".

mod record;

use crate::warp::{SQUARES, Warp, WarpSample};
use bhs_core::geometry::Aabb;
use bhs_core::sampling::{concentric_square, cosine_hemisphere};
use bhs_elementary::Elementary;
use bhs_engine::scene::Vertex;
use glam::{DVec3, Vec2, Vec3};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicI64, AtomicU32, AtomicU64};

/// Cells along the longest side of the scene.
const CELLS: f64 = 16.0;
/// Mixing probability: share of the directions that follow what was learned, where much was; the others follow Lambert's law.
const MIXING_PROBABILITY: f32 = 0.7;
/// Weight of Lambert's law as a prior, in samples: after as many, half of that share is reached.
const PRIOR_WEIGHT: f32 = 200.0;
/// Least count of samples with which a cell guides.
const LEAST_SAMPLES: u32 = 16;
/// Waves that train it: later ones have little to add.
const TRAINING_WAVES: u32 = 12;

/// Slots of places: not seen yet, seen in this wave; above them, the number of the cell and two.
const UNSEEN: u32 = 0;
const SEEN: u32 = 1;

/// What was found at one place.
struct Cell {
    /// Radiance over density of the samples in each square, in the guide's unit.
    sums: [AtomicU64; SQUARES],
    samples: AtomicU32,
}

/// What a render has learned.
pub struct Guide {
    /// A corner of the grid, cells per length, and cells along each axis.
    origin: DVec3,
    per_length: f64,
    size: [usize; 3],
    slots: Vec<AtomicU32>,
    cells: Vec<Cell>,
    warps: Vec<Warp>,
    /// Units of sums in a radiance; 0 until the first wave has shown what is usual.
    units: f64,
    /// Sum and number of binary exponents of the radiances that the first wave found.
    exponents: AtomicI64,
    found: AtomicU32,
    waves: u32,
}

/// The hemisphere over a vertex, as the guide knows it.
#[derive(Clone, Copy)]
pub struct GuidedHemisphere<'a> {
    warp: &'a Warp,
    cell: Option<u32>,
    /// Axes of the square in the shading plane, and the side of the surface.
    x: Vec2,
    y: Vec2,
    side: f32,
}

/// A training record: a direction that was drawn, and what was known then. Learned from once the path has ended.
#[derive(Clone, Copy)]
pub struct TrainingRecord {
    cell: Option<u32>,
    square: u32,
    density: f32,
    /// Weight of what is found in the direction, and what the path had found before; means over the wavelengths.
    pub throughput: f32,
    /// `None` until that is known; if it never is, the path ended there.
    pub before: Option<f32>,
}

/// A direction drawn by a guide.
pub struct Guided {
    /// In the shading frame.
    pub wi: Vec3,
    /// Density over that of Lambert's law.
    pub density: f32,
    square: usize,
}

impl Guide {
    /// One that knows nothing yet of a scene whose surfaces are within `bounds` (render space).
    pub fn new(bounds: Aabb) -> Self {
        let extent = if bounds.is_empty() { DVec3::ONE } else { bounds.max - bounds.min };
        let per_length = CELLS / extent.max_element().max(f64::MIN_POSITIVE);
        let size = extent.to_array().map(|e| ((e * per_length).ceil() as usize).max(1));
        let mut slots = Vec::new();
        slots.resize_with(6 * size.iter().product::<usize>(), AtomicU32::default);
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.min };
        Self {
            origin,
            per_length,
            size,
            slots,
            cells: Vec::new(),
            warps: Vec::new(),
            units: 0.0,
            exponents: AtomicI64::new(0),
            found: AtomicU32::new(0),
            waves: 0,
        }
    }

    /// The hemisphere on the side of `wo` of `vertex`.
    #[inline]
    pub fn place(&self, vertex: &Vertex) -> GuidedHemisphere<'_> {
        self.place_at(vertex.hit.point, vertex.axes(), vertex.wo.z.signum())
    }

    /// The hemisphere on the side `side` of a surface with the shading axes `axes` at `point`.
    #[inline]
    fn place_at(&self, point: DVec3, axes: [DVec3; 3], side: f32) -> GuidedHemisphere<'_> {
        let [s, t, n] = axes.map(|a| a.as_vec3());
        let (frame, face) = ShadingSquare::new(s, t, n, side);
        let at = (point - self.origin) * self.per_length;
        let [x, y, z]: [usize; 3] = std::array::from_fn(|i| (at[i].max(0.0) as usize).min(self.size[i] - 1));
        let slot = &self.slots[((x * self.size[1] + y) * self.size[2] + z) * 6 + face];
        let cell = match slot.load(Relaxed) {
            UNSEEN => {
                slot.store(SEEN, Relaxed);
                None
            }
            SEEN => None,
            number => Some(number - 2),
        };
        let warp = cell.map_or(&Warp::UNIFORM, |c| &self.warps[c as usize]);
        GuidedHemisphere { warp, cell, x: frame.x, y: frame.y, side }
    }

    /// Whether paths still train it.
    #[inline]
    pub fn learns(&self) -> bool {
        self.waves < TRAINING_WAVES
    }

    /// Learns from a path that has found `after` altogether.
    pub fn learn(&self, record: &TrainingRecord, after: f32) {
        let radiance = record.before.map_or(0.0, |before| (after - before) / record.throughput);
        // Nothing, or nothing that can be reckoned with.
        let finds = radiance.is_normal() && radiance > 0.0;
        if self.units == 0.0 {
            if finds {
                self.exponents.fetch_add(i64::from(radiance.logarithm2().floor() as i32), Relaxed);
                self.found.fetch_add(1, Relaxed);
            }
            return;
        }
        let Some(cell) = record.cell else { return };
        let cell = &self.cells[cell as usize];
        cell.samples.fetch_add(1, Relaxed);
        if finds {
            // Up to 2^24 times the usual, so that sums have room for millions of samples.
            let share = (f64::from(radiance / record.density) * self.units).min((1_u64 << 40) as f64);
            cell.sums[record.square as usize].fetch_add(share as u64, Relaxed);
        }
    }

    /// Draws conclusions from a wave of samples.
    pub fn end_wave(&mut self) {
        if !self.learns() {
            return;
        }
        self.waves += 1;
        for slot in &mut self.slots {
            let slot = slot.get_mut();
            if *slot == SEEN {
                *slot = self.cells.len() as u32 + 2;
                self.cells.push(Cell { sums: std::array::from_fn(|_| AtomicU64::new(0)), samples: AtomicU32::new(0) });
                self.warps.push(Warp::UNIFORM);
            }
        }
        if self.units == 0.0 {
            let found = *self.found.get_mut();
            if found > 0 {
                self.units = (16.0 - *self.exponents.get_mut() as f64 / f64::from(found)).round().exponential2();
            }
            return;
        }
        for (cell, warp) in self.cells.iter_mut().zip(&mut self.warps) {
            if let Some(learned) = cell.warp() {
                *warp = learned;
            }
        }
    }
}

impl Cell {
    /// What directions are drawn from, if enough is known.
    fn warp(&mut self) -> Option<Warp> {
        let samples = *self.samples.get_mut();
        let sums = self.sums.each_mut().map(|s| *s.get_mut() as f32);
        let total: f32 = sums.iter().sum();
        if samples < LEAST_SAMPLES || total <= 0.0 {
            return None;
        }
        let mixing = MIXING_PROBABILITY * samples as f32 / (samples as f32 + PRIOR_WEIGHT);
        Some(Warp::new(&sums.map(|s| 1.0 - mixing + mixing * SQUARES as f32 * s / total)))
    }
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

impl GuidedHemisphere<'_> {
    /// Draws a direction.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Guided {
        let WarpSample { point, density, square } = self.warp.sample(u);
        let up = cosine_hemisphere(point);
        let plane = self.x * up.x + self.y * up.y;
        Guided { wi: plane.extend(up.z * self.side), density, square }
    }

    /// The density of the direction `wi` over that of Lambert's law.
    #[inline]
    pub fn density(&self, wi: Vec3) -> f32 {
        if self.cell.is_none() {
            return 1.0;
        }
        let plane = wi.truncate();
        self.warp.density(concentric_square(Vec2::new(plane.dot(self.x), plane.dot(self.y))))
    }

    /// What is to be learned from a path that goes on in the direction `guided` with the weight `throughput`.
    #[inline]
    pub fn record(&self, guided: &Guided, throughput: f32) -> TrainingRecord {
        TrainingRecord { cell: self.cell, square: guided.square as u32, density: guided.density, throughput, before: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::sampling::{mix64, unit_f32};

    fn number(i: u64) -> f32 {
        unit_f32((mix64(i) >> 32) as u32)
    }

    pub(super) fn guide() -> Guide {
        Guide::new(Aabb { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 3.0) })
    }

    const POINT: DVec3 = DVec3::new(0.3, 0.4, 2.5);

    /// Axes around a normal that is turned about it, and normals of all kinds.
    fn axes(i: u64) -> [DVec3; 3] {
        let n = DVec3::from_array([0, 1, 2].map(|k| f64::from(number(5 * i + k)) - 0.5)).normalize();
        let (s, t) = n.any_orthonormal_pair();
        let (sin, cos) = f64::from(number(5 * i + 4) * 6.0).sin_cos();
        [s * cos + t * sin, t * cos - s * sin, n]
    }

    /// Much light from one side of the vertical, some from everywhere.
    fn light(axes: &[DVec3; 3], wi: Vec3) -> f32 {
        let world = axes[0] * f64::from(wi.x) + axes[1] * f64::from(wi.y) + axes[2] * f64::from(wi.z);
        if world.x > 0.0 { 1e9 } else { 1e8 }
    }

    /// Waves of samples over a floor that looks up, drawn and learned by `threads` threads.
    pub(super) fn trained(threads: u64, waves: u64) -> Guide {
        let mut guide = guide();
        let per_wave = 6000;
        for wave in 0..waves {
            let shared = &guide;
            std::thread::scope(|scope| {
                for thread in 0..threads {
                    scope.spawn(move || {
                        for i in (0..per_wave).filter(|i| i % threads == thread) {
                            let i = wave * per_wave + i;
                            let axes = [DVec3::Z, DVec3::X, DVec3::Y];
                            let place = shared.place_at(POINT, axes, 1.0);
                            let drawn = place.sample(Vec2::new(number(2 * i), number(2 * i + 1)));
                            let mut record = place.record(&drawn, 0.5);
                            record.before = Some(2.0);
                            shared.learn(&record, 2.0 + 0.5 * light(&axes, drawn.wi));
                        }
                    });
                }
            });
            guide.end_wave();
        }
        guide
    }

    #[test]
    fn directions_have_the_density_that_is_said_whatever_the_axes() {
        let warp = Warp::new(&std::array::from_fn(|i| 0.01 + number(i as u64)));
        let guide = guide();
        for i in 0..2000 {
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let place = GuidedHemisphere { warp: &warp, cell: Some(0), ..guide.place_at(POINT, axes(i), side) };
            let drawn = place.sample(Vec2::new(number(7 * i), number(7 * i + 1)));
            assert!((drawn.wi.length() - 1.0).abs() < 1e-5 && drawn.wi.z * side >= 0.0);
            // Beside the edge of a square, rounding may decide for the other one.
            let near = [-1e-4, 1e-4].iter().any(|d| {
                let moved = (drawn.wi + Vec3::new(*d, -*d, 0.0)).normalize();
                place.density(moved) != place.density(drawn.wi)
            });
            assert!(near || place.density(drawn.wi) == drawn.density, "{i}");
            // Other axes around the same normal.
            let [s, t, n] = axes(i);
            let turned = GuidedHemisphere { warp: &warp, cell: Some(0), ..guide.place_at(POINT, [t, -s, n], side) };
            let wi = Vec3::new(drawn.wi.y, -drawn.wi.x, drawn.wi.z);
            assert!(near || turned.density(wi) == drawn.density, "{i}");
        }
    }

    #[test]
    fn what_is_learned_is_the_light() {
        let guide = trained(1, 4);
        let axes = [DVec3::Z, DVec3::X, DVec3::Y];
        let place = guide.place_at(POINT, axes, 1.0);
        // Two waves have trained the third and last one: half of the hemisphere has ten times the light of the other half.
        let samples = 12_000.0;
        let mixing = MIXING_PROBABILITY * samples / (samples + PRIOR_WEIGHT);
        let [bright, dim] = [1.0, 0.1].map(|light| 1.0 - mixing + mixing * light / 0.55);
        for i in 0..500 {
            let wi = cosine_hemisphere(Vec2::new(number(3 * i), number(3 * i + 1)));
            let expected = if light(&axes, wi) == 1e9 { bright } else { dim };
            let found = place.density(wi);
            assert!((found / expected - 1.0).abs() < 0.35, "{wi}: {found} {expected}");
        }
        // Nothing is known of another place, nor of the other side.
        for other in [guide.place_at(DVec3::ONE, axes, 1.0), guide.place_at(POINT, axes, -1.0)] {
            assert_eq!(other.density(Vec3::new(0.0, 0.6, 0.8)), 1.0);
        }
    }

    #[test]
    fn threads_do_not_change_what_is_learned() {
        let [one, many] = [1, 5].map(|threads| trained(threads, 4));
        assert_eq!(one.units, many.units);
        assert!(one.warps.len() == 1 && many.warps.len() == 1);
        assert_eq!(format!("{:?}", one.warps), format!("{:?}", many.warps));
    }
}
