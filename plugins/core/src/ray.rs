//! A ray of light, where it ends, and what it took to follow it.

use crate::intersector::Primitive;
use crate::spacetime::Side;
use glam::{DVec2, DVec3};
use std::ops::AddAssign;

/// A ray of light followed from where it is seen towards where it comes from. Render space, chart direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start (scene units).
    pub origin: DVec3,
    /// Unit chart direction.
    pub direction: DVec3,
    /// The side of a wormhole on which it starts, in whose chart that is; the near one in all other spacetimes.
    pub side: Side,
    /// Width of the patch that the ray stands for where it arrives (scene units): nobody can tell apart what is closer together.
    /// 0: unknown. An integrator may stray from the true ray by a tenth of it, unless the scene says by how much.
    pub footprint: f64,
    /// The primitive on which the origin lies exactly, which the ray is not to meet there; `None` if the origin lies on none, or was
    /// moved off it (see `World::spawn` of bhs-engine).
    pub leaving: Option<Primitive>,
}

impl Ray {
    /// A ray of unknown footprint that starts on the near side, and on no surface.
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, side: Side::Near, footprint: 0.0, leaving: None }
    }
}

/// A point of a surface that a ray arrived at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The point, render space.
    pub point: DVec3,
    /// Unit chart tangent of the ray there, along its way.
    pub direction: DVec3,
    /// Index of the geometry.
    pub geometry: u32,
    /// Index of the triangle; 0 for an analytic surface.
    pub primitive: u32,
    /// Weights of the triangle's second and third corner; zero for an analytic surface.
    pub barycentric: DVec2,
    /// Whether other surfaces may be as near to the point as rounding: see [`crate::intersector::Intersector::is_crowded`].
    pub is_crowded: bool,
}

impl SurfaceHit {
    /// The triangle or analytic surface.
    #[inline]
    pub fn primitive(&self) -> Primitive {
        Primitive { geometry: self.geometry, primitive: self.primitive }
    }
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// On a surface.
    Surface(SurfaceHit),
    /// Far away, in this unit chart direction, on this side.
    Sky(DVec3, Side),
    /// Where no light comes from: behind a horizon.
    Captured,
    /// Nowhere yet: the integrator gave up after its largest number of steps.
    OutOfSteps,
}

/// What it took to follow a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Steps of the integration.
    pub steps: u32,
    /// Segments that were put to the intersector.
    pub queries: u32,
    /// Stretches of free space that were passed over without one.
    pub leaps: u32,
    /// Chords outside of the scene's bounds, which were not put to it.
    pub chords_skipped: u32,
}

impl AddAssign for Cost {
    fn add_assign(&mut self, o: Self) {
        self.steps = self.steps.saturating_add(o.steps);
        self.queries = self.queries.saturating_add(o.queries);
        self.leaps = self.leaps.saturating_add(o.leaps);
        self.chords_skipped = self.chords_skipped.saturating_add(o.chords_skipped);
    }
}

/// What became of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayEnd {
    /// Where it ended.
    pub arrival: Arrival,
    /// Its parameter there, which tells the images of one point apart: the angle swept around a hole (rad) where orbits are plane, else what
    /// grows along the ray; 0 for a straight ray.
    pub swept: f64,
    /// What that took.
    pub cost: Cost,
}

impl RayEnd {
    /// That of a ray which has not been followed.
    pub const NONE: Self =
        Self { arrival: Arrival::OutOfSteps, swept: 0.0, cost: Cost { steps: 0, queries: 0, leaps: 0, chords_skipped: 0 } };
}
