//! How light travels: the contract of the integrators of light rays.

use crate::intersector::Primitive;
use crate::spacetime::{Place, Side, Spacetime};
use crate::world::World;
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
    /// moved off it (see [`World::spawn`]).
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

/// A ray of light sampling: does anything stand between two points on a geodesic that joins them?
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowRay {
    /// The ray that leaves `from` along the geodesic, which starts on the surface there or just off it.
    pub start: Ray,
    /// Where the geodesic begins, maybe on a surface.
    pub from: DVec3,
    /// Where it ends, maybe on a surface.
    pub to: Place,
    /// The primitive on which it ends, if any.
    pub target: Option<Primitive>,
    /// The geodesic.
    pub connection: Connection,
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
    /// Angle that it sweeps around the hole (rad); 0 in flat space.
    pub phi: f64,
}

/// The largest number of pairs of geodesics that an integrator offers: each further turn around a hole makes light some 500 times
/// fainter.
pub const MOST_TURNS: usize = 3;

/// The two geodesics between a pair of points that make the same number of whole turns around the hole: first the one that goes
/// the shorter way round (in flat space the only one), then the one that goes round the other side.
pub type ConnectionPair = [Option<Connection>; 2];

/// What an integrator that can join two points offers for light sampling.
pub trait Connections: Send + Sync {
    /// How many pairs of geodesics it offers between two points, at most [`MOST_TURNS`].
    fn turns(&self) -> u32;
    /// The geodesics from `x` to `y` that make `turn` < [`Connections::turns`] whole turns, whether or not something stands in
    /// their way; `None` where there is none.
    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair;
    /// The same for each pair of points, written to the places of the rows of `found`, one a turn from 0 on: for integrators that join several
    /// pairs, or find all geodesics of a pair, faster than one after the other.
    fn connect_all(&self, world: &World, pairs: &[[Place; 2]], found: &mut [&mut [ConnectionPair]]) {
        for (turn, found) in (0..).zip(found) {
            for ([x, y], found) in pairs.iter().zip(&mut **found) {
                *found = self.connect(world, *x, *y, turn);
            }
        }
    }
    /// The spread of the geodesic that was traced from `x` in the unit chart direction `launch` to `y`, sweeping `phi` (rad): what
    /// [`Connections::connect`] says of the same one. `None` if it does not offer that one.
    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64>;
    /// The same from `x` to infinitely far away in the unit chart direction `sky.0`. The spread is the solid angle there per solid
    /// angle at `x`, both in the chart: 1 in flat space. The sky is that of the side `sky`.
    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair;
    /// The spread of the geodesic that was traced from `x` in the unit chart direction `launch` out of the scene, where it had swept `phi`
    /// (rad) and had the direction `sky.0` on the side `sky.1`: what [`Connections::connect_sky`] says of the same one. `None` if it does not offer that
    /// one.
    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64>;
    /// Whether each of `shadow_rays` is occluded, written to the places of `occluded`; and what that took, all of them together.
    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost;
}

/// Follows light in the spacetime that it was built for, in any scene.
pub trait Integrator: Send + Sync {
    /// Follows each of `rays` and writes what became of it to its place in `ends`. What becomes of a ray does not depend on the others.
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]);

    /// Follows one ray: what becomes of it is to the bit what [`Integrator::trace_all`] says.
    fn trace(&self, world: &World, ray: &Ray) -> RayEnd {
        let mut end = RayEnd::NONE;
        self.trace_all(world, std::slice::from_ref(ray), std::slice::from_mut(&mut end));
        end
    }

    /// The same, and the points of its way (render space): those between which it was put to the intersector, and as many where free space was
    /// passed over.
    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>);

    /// Whether each of `rays` leaves the scene on the side `sides`, written to the places of `escaped`; and what that took, all of them together.
    fn escape_all(&self, world: &World, rays: &[(Ray, Side)], escaped: &mut [bool]) -> Cost {
        let mut cost = Cost::default();
        for ((ray, side), escaped) in rays.iter().zip(escaped) {
            let end = self.trace(world, ray);
            cost += end.cost;
            *escaped = matches!(end.arrival, Arrival::Sky(_, on) if on == *side);
        }
        cost
    }

    /// The geodesics between two points, if this integrator can find them; where it cannot, light transport relies on
    /// BSDF sampling.
    fn connections(&self) -> Option<&dyn Connections>;
}

/// Makes integrators for spacetimes, as it was asked to in a scene. One implementation, one plugin.
pub trait IntegratorBuilder: Send + Sync {
    /// The integrator that follows light in `spacetime`.
    ///
    /// # Errors
    /// What kinds of spacetimes the method needs, if it cannot follow rays of this one.
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String>;

    /// Whether light bends under the method where there is something that bends it.
    fn is_curved(&self) -> bool {
        true
    }
}
