//! Light sampling in spacetimes of a refractive index: the rays between two points.
//!
//! Around one centre (`round`) there is one ray of each swept angle; those are offered that go the shorter way round and the other one, with so
//! many whole turns.
//! Among several holes (`several`) the direct ray is offered, one round each hole and one round all of them. What is not found is not offered.
//!
//! [`Connection::phi`] is the parameter sigma at the end, with `|dx/dsigma| = n`: together with the launch it tells rays apart.

use crate::graded_index::course;
use crate::graded_index::shadow::occluded_in;
use crate::round::profile::Profile;
use crate::round::rays::{Rays, Traced};
use crate::several::images::{To, Traced as TracedRay};
use crate::several::masses::Masses;
use crate::several::newton::Reached;
use crate::tolerance::Tolerance;
use bhs_core::ray::Cost;
use bhs_core::spacetime::{Class, Place, Side, Spacetime};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, MOST_TURNS, ShadowRay};
use bhs_engine::world::World;
use glam::DVec3;
use std::sync::Arc;

/// Rays between two points of a spacetime of the class [`Class::Index`].
#[derive(Clone, Debug)]
pub struct GradedConnections {
    /// Pairs of rays that it offers.
    pairs: u32,
    found_by: FoundBy,
    /// How far a ray may stray from the chords of its shadow ray.
    tolerance: Tolerance,
}

/// How rays are found.
#[derive(Clone, Debug)]
enum FoundBy {
    /// Around one centre.
    Angle(Arc<Profile>),
    /// Among several holes.
    Newton(Arc<Masses>),
}

impl GradedConnections {
    /// Those of `spacetime`, wherever it is moved to; `None` if that is not of the class. Around one centre, rays of less than `turns` whole turns.
    pub fn new(spacetime: &dyn Spacetime, tolerance: Tolerance, turns: u32) -> Option<Self> {
        if let Some(profile) = Profile::of_index(spacetime) {
            return Some(Self { pairs: turns.min(MOST_TURNS as u32), found_by: FoundBy::Angle(Arc::new(profile)), tolerance });
        }
        let masses = Masses::of(spacetime)?;
        let pairs = masses.images().div_ceil(2).min(MOST_TURNS) as u32;
        Some(Self { pairs, found_by: FoundBy::Newton(Arc::new(masses)), tolerance })
    }

    /// Whether there is one centre: rays are found in closed form but for a quadrature.
    pub fn are_round(&self) -> bool {
        matches!(self.found_by, FoundBy::Angle(_))
    }

    /// The round spacetime, and its centre in the coordinates of `world`.
    fn round_in(&self, world: &World) -> Option<(&Profile, DVec3)> {
        let FoundBy::Angle(round) = &self.found_by else { return None };
        let spacetime = world.spacetime();
        let Class::Index(index) = spacetime.class() else { return None };
        let center = index.throat().map_or_else(|| spacetime.captures().first().map(|ball| ball.center), |t| Some(t.center))?;
        Some((round, center))
    }

    /// The holes in the coordinates of `world`.
    fn several_in(&self, world: &World) -> Option<Masses> {
        let FoundBy::Newton(masses) = &self.found_by else { return None };
        let first = world.spacetime().captures().first()?.center;
        Some(masses.moved(first - masses.holes[0].center))
    }
}

/// `place` as seen from `center`.
fn from(center: DVec3, place: Place) -> Place {
    Place { x: place.x - center, side: place.side }
}

fn connection(found: &Reached) -> Connection {
    let guess = found.guess;
    Connection { launch: guess.launch, arrival: found.tangent.normalize(), spread: found.spread(), phi: guess.sigma }
}

/// The ray `found` from `x` to the sky in the unit direction `sky`.
fn connection_to_sky(masses: &Masses, found: &Reached, x: DVec3, sky: DVec3) -> Connection {
    let distance = (masses.target(x, To::Sky(sky)) - x).length();
    Connection { arrival: sky, spread: found.spread() / (distance * distance), ..connection(found) }
}

impl Connections for GradedConnections {
    fn turns(&self) -> u32 {
        self.pairs
    }

