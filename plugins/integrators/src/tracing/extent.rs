//! How large the surfaces of a world are, those of both sides together, and what that says of precision.

use crate::tolerance::Tolerance;
use bhs_core::geometry::Aabb;
use bhs_core::spacetime::{Ball, Side};
use bhs_engine::world::World;
use glam::DVec3;

/// Largest relative error of a ray. More precise ones cost little, and then hits are right to this, however coarse the chords: those decide
/// only which surface is met.
const LARGEST_ERROR: f64 = 1e-6;

/// The same where there is no surface to give distances a scale: far below a pixel.
const SKY_ERROR: f64 = 1e-7;

/// Share of the tolerance that the error of a ray may take up; the chords may have the rest.
const SHARE: f64 = 0.25;

/// Tolerance over footprint.
const TOLERANCE_PER_FOOTPRINT: f64 = 0.1;

/// Tolerance of a ray of unknown footprint, relative to the diagonal of the box around all surfaces.
const UNKNOWN_FOOTPRINT: f64 = 1e-4;

/// The size of what can be met.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// A ball around all surfaces of both sides; of radius 0 without any.
    pub reach: Ball,
    /// A box around them.
    bounds: Aabb,
    /// The larger diagonal of the boxes around the surfaces of each side (scene units); 0 without any.
    pub diagonal: f64,
}

/// How precisely a ray is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Error of the ray over the distance from what bends it.
    pub error: f64,
    /// Largest distance between the ray and its chords (scene units).
    pub gap: f64,
}

impl Extent {
    /// That of `world`.
    pub fn of(world: &World) -> Self {
        let mut all = Aabb::EMPTY;
        let mut diagonal = 0.0f64;
        for half in [Side::Near, Side::Far].into_iter().filter_map(|side| world.half(side)).filter(|h| !h.bounds.is_empty()) {
            let bounds = half.bounds.grown(half.margin);
            all = all.union(bounds);
            diagonal = diagonal.max((bounds.max - bounds.min).length());
        }
        let reach = if all.is_empty() {
            Ball { center: DVec3::ZERO, radius: 0.0 }
        } else {
            Ball { center: all.center(), radius: 0.5 * (all.max - all.min).length() }
        };
        Self { reach, bounds: all, diagonal }
    }

    /// Distance from `center` within which all surfaces lie (scene units); 0 without any.
    pub fn around(&self, center: DVec3) -> f64 {
        let farthest = || (self.bounds.min - center).abs().max((self.bounds.max - center).abs()).length();
        if self.diagonal > 0.0 { farthest() } else { 0.0 }
    }

    /// The distance (scene units) by which what is traced of a ray of the given footprint may stray from it.
    pub fn distance(&self, tolerance: Tolerance, footprint: f64) -> f64 {
        match tolerance {
            Tolerance::Absolute(t) => t,
            Tolerance::Footprint if self.diagonal == 0.0 => f64::INFINITY,
            Tolerance::Footprint if footprint > 0.0 => TOLERANCE_PER_FOOTPRINT * footprint,
            Tolerance::Footprint => UNKNOWN_FOOTPRINT * self.diagonal,
        }
    }

    /// How precisely a ray of the given footprint is followed around `center`.
    pub fn precision(&self, tolerance: Tolerance, footprint: f64, center: DVec3) -> Precision {
        let (distance, around) = (self.distance(tolerance, footprint), self.around(center));
        if around > 0.0 {
            let error = (SHARE * distance / around).min(LARGEST_ERROR);
            Precision { error, gap: distance - error * around }
        } else {
            Precision {
                error: SKY_ERROR.min(match tolerance {
                    Tolerance::Absolute(t) => t,
                    Tolerance::Footprint => SKY_ERROR,
                }),
                gap: distance,
            }
        }
    }
}

/// A distance from `point` of the near side, in any direction, within which there is no surface of it (scene units).
pub fn free_around(world: &World, point: DVec3) -> f64 {
    match world.half(Side::Near) {
        Some(half) if half.bounds.is_empty() => f64::INFINITY,
        Some(half) => match half.clearance {
            Some(clearance) => clearance.at(point),
            None => {
                let bounds = half.bounds.grown(half.margin);
                point.distance(point.clamp(bounds.min, bounds.max))
            }
        },
        None => f64::INFINITY,
    }
}
