//! Which rays are offered between two points among several holes, and what their search begins with.
//!
//! The direct one, one round each hole, one round all of them. Their guesses are rays around one hole (`round`).

use crate::round::profile::Profile;
use crate::round::rays::Rays;
use crate::several::masses::Masses;
use crate::several::newton::{Guess, LEASH, Reached, Search, run_all};
use bhs_core::spacetime::Place;
use bhs_elementary::{Elementary, rotation};
use glam::DVec3;

/// Distance of a point of the sky over that of the ray's start and over the extent of what bends it.
const SKY: f64 = 1e9;

/// How far from its end a ray that was traced may be, over the distance between the ends, and surely, or maybe, be the ray that was found.
const SURELY: f64 = 1e-3;
const MAYBE: f64 = 0.3;

/// How far apart two rays that were found may be at the end, over the distance between the ends, and be one.
const ONCE: f64 = 0.01;

/// The least parameter of a guess, over the distance.
const LEAST_SIGMA: f64 = 0.3;

/// Where rays are to lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum To {
    /// To a point.
    Point(DVec3),
    /// To the sky in this unit direction.
    Sky(DVec3),
}

/// A ray that was traced.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// Unit chart direction in which it left.
    pub launch: DVec3,
    /// The parameter at its end; `None` if it has left.
    pub sigma: Option<f64>,
}

impl Masses {
    /// How many rays are offered.
    pub fn images(&self) -> usize {
        self.holes.len() + 2
    }

    /// The point that `to` is, from `x`.
    pub fn target(&self, x: DVec3, to: To) -> DVec3 {
        match to {
            To::Point(y) => y,
            // So far away that rays which go there leave in that direction.
            To::Sky(sky) => self.center + sky * (SKY * (x - self.center).length().max(self.extent)),
        }
    }

    /// How ray number `image` is looked for.
    fn search(&self, x: DVec3, to: To, image: usize) -> Search {
        let y = self.target(x, to);
        let around = |center: DVec3, mass: f64, way: usize| guess_around(center, mass, x, y, way);
        let (focus, mut guesses) = match image {
            0 => (self.center, [self.superposed(x, y), around(self.center, self.mass, 0)]),
            i if i <= self.holes.len() => {
                let hole = self.holes[i - 1];
                (hole.center, [around(hole.center, hole.radius, 1), around(hole.center, hole.mass, 1)])
            }
            _ => (self.center, [around(self.center, self.mass, 1), None]),
        };
        if guesses[0].is_none() {
            guesses.swap(0, 1);
        }
        if let To::Sky(_) = to {
            // All but the distance is less than rounding.
            let distance = (y - x).length();
            guesses.iter_mut().flatten().for_each(|guess| guess.sigma = distance);
        }
        Search { x, y, focus, guesses }
    }

    /// The straight line, turned and made longer by as much as each of the holes alone would have it.
    fn superposed(&self, x: DVec3, y: DVec3) -> Option<Guess> {
        let way = y - x;
        let (distance, straight) = (way.length(), way.try_normalize()?);
        let (mut turn, mut sigma) = (DVec3::ZERO, distance);
        for hole in &self.holes {
            let guess = guess_around(hole.center, hole.mass, x, y, 0)?;
            let axis = straight.cross(guess.launch);
            turn += axis.normalize_or_zero() * axis.length().arctangent2(straight.dot(guess.launch));
            sigma += guess.sigma - distance;
        }
        let launch = (rotation(turn.normalize_or_zero(), turn.length()) * straight).normalize();
        Some(Guess { launch, sigma: sigma.max(LEAST_SIGMA * distance) })
    }

    /// All rays between each of `pairs`, each ray once, one row of [`Masses::images`] a pair.
    pub fn find_all(&self, pairs: &[(DVec3, To)]) -> Vec<Option<Reached>> {
        let count = self.images();
        let joined = pairs.iter().filter(|(x, to)| *to != To::Point(*x));
        let searches: Vec<Search> = joined
            .flat_map(|&(x, to)| (0..count).map(move |image| (x, to, image)))
            .map(|(x, to, image)| self.search(x, to, image))
            .collect();
        let mut answers = run_all(self, &searches).into_iter().zip(&searches);
        let mut found: Vec<Option<Reached>> = Vec::with_capacity(count * pairs.len());
        for (x, to) in pairs {
            let first = found.len();
            for _ in 0..count {
                let answer = if *to == To::Point(*x) { None } else { answers.next() };
                let new = answer.and_then(|(new, search)| {
                    let within = ONCE * search.distance();
                    new.filter(|new| !found[first..].iter().flatten().any(|old| old.is_same(&new.guess, within)))
                });
                found.push(new);
            }
        }
        found
    }

    /// The ray that [`Masses::find_all`] finds and that `traced`, which strays a little, is.
    pub fn image_of(&self, x: DVec3, to: To, traced: Traced) -> Option<Reached> {
        if to == To::Point(x) {
            return None;
        }
        // What a search may end with says which rays it does not find.
        let may_be = |guess: &Guess| guess.launch.dot(traced.launch) > LEASH - 0.05;
        let searches = (0..self.images()).map(|image| self.search(x, to, image));
        let searches: Vec<Search> = searches.filter(|search| search.guesses.iter().flatten().any(may_be)).collect();
        let found = run_all(self, &searches);
        found.into_iter().zip(&searches).find_map(|(found, search)| {
            let found = found?;
            let guess = Guess { launch: traced.launch, sigma: traced.sigma.unwrap_or(found.guess.sigma) };
            self.leads_along(&found, search, guess).then_some(found)
        })
    }

    /// Whether `found` is the ray `traced`: those from rough surfaces stray by some 1e-4 of the size of a scene.
    fn leads_along(&self, found: &Reached, search: &Search, traced: Guess) -> bool {
        let distance = search.distance();
        let exact = || {
            let again = Search { guesses: [Some(traced), None], ..*search };
            run_all(self, &[again])[0].is_some_and(|exact| found.is_same(&exact.guess, ONCE * distance))
        };
        found.is_same(&traced, SURELY * distance) || (found.is_same(&traced, MAYBE * distance) && exact())
    }
}

/// The ray around a hole alone, the shorter way (0) or the other one.
fn guess_around(center: DVec3, mass: f64, x: DVec3, y: DVec3, way: usize) -> Option<Guess> {
    let profile = Profile::of_hole(mass, 0.0);
    let [x, y] = [x, y].map(|place| Place::near(place - center));
    let (launch, sigma) = Rays::between(&profile, x, y)?.rough((0, way))?;
    (launch.is_finite() && sigma > 0.0 && sigma.is_finite()).then_some(Guess { launch, sigma })
}