    fn images(&self) -> usize {
        match &self.found_by {
            FoundBy::Angle(_) => 2 * self.pairs as usize,
            FoundBy::Newton(masses) => masses.images().min(2 * MOST_TURNS),
        }
    }

    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        let mut found = [[[None; 2]; 1]; MOST_TURNS];
        let mut rows = found.each_mut().map(|row| &mut row[..]);
        self.connect_all(world, &[[x, y]], &mut rows[..self.pairs as usize]);
        found[turn as usize][0]
    }

    fn connect_all(&self, world: &World, pairs: &[[Place; 2]], found: &mut [&mut [ConnectionPair]]) {
        if let Some((profile, center)) = self.round_in(world) {
            for (k, [x, y]) in pairs.iter().enumerate() {
                let rays = Rays::between(profile, from(center, *x), from(center, *y));
                for (turn, row) in (0..).zip(&mut *found) {
                    row[k] = [0, 1].map(|way| rays.and_then(|rays| rays.connection((turn, way), false)));
                }
            }
            return;
        }
        let Some(masses) = self.several_in(world) else { return };
        // Nothing is on the far side, and nothing joins a point with itself.
        let end = |[x, y]: &[Place; 2]| (x.x, To::Point(if [x.side, y.side] == [Side::Near; 2] { y.x } else { x.x }));
        let ends: Vec<_> = pairs.iter().map(end).collect();
        let images = masses.find_all(&ends);
        for (k, images) in images.chunks(masses.images()).enumerate() {
            for (turn, row) in found.iter_mut().enumerate() {
                let image = |i: usize| images.get(i).and_then(|i| i.as_ref()).map(connection);
                row[k] = [image(2 * turn), image(2 * turn + 1)];
            }
        }
    }

    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64> {
        if let Some((profile, center)) = self.round_in(world) {
            let rays = Rays::between(profile, from(center, x), from(center, y))?;
            return Some(rays.image_of(launch, self.pairs, Traced::Sigma(phi))?.spread);
        }
        let masses = self.several_in(world)?;
        let is_near = [x.side, y.side] == [Side::Near; 2];
        let traced = TracedRay { launch, sigma: Some(phi) };
        let image = masses.image_of(x.x, To::Point(y.x), traced).filter(|_| is_near)?;
        Some(image.spread())
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        let mut found = [[[None; 2]; 1]; MOST_TURNS];
        let mut rows = found.each_mut().map(|row| &mut row[..]);
        self.connect_sky_all(world, &[(x, sky)], &mut rows[..self.pairs as usize]);
        found[turn as usize][0]
    }

    fn connect_sky_all(&self, world: &World, ends: &[(Place, (DVec3, Side))], found: &mut [&mut [ConnectionPair]]) {
        if let Some((profile, center)) = self.round_in(world) {
            for (k, (x, sky)) in ends.iter().enumerate() {
                let rays = Rays::to_sky(profile, from(center, *x), *sky);
                for (turn, row) in (0..).zip(&mut *found) {
                    row[k] = [0, 1].map(|way| rays.and_then(|rays| rays.connection((turn, way), false)));
                }
            }
            return;
        }
        let Some(masses) = self.several_in(world) else { return };
        // All images are found together: one of them may turn out to be another. There is no far side.
        let near = |(x, sky): &(Place, (DVec3, Side))| [x.side, sky.1] == [Side::Near; 2];
        let to = |end: &(Place, (DVec3, Side))| if near(end) { To::Sky(end.1.0) } else { To::Point(end.0.x) };
        let targets: Vec<_> = ends.iter().map(|end| (end.0.x, to(end))).collect();
        let images = masses.find_all(&targets);
        for (k, (images, (x, sky))) in images.chunks(masses.images()).zip(ends).enumerate() {
            for (turn, row) in found.iter_mut().enumerate() {
                let image = |i: usize| Some(connection_to_sky(&masses, images.get(i)?.as_ref()?, x.x, sky.0));
                row[k] = [image(2 * turn), image(2 * turn + 1)];
            }
        }
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), _: f64) -> Option<f64> {
        if let Some((profile, center)) = self.round_in(world) {
            return Some(Rays::to_sky(profile, from(center, x), sky)?.image_of(launch, self.pairs, Traced::Sky)?.spread);
        }
        let near = [x.side, sky.1] == [Side::Near; 2];
        let masses = self.several_in(world).filter(|_| near)?;
        let found = masses.image_of(x.x, To::Sky(sky.0), TracedRay { launch, sigma: None })?;
        Some(connection_to_sky(&masses, &found, x.x, sky.0).spread)
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let Class::Index(index) = world.spacetime().class() else {
            occluded.fill(true);
            return Cost::default();
        };
        let setting = course::GradedSetup::new(world, world.spacetime(), index);
        let end = |ray: &ShadowRay| (ray.connection.phi, setting.extent.distance(self.tolerance, ray.start.footprint));
        occluded_in(&setting, world, shadow_rays, end, occluded)
    }
}
