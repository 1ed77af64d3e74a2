//! How light travels: the contract of the integrators of light rays.

use crate::blackhole::Observer;
use crate::stats::TraceLog;
use crate::world::World;
use glam::{DVec2, DVec3};

/// A ray of light followed from where it is seen towards where it comes from. Render space, chart direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start (scene units).
    pub origin: DVec3,
    /// Unit chart direction.
    pub direction: DVec3,
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
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// On a surface.
    Surface(SurfaceHit),
    /// Far away, in this unit chart direction.
    Sky(DVec3),
    /// Behind the horizon.
    Hole,
    /// Nowhere yet: the integrator gave up after its largest number of steps.
    OutOfSteps,
}

/// A geodesic that joins two points `x` and `y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Unit chart direction in which it leaves `x`.
    pub launch: DVec3,
    /// Unit chart direction in which it arrives at `y`.
    pub arrival: DVec3,
    /// Area across the bundle at `y` per solid angle at `x`, both in the chart (scene units^2/sr); distance^2 in flat space.
    pub spread: f64,
}

/// What an integrator that can join two points offers for light sampling.
pub trait Connections: Send + Sync {
    /// How many geodesics it looks for between two points; the first is the direct one.
    fn images(&self) -> u32;
    /// Geodesic number `image` from `x` to `y`, whether or not something stands in its way; `None` if there is none.
    fn connect(&self, world: &World, x: DVec3, y: DVec3, image: u32) -> Option<Connection>;
    /// The spread of the geodesic that was traced from `ray` to `hit`: what [`Connections::connect`] says of the same one.
    fn spread(&self, world: &World, ray: &Ray, hit: &SurfaceHit) -> f64;
    /// Whether nothing stands between `x` and `y` (which may lie on surfaces themselves) on `connection`; `start` is the
    /// ray that leaves `x` along it, moved off the surface there.
    fn visible(&self, world: &World, start: &Ray, y: DVec3, connection: &Connection, log: &mut TraceLog) -> bool;
}

/// Follows light. One implementation, one plugin; any of them works in any scene.
pub trait Integrator: Send + Sync {
    /// Follows `ray` to where it ends.
    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival;

    /// Who measures light at `point`: [`Observer::FLAT`] for an integrator that knows no gravity, the static observer
    /// otherwise; `None` where there is none (inside the horizon).
    fn observer(&self, world: &World, point: DVec3) -> Option<Observer>;

    /// The geodesics between two points, if this integrator can find them; where it cannot, light transport lives on
    /// emission found by chance.
    fn connections(&self) -> Option<&dyn Connections>;

    /// Whether light bends under this integrator if there is a hole.
    fn is_curved(&self) -> bool;
}
