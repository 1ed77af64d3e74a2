//! Rays from point to point by Newton's method, with neighbours of the ray as derivatives (`docs/physics.md`, section 6).

use crate::graded_index::bundle::Bundle;
use crate::graded_index::medium::Medium;
use crate::graded_index::path::Paths;
use crate::tracing::arc::Arc;
use bhs_core::real::Vector;
use bhs_core::spacetime::{Ball, Place, Side};
use glam::{DMat3, DVec3};

/// A ray to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Guess {
    /// Unit chart direction in which it leaves.
    pub launch: DVec3,
    /// The parameter at its end.
    pub sigma: f64,
}

/// A ray followed to some parameter.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// How it was launched, and for how long it was followed.
    pub guess: Guess,
    /// Where it is.
    pub place: Place,
    /// Its tangent there, of length n.
    pub tangent: DVec3,
    /// Directions at right angles to the launch.
    pub axes: [DVec3; 2],
    /// Derivatives of the point by the angles of a launch towards those.
    pub aside: [DVec3; 2],
    /// The error that it was followed with, over the distance from the nearest hole.
    pub tolerance: f64,
    /// Chart area across the bundle over chart solid angle of the launch.
    pub spread: f64,
}

/// Errors of rays, over the distance from the nearest hole: of those that are far from where they are to go, and of those that come near.
pub const ROUGH: f64 = 1e-6;
/// See [`ROUGH`].
pub const FINE: f64 = 1e-11;

/// Steps after which a ray is given up.
const MOST_STEPS: u32 = 400;

/// Nearer than this to a hole, over the radius of its ball of no return, rays are given up.
const NEAREST: f64 = 1e-4;

/// Rays of one search, and lengths of one step that are tried.
const FOLLOWS: u32 = 16;
const HALVINGS: u32 = 4;

/// By how much the error has to become less in a step.
const SLOW: f64 = 0.7;

/// The largest change of the parameter in one step, over the parameter.
const MOST_LONGER: f64 = 0.7;

/// The largest change of the launch in one step (rad).
const MOST_TURNED: f64 = 0.5;

/// Error, over the distance, at which the search goes on with fine rays.
const NEAR: f64 = 1e-3;

/// Error, over the distance, at which it ends, and the rounding of it over the distance from the centre.
const FOUND: f64 = 1e-10;
const ROUNDING: f64 = 1e-14;

/// Error, over the distance, that will do if no step makes it less.
const STALLED: f64 = 1e-9;

/// Follows the ray from `x` to its parameter `guess.sigma`; `None` if it runs into a hole or cannot be followed. `each` is told of every step
/// before that of the end: its length in the parameter, and whether it ends on the throat. The end is a place, the tangent there, of length n,
/// and how far it is from the last step.
fn walk(
    paths: &mut Paths<'_, f64>,
    medium: &Medium<'_>,
    sigma: f64,
    mut each: impl FnMut(f64, bool),
) -> Option<(Place, DVec3, f64)> {
    for _ in 0..MOST_STEPS {
        let side = paths.side(0);
        let advance = paths.advance(true);
        let arc = advance.arc;
        let is_outside = |b: &Ball| (DVec3::from(paths.state.x) - b.center).length() > NEAREST * b.radius;
        if advance.lost || !medium.captures.iter().all(is_outside) {
            return None;
        }
        if arc.end() >= sigma {
            let (point, tangent): (Vector<f64>, _) = arc.point_and_tangent(sigma);
            return Some((Place { x: point.into(), side }, tangent.into(), sigma - arc.start()));
        }
        each(arc.end() - arc.start(), advance.crossed);
    }
    None
}

