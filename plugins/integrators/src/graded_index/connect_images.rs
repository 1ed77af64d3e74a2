//! Which rays are offered between two points of spacetimes of a refractive index, and what their search begins with.

use crate::graded_index::connect_blend::{Blend, Single};
use crate::graded_index::connect_newton::{Guess, LEASH, ROUGH, Reached, Search};
use crate::graded_index::medium::Medium;
use crate::round::profile::Profile;
use crate::round::rays::Rays;
use bhs_core::spacetime::{Ball, Class, Place, Side, Spacetime};
use glam::{DQuat, DVec3};

/// Steps in which an index is changed to another.
const CONTINUATION: u32 = 4;

/// Where the mass of a hole is read off the index, over the radius of its ball of no return.
const PROBE: f64 = 0.1;

/// What bends light, and how it is simplified.
pub struct Setting<'a> {
    medium: Medium<'a>,
    /// Each hole alone.
    holes: Vec<Single>,
    /// One with the mass of all of them.
    all: Single,
}

impl<'a> Setting<'a> {
    /// That of `spacetime`, if that is of the class.
    pub fn of(spacetime: &'a dyn Spacetime) -> Option<Self> {
        let Class::Index(index) = spacetime.class() else { return None };
        let medium = Medium::new(index, spacetime.captures());
        // U = mass / rho + what hardly changes.
        let potential = |ball: &Ball, rho: f64| {
            let [a, b] = [rho, -rho].map(|rho| index.index(ball.center + DVec3::X * rho).0.sqrt().sqrt());
            0.5 * (a + b)
        };
        let hole = |ball: &Ball| {
            let rho = PROBE * ball.radius;
            let mass = 2.0 * rho * (potential(ball, rho) - potential(ball, 2.0 * rho));
            Single { center: ball.center, mass: if mass > 0.0 && mass.is_finite() { mass } else { ball.radius } }
        };
        let holes: Vec<_> = medium.captures.iter().map(hole).collect();
        let mass: f64 = holes.iter().map(|hole| hole.mass).sum();
        let center = holes.iter().map(|hole| hole.center * (hole.mass / mass)).sum();
        Some(Self { medium, holes, all: Single { center, mass } })
    }

    /// Whether rays can lead from `x` to `y`: two different places.
    pub fn joins(&self, x: Place, y: Place) -> bool {
        let is_place = |place: Place| match self.medium.throat {
            Some(throat) => (place.x - throat.center).length() >= throat.radius,
            None => place.side == Side::Near,
        };
        x != y && is_place(x) && is_place(y)
    }

    /// The distance of two places that errors are compared with.
    pub fn distance(&self, x: Place, y: Place) -> f64 {
        Search { medium: &self.medium, x, y, focus: self.medium.center }.distance()
    }

    /// How ray number `image` from `x` to `y` is looked for; `None` if there is no such number.
    ///
    /// The direct one, those round each, and that round all.
    pub fn way(&self, x: Place, y: Place, image: usize) -> Option<Way<'_>> {
        let search = |focus: DVec3| Search { medium: &self.medium, x, y, focus };
        let alone = |hole: &Single, image: usize| self.guess_around(hole, x, y, image);
        let (focus, guesses, start) = match image.checked_sub(1) {
            None => {
                let combined = alone(&self.all, 0);
                (self.all.center, [self.superposed(x, y), combined], Some(self.all))
            }
            Some(i) if i < self.holes.len() => {
                let (hole, radius) = (self.holes[i], self.medium.captures[i].radius);
                (hole.center, [alone(&Single { mass: radius, ..hole }, 1), alone(&hole, 1)], None)
            }
            Some(i) if i == self.holes.len() => (self.all.center, [None, alone(&self.all, 1)], None),
            Some(_) => return None,
        };
        let guesses: Vec<_> = guesses.into_iter().flatten().collect();
        Some(Way { search: search(focus), guesses, tolerance: ROUGH, start })
    }

    fn guess_around(&self, hole: &Single, x: Place, y: Place, image: usize) -> Option<Guess> {
        let from = |place: Place| Place { x: place.x - hole.center, side: place.side };
        let profile = Profile::of_hole(hole.mass, 0.0);
        let (launch, sigma) = Rays::between(&profile, from(x), from(y))?.rough((0, image))?;
        Some(Guess { launch, sigma })
    }

    /// The straight line, turned and made longer by as much as each of the holes alone would have it.
    fn superposed(&self, x: Place, y: Place) -> Option<Guess> {
        let way = y.x - x.x;
        let (distance, straight) = (way.length(), way.try_normalize()?);
        let (mut turn, mut sigma) = (DVec3::ZERO, distance);
        for hole in &self.holes {
            let guess = self.guess_around(hole, x, y, 0)?;
            let axis = straight.cross(guess.launch);
            turn += axis.normalize_or_zero() * axis.length().atan2(straight.dot(guess.launch));
            sigma += guess.sigma - distance;
        }
        let launch = (DQuat::from_scaled_axis(turn) * straight).normalize();
        Some(Guess { launch, sigma: sigma.max(LEAST_SIGMA * distance) })
    }

    /// A point in the direction `sky.0` of the side `sky.1`, so far away that rays which go there from `x` leave in that direction.
    pub fn sky(&self, x: Place, sky: (DVec3, Side)) -> Place {
        let distance = SKY * (x.x - self.medium.center).length().max(self.medium.far);
        Place { x: self.medium.center + sky.0 * distance, side: sky.1 }
    }

    /// [`Setting::way`] to a point of [`Setting::sky`].
    pub fn way_out(&self, x: Place, y: Place, image: usize) -> Option<Way<'_>> {
        let mut way = self.way(x, y, image)?;
        let distance = way.distance();
        // All but the distance is less than rounding.
        way.guesses.iter_mut().for_each(|guess| guess.sigma = distance);
        way.tolerance = ROUGH;
        Some(way)
    }

    /// All rays to `y` up to number `count`, each once; `way` says how they are looked for.
    pub fn find_all<'s>(
        &'s self,
        [x, y]: [Place; 2],
        count: usize,
        way: impl Fn(&'s Self, Place, Place, usize) -> Option<Way<'s>>,
    ) -> Vec<Option<Reached>> {
        let mut found: Vec<Option<Reached>> = Vec::with_capacity(count);
        if !self.joins(x, y) {
            return found;
        }
        for image in 0..count {
            let way = way(self, x, y, image);
            let new = way.and_then(|way| {
                let distance = way.distance();
                way.search().filter(|new| !found.iter().flatten().any(|old| old.is_same(&new.guess, ONCE * distance)))
            });
            found.push(new);
        }
        found
    }
}

