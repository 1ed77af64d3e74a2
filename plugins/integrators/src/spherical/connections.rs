//! Light sampling around the hole: what all curved integrators offer for it.
//!
//! The geodesics between two points come in closed form (`connect.rs`), whatever integrator follows the rays; what stands in
//! their way is found by the same chords as for any ray. The orbit between the ends is a Taylor series: it only has to be as
//! precise as the chords, and its points cost a tenth of those of the closed form.

use crate::spherical::arc::gap_of_angle;
use crate::spherical::connect::sky::{connect_sky, spread_sky};
use crate::spherical::connect::{MOST_IMAGES, connect_pair, connect_pairs, spread_of};
use crate::spherical::course::SphericalSetup;
use crate::straight::Straight;
use crate::tolerance::Tolerance;
use crate::tracing::extent::Extent;
use crate::tracing::shadow::{ERROR, Sought, close};
use crate::tracing::surfaces::Surfaces;
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::params::Params;
use bhs_core::ray::Cost;
use bhs_core::spacetime::{Class, Place, Side, Spherical};
use bhs_engine::connections::{ConnectionPair, Connections, ShadowRay};
use bhs_engine::world::World;
use glam::DVec3;

/// How long the chords along a connection may be.
#[derive(Clone, Copy, Debug)]
pub enum Chord {
    /// An angle (rad).
    Angle(f64),
    /// As long as the ray strays from them by no more than this.
    Tolerance(Tolerance),
}

/// Geodesics between two points around a hole.
#[derive(Clone, Copy, Debug)]
pub struct SphericalConnections {
    /// Pairs of geodesics that light sampling looks for: 1 plus the greatest number of whole turns around the hole.
    pub turns: u32,
    /// The chords of shadow rays.
    pub chord: Chord,
}

/// The parameter `windings`, plus 1.
pub fn read_turns(p: &Params) -> u32 {
    let most = i64::from(MOST_IMAGES / 2 - 1);
    let windings = p.get_in("windings", 0, 0..=most, "", "whole turns around the hole of the longest light that is sampled");
    windings as u32 + 1
}

fn hole(world: &World) -> Option<Spherical> {
    match world.spacetime().class() {
        Class::Spherical(hole) if hole.charge_squared == 0.0 => Some(hole),
        _ => None,
    }
}

impl Connections for SphericalConnections {
    fn turns(&self) -> u32 {
        self.turns
    }

    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        match hole(world) {
            Some(hole) => connect_pair(&hole, x.x, y.x, turn),
            None => Straight.connect(world, x, y, turn),
        }
    }

    fn connect_all(&self, world: &World, pairs: &[[Place; 2]], found: &mut [&mut [ConnectionPair]]) {
        let Some(hole) = hole(world) else { return Straight.connect_all(world, pairs, found) };
        for (turn, found) in (0..).zip(found) {
            connect_pairs(&hole, pairs, turn, found);
        }
    }

    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64> {
        match hole(world) {
            Some(hole) => spread_of(&hole, x.x, launch, y.x, phi, 2 * self.turns),
            None => Straight.spread(world, x, launch, y, phi),
        }
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        match hole(world) {
            Some(hole) => connect_sky(&hole, x.x, sky.0, turn),
            None => Straight.connect_sky(world, x, sky, turn),
        }
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64> {
        match hole(world) {
            Some(hole) => spread_sky(&hole, x.x, launch, sky.0, phi, 2 * self.turns),
            None => Straight.spread_sky(world, x, launch, sky, phi),
        }
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let Some(hole) = hole(world) else { return Straight.occluded_all(world, shadow_rays, occluded) };
        let extent = Extent::of(world);
        let gap = |ray: &ShadowRay| match self.chord {
            Chord::Angle(angle) => gap_of_angle(hole.rs, angle),
            Chord::Tolerance(t) => extent.distance(t, ray.start.footprint),
        };
        occluded_around(&hole, world, shadow_rays, gap, occluded)
    }
}

/// Whether each of `shadow_rays` around `hole` is occluded; `gap` says how far the chords of each may stray from it (scene units).
///
/// Their orbits are Taylor series: they only have to be as precise as the chords, and their points cost a tenth of those of the closed form.
pub(crate) fn occluded_around(
    hole: &Spherical,
    world: &World,
    shadow_rays: &[ShadowRay],
    gap: impl Fn(&ShadowRay) -> f64,
    occluded: &mut [bool],
) -> Cost {
    let setting = SphericalSetup::new(hole, Extent::of(world).around(hole.center));
    let surfaces = Surfaces::of(world);
    let mut cost = Cost::default();
    for (rays, occluded) in shadow_rays.chunks(LANES).zip(occluded.chunks_mut(LANES)) {
        let sought = Sought::<Lanes>::new(rays, |ray| (limit(hole, ray), gap(ray)));
        let mut course = setting.launch(sought.x, sought.d).by_series(Lanes::splat(ERROR));
        cost += sought.occluded((world, &surfaces), rays, &mut course, occluded);
    }
    cost
}

/// The angle after which a shadow ray ends, just before its end: by d phi/d s = sin(beta)/r.
fn limit(hole: &Spherical, ray: &ShadowRay) -> f64 {
    let from_center = ray.to.x - hole.center;
    let r = from_center.length();
    let sin = ray.connection.arrival.cross(from_center).length() / r;
    (ray.connection.phi - close(ray) * sin / r).max(0.0)
}
