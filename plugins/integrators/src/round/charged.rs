//! Light sampling around a charged hole: the rays between two points of its areal chart.
//!
//! They are found in the isotropic chart (`rays`), whose directions are those of the static observer. [`Connection::phi`] is the swept angle.

use crate::round::profile::{Profile, isotropic_radius};
use crate::round::rays::{Rays, Traced};
use crate::spherical::connections::occluded_around;
use crate::tolerance::Tolerance;
use crate::tracing::extent::Extent;
use bhs_core::observer::Observer;
use bhs_core::ray::Cost;
use bhs_core::spacetime::{Class, Place, Side, Spherical};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, MOST_TURNS, ShadowRay};
use bhs_engine::world::World;
use glam::DVec3;
use std::sync::Arc;

/// Rays between two points around a charged hole.
#[derive(Clone, Debug)]
pub struct ChargedConnections {
    profile: Arc<Profile>,
    /// Pairs of rays that it offers.
    turns: u32,
    tolerance: Tolerance,
}

/// A place in both charts.
struct Standing {
    observer: Observer,
    /// Unit vector from the centre.
    radial: DVec3,
    /// In the isotropic chart, from the centre.
    isotropic: Place,
    /// Areal radius over isotropic radius: how local lengths are larger than those of that chart.
    stretch: f64,
    lapse: f64,
}

impl Standing {
    /// `None` where nothing can stand.
    fn new(hole: &Spherical, place: Place) -> Option<Self> {
        let here = hole.at(place.x).filter(|_| place.side == Side::Near)?;
        let from_center = place.x - hole.center;
        let areal = from_center.length();
        let mass = 0.5 * hole.rs;
        let rho = isotropic_radius(areal, mass, mass * mass - hole.charge_squared);
        let radial = from_center / areal;
        Some(Self {
            observer: Observer::at_rest(&here),
            radial,
            isotropic: Place::near(radial * rho),
            stretch: areal / rho,
            lapse: here.lapse,
        })
    }

    /// The isotropic direction of an areal one.
    fn to_isotropic(&self, d: DVec3) -> DVec3 {
        (d + self.radial * ((1.0 / self.lapse - 1.0) * d.dot(self.radial))).normalize()
    }

    /// The areal direction of an isotropic one.
    fn to_areal(&self, d: DVec3) -> DVec3 {
        (d + self.radial * ((self.lapse - 1.0) * d.dot(self.radial))).normalize()
    }

    /// `found`, which leads from here, in the areal chart: to `end`, or to the sky.
    fn areal(&self, found: Connection, end: Option<&Self>) -> Connection {
        let launch = self.to_areal(found.launch);
        let arrival = end.map_or(found.arrival, |end| end.to_areal(found.arrival));
        let per_area = end.map_or(1.0, |end| end.stretch * end.stretch / end.observer.bundle_area_factor(arrival));
        let spread = found.spread * per_area * self.observer.solid_angle_factor(launch);
        Connection { launch, arrival, spread, ..found }
    }
}

fn hole(world: &World) -> Option<Spherical> {
    match world.spacetime().class() {
        Class::Spherical(hole) => Some(hole),
        _ => None,
    }
}

impl ChargedConnections {
    /// Around `hole`, wherever that is moved to; rays of less than `turns` whole turns.
    pub fn new(hole: &Spherical, tolerance: Tolerance, turns: u32) -> Self {
        Self { profile: Arc::new(Profile::of_spherical(hole)), turns: turns.min(MOST_TURNS as u32), tolerance }
    }

    /// Both rays of so many whole turns, if `from` is one end.
    fn pair(&self, from: &Standing, rays: Option<Rays<'_>>, end: Option<&Standing>, turn: u32) -> ConnectionPair {
        [0, 1].map(|way| Some(from.areal(rays.as_ref()?.connection((turn, way), true)?, end)))
    }
}

impl Connections for ChargedConnections {
    fn turns(&self) -> u32 {
        self.turns
    }

    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        let Some(hole) = hole(world) else { return [None; 2] };
        let (Some(from), Some(to)) = (Standing::new(&hole, x), Standing::new(&hole, y)) else { return [None; 2] };
        let rays = Rays::between(&self.profile, from.isotropic, to.isotropic);
        self.pair(&from, rays, Some(&to), turn)
    }

    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64> {
        let hole = hole(world)?;
        let (from, to) = (Standing::new(&hole, x)?, Standing::new(&hole, y)?);
        let rays = Rays::between(&self.profile, from.isotropic, to.isotropic)?;
        let found = rays.image_of(from.to_isotropic(launch), self.turns, Traced::Angle(phi))?;
        Some(from.areal(found, Some(&to)).spread)
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        let from = hole(world).and_then(|hole| Standing::new(&hole, x));
        let Some(from) = from else { return [None; 2] };
        let rays = Rays::to_sky(&self.profile, from.isotropic, sky);
        self.pair(&from, rays, None, turn)
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64> {
        let from = Standing::new(&hole(world)?, x)?;
        let rays = Rays::to_sky(&self.profile, from.isotropic, sky)?;
        let found = rays.image_of(from.to_isotropic(launch), self.turns, Traced::Angle(phi))?;
        Some(from.areal(found, None).spread)
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let Some(hole) = hole(world) else {
            occluded.fill(true);
            return Cost::default();
        };
        let extent = Extent::of(world);
        let gap = |ray: &ShadowRay| extent.distance(self.tolerance, ray.start.footprint);
        occluded_around(&hole, world, shadow_rays, gap, occluded)
    }
}