/// A ray from `x` that is to be followed to `guess.sigma`; `None` if it cannot be.
fn start<'a>(medium: &'a Medium<'a>, x: Place, guess: &Guess, tolerance: f64) -> Option<Paths<'a, f64>> {
    // Nothing leaves for ever before it is where it is to go.
    let reach = Ball { center: medium.center, radius: f64::MAX.sqrt() };
    let far = u32::from(x.side == Side::Far);
    let is_usable = guess.sigma > 0.0 && guess.sigma.is_finite() && guess.launch.is_finite();
    is_usable.then(|| Paths::new(medium, x.x.into(), guess.launch.into(), far, tolerance, reach))
}

/// Where the ray from `x` is at its parameter `guess.sigma`; `None` if it runs into a hole before or cannot be followed.
fn end_of(medium: &Medium<'_>, x: Place, guess: &Guess, tolerance: f64) -> Option<Place> {
    Some(walk(&mut start(medium, x, guess, tolerance)?, medium, guess.sigma, |_, _| ())?.0)
}

/// The same, with the neighbours of the ray.
fn follow(medium: &Medium<'_>, x: Place, guess: Guess, tolerance: f64) -> Option<Reached> {
    let mut paths = start(medium, x, &guess, tolerance)?;
    let axes = DVec3::from(paths.state.v).normalize().any_orthonormal_pair();
    let mut bundle = Bundle::new(medium, &paths.state);
    let (place, tangent, left) = walk(&mut paths, medium, guess.sigma, |h, crossed| {
        bundle = bundle.after(medium, h);
        if let Some(throat) = medium.throat.filter(|_| crossed) {
            bundle = bundle.through(medium, &throat, true);
        }
    })?;
    let bundle = bundle.after(medium, left);
    let aside = bundle.aside().map(DVec3::from);
    Some(Reached { guess, place, tangent, axes: axes.into(), aside, tolerance, spread: bundle.spread() })
}

/// A search for a ray.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a> {
    /// What it is a ray of.
    pub medium: &'a Medium<'a>,
    /// Where it begins.
    pub x: Place,
    /// Where it is to end.
    pub y: Place,
    /// The centre of the angles and distances that errors are measured by.
    pub focus: DVec3,
}

