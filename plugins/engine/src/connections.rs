//! Geodesics that join two points, for light sampling (next-event estimation).

use crate::world::World;
use bhs_core::intersector::Primitive;
use bhs_core::ray::{Cost, Ray};
use bhs_core::spacetime::{Place, Side};
use glam::DVec3;

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

/// Where a geodesic is to end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// At a point.
    Point(Place),
    /// Infinitely far away, in this unit chart direction on this side.
    Sky((DVec3, Side)),
}

/// What an integrator that can join two points offers for light sampling.
pub trait Connections: Send + Sync {
    /// How many pairs of geodesics it offers between two points, at most [`MOST_TURNS`].
    fn turns(&self) -> u32;
    /// How many geodesics it looks for between two points, at most two a turn.
    fn images(&self) -> usize {
        2 * self.turns() as usize
    }
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
    /// The same for each of `ends`, a place and a direction of the sky, written to the places of the rows of `found`, one a turn from 0 on.
    fn connect_sky_all(&self, world: &World, ends: &[(Place, (DVec3, Side))], found: &mut [&mut [ConnectionPair]]) {
        for (turn, found) in (0..).zip(found) {
            for ((x, sky), found) in ends.iter().zip(&mut **found) {
                *found = self.connect_sky(world, *x, *sky, turn);
            }
        }
    }
    /// The spread of the geodesic that was traced from `x` in the unit chart direction `launch` out of the scene, where it had swept `phi`
    /// (rad) and had the direction `sky.0` on the side `sky.1`: what [`Connections::connect_sky`] says of the same one. `None` if it does not offer that
    /// one.
    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64>;
    /// Whether geodesics are so dear that only those should be looked for that promise something: [`Connections::connect_chosen`].
    fn is_dear(&self) -> bool {
        false
    }
    /// The pair without whole turns of each of `ends`, written to its place in `found`: of each the geodesics that `choose` asks for, which is told
    /// its number and about what they would be. That may be far from what is found, and what is not foretold is not found.
    fn connect_chosen(
        &self,
        world: &World,
        ends: &[(Place, End)],
        choose: &mut dyn FnMut(usize, &ConnectionPair) -> [bool; 2],
        found: &mut [ConnectionPair],
    ) {
        for (k, ((x, end), found)) in ends.iter().zip(found).enumerate() {
            let pair = match *end {
                End::Point(y) => self.connect(world, *x, y, 0),
                End::Sky(sky) => self.connect_sky(world, *x, sky, 0),
            };
            let chosen = choose(k, &pair);
            *found = [0, 1].map(|i| pair[i].filter(|_| chosen[i]));
        }
    }
    /// Whether each of `shadow_rays` is occluded, written to the places of `occluded`; and what that took, all of them together.
    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost;
}
