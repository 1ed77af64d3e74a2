//! Light sampling in spacetimes of a refractive index: the rays between two points.
//!
//! Around one centre (`connect_plane`) there is one ray of each swept angle; two are offered, the shorter way round and the other one.
//! Among several holes the direct ray is offered, one round each hole and one round all of them, found by Newton's method (`connect_newton`)
//! from rays of simpler spacetimes, or by continuation from those (`connect_images`). What is not found is not offered.
//!
//! [`Connection::phi`] is the parameter sigma at the end, with `|dx/dsigma| = n`: together with the launch it tells rays apart.

use crate::graded_index::connect_images::{Setting, is_near};
use crate::graded_index::connect_newton::{Guess, Reached};
use crate::graded_index::course;
use crate::graded_index::sight::occluded_in;
use crate::tolerance::Tolerance;
use bhs_core::integrator::{Connection, ConnectionPair, Connections, Cost, MOST_TURNS, ShadowRay};
use bhs_core::spacetime::{Class, Place, Side, Spacetime};
use bhs_core::world::World;
use glam::DVec3;

/// Rays between two points of a spacetime of the class [`Class::Index`].
#[derive(Clone, Copy, Debug)]
pub struct GradedConnections {
    /// Pairs of rays that it offers.
    pairs: u32,
    /// How far a ray may stray from the chords that look for what stands in its way.
    tolerance: Tolerance,
}

impl GradedConnections {
    /// Those of `spacetime`, wherever it is moved to; `None` if that is not of the class.
    pub fn new(spacetime: &dyn Spacetime, tolerance: Tolerance) -> Option<Self> {
        let Class::Index(_) = spacetime.class() else { return None };
        let images = match spacetime.captures().len() {
            0 | 1 => 2,
            holes => holes + 2,
        };
        Some(Self { pairs: images.div_ceil(2).min(MOST_TURNS) as u32, tolerance })
    }

    fn images(&self) -> usize {
        2 * self.pairs as usize
    }
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
        let Some(setting) = Setting::of(world.spacetime()) else { return [None; 2] };
        let y = setting.sky(x, sky);
        let first = 2 * turn as usize;
        let images = setting.find_all([x, y], first + 2, Setting::way_out);
        let distance = setting.distance(x, y);
        let image = |i: usize| images.get(i).and_then(|i| i.as_ref()).map(|found| connection_to_sky(found, sky.0, distance));
        [image(first), image(first + 1)]
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), _: f64) -> Option<f64> {
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