impl Search<'_> {
    /// The distance that errors are compared with.
    pub fn distance(&self) -> f64 {
        if self.x.side == self.y.side { (self.y.x - self.x.x).length() } else { (self.y.x - self.focus).length() }
    }

    /// How far `place` is from the end, in its chart: the change of the distance from the centre, and around it.
    fn off(&self, place: Place) -> DVec3 {
        let y = match self.medium.throat {
            Some(throat) if place.side != self.y.side => throat.through(self.y.x),
            _ => self.y.x,
        };
        let (a, b) = (place.x - self.focus, y - self.focus);
        let axis = a.cross(b);
        let angle = axis.length().atan2(a.dot(b));
        let aside = axis.cross(a).try_normalize().unwrap_or(DVec3::ZERO);
        let rise = 0.5 * (b.length_squared() / a.length_squared()).ln();
        a * rise + aside * (angle * a.length())
    }

    /// The ray that `guess` leads to, whose errors at first are `tolerance`. Its launch is no further from that of the guess than [`LEASH`] says.
    pub fn run(&self, guess: Guess, tolerance: f64) -> Option<Reached> {
        self.run_to(guess, tolerance, FINE)
    }

    /// The same, to about the third digit.
    pub fn run_roughly(&self, guess: Guess) -> Option<Guess> {
        Some(self.run_to(guess, ROUGH, ROUGH)?.guess)
    }

    /// How far from its end the ray `guess` is after its parameter, over the distance.
    pub fn error(&self, guess: &Guess, tolerance: f64) -> f64 {
        end_of(self.medium, self.x, guess, tolerance).map_or(f64::INFINITY, |place| self.off(place).length() / self.distance())
    }

    /// Neighbours cost several times as much as the ray: their derivatives are brought up to date by what rays show (Broyden 1965) while that
    /// leads on.
    fn run_to(&self, guess: Guess, mut tolerance: f64, last: f64) -> Option<Reached> {
        let first = guess.launch;
        let distance = self.distance();
        let enough = (FOUND * distance).max(ROUNDING * (self.y.x - self.focus).length());
        let mut near = follow(self.medium, self.x, guess, tolerance)?;
        let mut derivative = near.derivative();
        let mut at = near.guess;
        let mut off = self.off(near.place);
        let (mut is_fresh, mut follows) = (true, 0);
        loop {
            let error = off.length();
            if error <= NEAR * distance && tolerance != FINE {
                if last != FINE {
                    return follow(self.medium, self.x, at, tolerance);
                }
                tolerance = FINE;
                off = self.off(end_of(self.medium, self.x, &at, tolerance)?);
                continue;
            }
            if error <= enough && tolerance == FINE {
                let is_last = is_fresh && near.tolerance == FINE;
                return if is_last { Some(near) } else { follow(self.medium, self.x, at, tolerance) };
            }
            let change = derivative.inverse() * off;
            let turned = change.truncate().length();
            let mut share = (MOST_TURNED / turned).min(MOST_LONGER * at.sigma / change.z.abs()).min(1.0);
            let mut better = None;
            for _ in 0..if is_fresh { HALVINGS } else { 1 } {
                let guess = near.turned(&at, change * share);
                follows += 1;
                if !change.is_finite() || guess.launch.dot(first) < LEASH || follows > FOLLOWS {
                    return None;
                }
                better = end_of(self.medium, self.x, &guess, tolerance)
                    .map(|place| (guess, self.off(place)))
                    .filter(|(_, off)| off.length() < SLOW * error);
                if better.is_some() {
                    break;
                }
                share *= 0.5;
            }
            if let Some((guess, closer)) = better {
                let step = change * share;
                let weighted = DVec3::new(step.x, step.y, step.z / (at.sigma * at.sigma));
                let missed = (off - closer - derivative * step) / weighted.dot(step);
                derivative += DMat3::from_cols(missed * weighted.x, missed * weighted.y, missed * weighted.z);
                (at, off, is_fresh) = (guess, closer, false);
            } else if is_fresh {
                // Rounding may end it a little earlier.
                return if error <= STALLED * distance && tolerance == FINE {
                    follow(self.medium, self.x, at, tolerance)
                } else {
                    None
                };
            } else {
                near = follow(self.medium, self.x, at, tolerance)?;
                derivative = near.derivative();
                is_fresh = true;
            }
        }
    }
}

impl Reached {
    /// Derivative of the point by the angles of the launch and by the parameter.
    fn derivative(&self) -> DMat3 {
        DMat3::from_cols(self.aside[0], self.aside[1], self.tangent)
    }

    /// The ray `at`, launched about as this one, with its launch turned by `change.x` and `change.y` (rad) towards the axes, and followed further
    /// by `change.z`.
    fn turned(&self, at: &Guess, change: DVec3) -> Guess {
        let aside = self.axes[0] * change.x + self.axes[1] * change.y;
        let angle = aside.length();
        let (sin, cos) = angle.sin_cos();
        let launch = at.launch * cos + if angle > 0.0 { aside * (sin / angle) } else { DVec3::ZERO };
        Guess { launch: launch.normalize(), sigma: at.sigma + change.z }
    }

    /// Whether the ray `other` is this one: if it has about the same launch, and as a neighbour would end no further off than `within` (scene
    /// units).
    pub fn is_same(&self, other: &Guess, within: f64) -> bool {
        let [a, b] = self.axes.map(|axis| axis.dot(other.launch));
        let off = self.aside[0] * a + self.aside[1] * b + self.tangent * (other.sigma - self.guess.sigma);
        self.guess.launch.dot(other.launch) > SAME_LAUNCH && off.length() <= within
    }
}

/// Cosine of the largest angle between the launch of a ray that is found and that of its guess.
pub const LEASH: f64 = 0.75;

/// Cosine of the largest angle between launches of one and the same image.
const SAME_LAUNCH: f64 = 0.95;