/// Distance of a point of the sky over that of the ray's start and over the extent of what bends it.
const SKY: f64 = 1e9;

/// How far from its end a ray that was traced may be, over the distance between the ends, and surely, or maybe, be the ray that was found.
const SURELY: f64 = 1e-3;
const MAYBE: f64 = 0.3;

/// How far apart two rays that were found may be at the end, over the distance between the ends, and be one.
const ONCE: f64 = 0.01;

/// Error of a guess, over the distance, from which on nothing is looked for.
const HOPELESS: f64 = 2.0;

/// The least parameter of a guess, over the distance.
const LEAST_SIGMA: f64 = 0.3;

/// A ray that is looked for.
pub struct Way<'a> {
    search: Search<'a>,
    /// What the search begins with, in turn.
    pub guesses: Vec<Guess>,
    /// The error of the guesses, as rays.
    tolerance: f64,
    /// The spacetime of which the last guess is a ray, if it may be changed to the true one step by step.
    start: Option<Single>,
}

impl Way<'_> {
    /// The distance that errors are compared with.
    pub fn distance(&self) -> f64 {
        self.search.distance()
    }

    /// The ray, which [`is_near`] one of the guesses.
    pub fn search(&self) -> Option<Reached> {
        let [first, others @ ..] = self.guesses.as_slice() else { return None };
        if others.is_empty() {
            return self.search.run(*first, self.tolerance);
        }
        let mut guesses: Vec<_> = self.guesses.iter().map(|guess| (self.search.error(guess, self.tolerance), *guess)).collect();
        guesses.sort_by(|a, b| a.0.total_cmp(&b.0));
        let promising = guesses.iter().filter(|(error, _)| *error < HOPELESS);
        promising
            .map(|(_, guess)| self.search.run(*guess, self.tolerance))
            .find(Option::is_some)
            .flatten()
            .or_else(|| self.continued())
    }

    /// Whether `found` is the ray `traced`, which strays a little: those from rough surfaces by some 1e-4 of the size of a scene.
    pub fn leads_along(&self, found: &Reached, traced: Guess) -> bool {
        let distance = self.distance();
        let exact = || self.search.run(traced, ROUGH).is_some_and(|exact| found.is_same(&exact.guess, ONCE * distance));
        found.is_same(&traced, SURELY * distance) || (found.is_same(&traced, MAYBE * distance) && exact())
    }

    fn continued(&self) -> Option<Reached> {
        let (start, first) = (self.start?, *self.guesses.last()?);
        let (end, mut guess) = (self.search.medium.index, first);
        for step in 1..CONTINUATION {
            let blend = Blend { start, end, share: f64::from(step) / f64::from(CONTINUATION) };
            let medium = Medium { index: &blend, ..self.search.medium.clone() };
            guess = Search { medium: &medium, ..self.search }.run_roughly(guess)?;
        }
        self.search.run(guess, self.tolerance).filter(|found| first.launch.dot(found.guess.launch) > LEASH)
    }
}

/// Whether the search that begins with `guess` could end with `ray`.
pub fn is_near(guess: &Guess, ray: &Guess) -> bool {
    guess.launch.dot(ray.launch) > LEASH - 0.05
}
