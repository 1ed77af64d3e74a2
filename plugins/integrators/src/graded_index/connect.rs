//! Light sampling in spacetimes of a refractive index: the rays between two points.
//!
//! Around one centre (`round`) there is one ray of each swept angle; those are offered that go the shorter way round and the other one, with so
//! many whole turns.
//! Among several holes the direct ray is offered, one round each hole and one round all of them, found by Newton's method (`connect_newton`)
//! from rays of simpler spacetimes, or by continuation from those (`connect_images`). What is not found is not offered.
//!
//! [`Connection::phi`] is the parameter sigma at the end, with `|dx/dsigma| = n`: together with the launch it tells rays apart.

use crate::graded_index::connect_images::{Setting, is_near};
use crate::graded_index::connect_newton::{Guess, Reached};
use crate::graded_index::course;
use crate::graded_index::sight::occluded_in;
use crate::round::profile::Profile;
use crate::round::rays::{Rays, Traced};
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
    /// What is round, and one centre of it.
    round: Option<Arc<Profile>>,
    /// How far a ray may stray from the chords that look for what stands in its way.
    tolerance: Tolerance,
}

impl GradedConnections {
    /// Those of `spacetime`, wherever it is moved to; `None` if that is not of the class. Around one centre, rays of less than `turns` whole turns.
    pub fn new(spacetime: &dyn Spacetime, tolerance: Tolerance, turns: u32) -> Option<Self> {
        let Class::Index(_) = spacetime.class() else { return None };
        let round = Profile::of_index(spacetime).map(Arc::new);
        let pairs = match &round {
            Some(_) => turns.min(MOST_TURNS as u32),
            None => (spacetime.captures().len() + 2).div_ceil(2).min(MOST_TURNS) as u32,
        };
        Some(Self { pairs, round, tolerance })
    }

    /// Whether there is one centre: rays are found in closed form but for a quadrature.
    pub fn are_round(&self) -> bool {
        self.round.is_some()
    }

    /// The round spacetime, and its centre in the coordinates of `world`.
    fn round_in(&self, world: &World) -> Option<(&Profile, DVec3)> {
        let round = self.round.as_deref()?;
        let spacetime = world.spacetime();
        let Class::Index(index) = spacetime.class() else { return None };
        let center = index.throat().map_or_else(|| spacetime.captures().first().map(|ball| ball.center), |t| Some(t.center))?;
        Some((round, center))
    }

    fn images(&self) -> usize {
        2 * self.pairs as usize
    }
}

/// `place` as seen from `center`.
fn from(center: DVec3, place: Place) -> Place {
    Place { x: place.x - center, side: place.side }
}

fn connection(found: &Reached) -> Connection {
    let Guess { launch, sigma } = found.guess;
    Connection { launch, arrival: found.tangent.normalize(), spread: found.spread, phi: sigma }
}

/// The ray `found` to a point of the sky in the direction `sky`, which is `distance` away.
fn connection_to_sky(found: &Reached, sky: DVec3, distance: f64) -> Connection {
    Connection { arrival: sky, spread: found.spread / (distance * distance), ..connection(found) }
}

impl Connections for GradedConnections {
    fn turns(&self) -> u32 {
        self.pairs
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
        let setting = Setting::of(world.spacetime());
        for (k, pair) in pairs.iter().enumerate() {
            // All images are found together: one of them may turn out to be another.
            let images = setting.as_ref().map_or_else(Vec::new, |s| s.find_all(*pair, self.images(), Setting::way));
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
        let setting = Setting::of(world.spacetime())?;
        if !setting.joins(x, y) {
            return None;
        }
        let traced = Guess { launch, sigma: phi };
        (0..self.images()).find_map(|image| {
            let way = setting.way(x, y, image)?;
            // What a search may end with says which rays it does not find.
            let may_be = way.guesses.iter().any(|guess| is_near(guess, &traced));
            let found = if may_be { way.search() } else { None };
            found.filter(|found| way.leads_along(found, traced)).map(|found| found.spread)
        })
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        if let Some((profile, center)) = self.round_in(world) {
            let rays = Rays::to_sky(profile, from(center, x), sky);
            return [0, 1].map(|way| rays.and_then(|rays| rays.connection((turn, way), false)));
        }
        let Some(setting) = Setting::of(world.spacetime()) else { return [None; 2] };
        let y = setting.sky(x, sky);
        let first = 2 * turn as usize;
        let images = setting.find_all([x, y], first + 2, Setting::way_out);
        let distance = setting.distance(x, y);
        let image = |i: usize| images.get(i).and_then(|i| i.as_ref()).map(|found| connection_to_sky(found, sky.0, distance));
        [image(first), image(first + 1)]
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), _: f64) -> Option<f64> {
        if let Some((profile, center)) = self.round_in(world) {
            return Some(Rays::to_sky(profile, from(center, x), sky)?.image_of(launch, self.pairs, Traced::Sky)?.spread);
        }
        let setting = Setting::of(world.spacetime())?;
        let y = setting.sky(x, sky);
        if !setting.joins(x, y) {
            return None;
        }
        (0..self.images()).find_map(|image| {
            let way = setting.way_out(x, y, image)?;
            let may_be = way.guesses.iter().any(|guess| is_near(guess, &Guess { launch, ..*guess }));
            let found = if may_be { way.search() } else { None };
            // The parameter at the end says nothing.
            let found = found.filter(|found| way.leads_along(found, Guess { launch, ..found.guess }))?;
            Some(connection_to_sky(&found, sky.0, way.distance()).spread)
        })
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let Class::Index(index) = world.spacetime().class() else {
            occluded.fill(true);
            return Cost::default();
        };
        let setting = course::Setting::new(world, world.spacetime(), index);
        let end = |ray: &ShadowRay| (ray.connection.phi, setting.extent.distance(self.tolerance, ray.start.footprint));
        occluded_in(&setting, world, shadow_rays, end, occluded)
    }
}
