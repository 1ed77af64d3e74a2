//! Rays from point to point among several holes by Newton's method, with two neighbours of each ray as derivatives; eight searches side by side
//! (`docs/physics.md`, section 6).

use crate::several::masses::{ABREAST, Ended, Launch, Masses};
use bhs_core::lanes::Lanes;
use bhs_core::real::{Real, Vector};
use bhs_elementary::Elementary;
use glam::{DMat3, DVec3};

/// A ray to begin with.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    pub place: DVec3,
    /// Its tangent there, of length n.
    pub tangent: DVec3,
    /// Directions at right angles to the launch.
    pub axes: [DVec3; 2],
    /// Derivatives of the point by the angles of a launch towards those.
    pub aside: [DVec3; 2],
}

/// A ray that is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Where it begins.
    pub x: DVec3,
    /// Where it is to end.
    pub y: DVec3,
    /// The centre of the angles and distances that errors are measured by.
    pub focus: DVec3,
    /// What it begins with, in turn.
    pub guesses: [Option<Guess>; 2],
}

/// Lengths of steps as seen from the nearest hole: of rays that are far from where they are to go, and of those that come near.
const ROUGH: f64 = 0.5;
const FINE: f64 = 0.18;

/// Rays of one search, and lengths of one step that are tried.
const FOLLOWS: u32 = 16;
const HALVINGS: u32 = 4;

/// By how much the error has to become less in a step.
const SLOW: f64 = 0.7;

/// The largest change of the parameter in one step, over the parameter, and that of the launch (rad).
const MOST_LONGER: f64 = 0.7;
const MOST_TURNED: f64 = 0.5;

/// Error, over the distance, at which the search goes on with fine rays, and from which on a guess is hopeless.
const NEAR: f64 = 1e-3;
const HOPELESS: f64 = 2.0;

/// Error, over the distance, that a fine ray may have which was near as a rough one.
const FAR_OFF: f64 = 0.3;

/// Error, over the distance, at which it ends, and the rounding of it over the distance from the centre.
const FOUND: f64 = 1e-10;
const ROUNDING: f64 = 1e-14;

/// Error, over the distance, that will do if no step makes it less.
const STALLED: f64 = 1e-9;

/// Cosine of the largest angle between the launch of a ray that is found and that of its guess.
pub const LEASH: f64 = 0.75;

/// Cosine of the largest angle between launches of one and the same image.
const SAME_LAUNCH: f64 = 0.95;

/// How near to a hole a ray may come, over the radius of its ball of no return or, if its end is in there, over the distance of that.
const NEAREST: f64 = 0.5;

impl Search {
    /// The distance that errors are compared with.
    pub fn distance(&self) -> f64 {
        (self.y - self.x).length()
    }

    /// How far `place` is from the end: the change of the distance from the centre, and around it.
    fn off(&self, place: DVec3) -> DVec3 {
        let (a, b) = (place - self.focus, self.y - self.focus);
        let axis = a.cross(b);
        let angle = axis.length().arctangent2(a.dot(b));
        let aside = axis.cross(a).try_normalize().unwrap_or(DVec3::ZERO);
        let rise = 0.5 * (b.length_squared() / a.length_squared()).logarithm();
        a * rise + aside * (angle * a.length())
    }

    /// Nearer than this to a hole a ray is given up.
    fn limit(&self, masses: &Masses) -> f64 {
        let of = |end: DVec3| masses.holes.iter().map(move |hole| (end - hole.center).length().min(hole.radius));
        NEAREST * of(self.x).chain(of(self.y)).fold(f64::INFINITY, f64::min)
    }
}

/// A search underway.
struct Hunt<'a> {
    search: &'a Search,
    /// Its place among the answers.
    number: usize,
    limit: f64,
    enough: f64,
    /// Which guess it began with.
    guess: usize,
    /// The best ray yet, and how far from the end that is.
    best: Option<(Reached, DVec3)>,
    /// The next change of that, and the share of it that is tried.
    change: DVec3,
    share: f64,
    trial: Guess,
    halvings: u32,
    follows: u32,
    is_fine: bool,
    /// Whether the best ray is not a fine one though the next is to be.
    is_coarser: bool,
}

impl<'a> Hunt<'a> {
    fn new(masses: &Masses, search: &'a Search, number: usize) -> Option<Self> {
        let trial = search.guesses[0]?;
        let enough = (FOUND * search.distance()).max(ROUNDING * (search.y - search.focus).length());
        Some(Self {
            search,
            number,
            limit: search.limit(masses),
            enough,
            guess: 0,
            best: None,
            change: DVec3::ZERO,
            share: 1.0,
            trial,
            halvings: 0,
            follows: 0,
            is_fine: false,
            is_coarser: false,
        })
    }

    /// Begins with the next guess; `false` if there is none.
    fn begin_again(&mut self) -> bool {
        self.guess += 1;
        let Some(Some(trial)) = self.search.guesses.get(self.guess) else { return false };
        (self.trial, self.best, self.follows, self.halvings) = (*trial, None, 0, 0);
        (self.is_fine, self.is_coarser) = (false, false);
        true
    }

    /// What becomes of the search now that its trial has led to `end`: the answer, if it is over.
    fn judge(&mut self, end: Option<Reached>) -> Option<Option<Reached>> {
        self.follows += 1;
        let distance = self.search.distance();
        let off = end.map(|end| self.search.off(end.place));
        let before = self.best.map_or(HOPELESS * distance / SLOW, |(_, off)| off.length());
        let wanted = if self.is_coarser { before.max(FAR_OFF * distance) / SLOW } else { before };
        match end.zip(off).filter(|(_, off)| off.length() < SLOW * wanted) {
            Some((end, off)) => {
                (self.best, self.halvings, self.share) = (Some((end, off)), 0, 1.0);
                self.is_coarser = false;
                let error = off.length();
                if self.is_fine && error <= self.enough {
                    return Some(Some(end));
                }
                if !self.is_fine && error <= NEAR * distance {
                    (self.is_fine, self.is_coarser) = (true, true);
                }
                self.change = end.derivative().inverse() * off;
                let turned = self.change.truncate().length();
                self.share = (MOST_TURNED / turned).min(MOST_LONGER * end.guess.sigma / self.change.z.abs()).min(1.0);
            }
            None => {
                if let Some((best, off)) = self.best
                    && self.is_fine
                    && !self.is_coarser
                    && off.length() <= STALLED * distance
                {
                    return Some(Some(best));
                }
                self.halvings += 1;
                self.share *= 0.5;
            }
        }
        let first = self.search.guesses[self.guess].map_or(DVec3::ZERO, |guess| guess.launch);
        let next = self.best.map(|(best, _)| best.turned(self.change * self.share));
        let next = next.filter(|next| {
            self.change.is_finite() && self.halvings <= HALVINGS && self.follows < FOLLOWS && next.launch.dot(first) >= LEASH
        });
        match next {
            Some(next) => self.trial = next,
            None => {
                if !self.begin_again() {
                    return Some(None);
                }
            }
        }
        None
    }
}

/// The rays that are looked for; `None` for those that are not found. What becomes of one does not depend on the others.
pub fn run_all(masses: &Masses, searches: &[Search]) -> Vec<Option<Reached>> {
    let mut found = vec![None; searches.len()];
    let mut waiting = (0..).zip(searches).filter_map(|(number, search)| Hunt::new(masses, search, number));
    let mut rough: Vec<Hunt<'_>> = Vec::with_capacity(ABREAST);
    let mut fine: Vec<Hunt<'_>> = Vec::new();
    loop {
        while rough.len() < ABREAST {
            let Some(hunt) = waiting.next() else { break };
            rough.push(hunt);
        }
        // Fine rays take more steps: they go together.
        let is_fine = fine.len() >= ABREAST || rough.is_empty();
        let at_once = if is_fine { &mut fine } else { &mut rough };
        if at_once.is_empty() {
            return found;
        }
        let mut hunts: Vec<Hunt<'_>> = at_once.drain(..at_once.len().min(ABREAST)).collect();
        let ends = follow(masses, &hunts, if is_fine { FINE } else { ROUGH });
        for (mut hunt, end) in hunts.drain(..).zip(ends) {
            match hunt.judge(end) {
                Some(answer) => found[hunt.number] = answer,
                None if hunt.is_fine => fine.push(hunt),
                None => rough.push(hunt),
            }
        }
    }
}

/// Follows the trials of at most [`ABREAST`] searches.
fn follow(masses: &Masses, hunts: &[Hunt<'_>], share: f64) -> [Option<Reached>; ABREAST] {
    // Lanes without a search repeat the last one.
    let hunt = |i: usize| &hunts[i.min(hunts.len() - 1)];
    let axes: [(DVec3, DVec3); ABREAST] = std::array::from_fn(|i| hunt(i).trial.launch.any_orthonormal_pair());
    let launch = Launch {
        x: Vector::from_fn(|i| hunt(i).search.x),
        launch: Vector::from_fn(|i| hunt(i).trial.launch),
        axes: [Vector::from_fn(|i| axes[i].0), Vector::from_fn(|i| axes[i].1)],
    };
    let [sigma, limit] = [|h: &Hunt<'_>| h.trial.sigma, |h: &Hunt<'_>| h.limit].map(|of| Lanes::from_fn(|i| of(hunt(i))));
    let Ended { x, tangent, aside, lost } = masses.follow(&launch, sigma, limit, share);
    std::array::from_fn(|i| {
        let end = Reached {
            guess: hunt(i).trial,
            place: x.lane(i),
            tangent: tangent.lane(i),
            axes: axes[i].into(),
            aside: aside.map(|a| a.lane(i)),
        };
        (i < hunts.len() && lost >> i & 1 == 0 && end.is_finite()).then_some(end)
    })
}

impl Reached {
    fn is_finite(&self) -> bool {
        self.place.is_finite() && self.tangent.is_finite() && self.aside.iter().all(|a| a.is_finite())
    }

    /// Chart area across the bundle over chart solid angle of the launch.
    pub fn spread(&self) -> f64 {
        self.aside[0].cross(self.aside[1]).dot(self.tangent).abs() / self.tangent.length()
    }

    /// Derivative of the point by the angles of the launch and by the parameter.
    fn derivative(&self) -> DMat3 {
        DMat3::from_cols(self.aside[0], self.aside[1], self.tangent)
    }

    /// The ray launched with its launch turned by `change.x` and `change.y` (rad) towards the axes, and followed further by `change.z`.
    fn turned(&self, change: DVec3) -> Guess {
        let aside = self.axes[0] * change.x + self.axes[1] * change.y;
        let angle = aside.length();
        let (sin, cos) = angle.sine_cosine();
        let launch = self.guess.launch * cos + if angle > 0.0 { aside * (sin / angle) } else { DVec3::ZERO };
        Guess { launch: launch.normalize(), sigma: self.guess.sigma + change.z }
    }

    /// Whether the ray `other` is this one: if it has about the same launch, and as a neighbour would end no further off than `within` (scene
    /// units).
    pub fn is_same(&self, other: &Guess, within: f64) -> bool {
        let [a, b] = self.axes.map(|axis| axis.dot(other.launch));
        let off = self.aside[0] * a + self.aside[1] * b + self.tangent * (other.sigma - self.guess.sigma);
        self.guess.launch.dot(other.launch) > SAME_LAUNCH && off.length() <= within
    }
}
