//! Rays from point to point around a hole that spins, by Newton's method with the neighbours of each ray as derivatives; eight searches side by side
//! (`docs/physics.md`, section 10).
//!
//! What is looked for from the edge of capture on changes with the logarithm of the angle from it: that is what Newton's steps change.

use crate::kerr::connect::bundle::Spin;
use crate::kerr::connect::edge::{Azimuth, Edge};
use crate::kerr::connect::reached::{Reached, Trial, follow_all};
use crate::kerr::connect::search::{Guess, Image, Search, Target};
use bhs_core::lanes::{LANES, Lanes, set_bits};
use bhs_core::real::{Real, Vector};
use bhs_elementary::Elementary;
use glam::DVec3;
use std::f64::consts::PI;

/// A ray that was found.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// How it is launched, and its time.
    pub guess: Guess,
    /// The last ray that was followed, next to it.
    pub end: Reached,
    /// Errors of 1/r are multiplied by the first, what they and errors across make together by the second: the error over the distance.
    pub scale: (f64, f64),
    /// Rays that it took.
    pub follows: u32,
}

/// Rays of one search, and lengths of one step that are tried.
const FOLLOWS: u32 = 24;
const HALVINGS: u32 = 5;

/// The largest change of the time in one step, over the time; that of the launch (rad), and of the logarithm of its angle from the edge.
pub(super) const MOST_LONGER: f64 = 0.5;
pub(super) const MOST_TURNED: f64 = 0.5;
pub(super) const MOST_LOG: f64 = 1.5;

/// How long a ray is followed at most to where it leaves, over its time.
pub(super) const MOST_TAU: f64 = 3.0;

/// Error, over the distance, at which the search goes on with fine rays; a fine ray may have so many times that, which was near as a rough one.
pub(super) const NEAR: f64 = 2e-2;
const COARSER: f64 = 100.0;

/// Error, over the distance, at which a last step is taken and the search ends.
pub(super) const FOUND: f64 = 3e-7;

/// Steps in which the spin grows where it cannot be had at once.
const STAGES: u32 = 4;

/// Newton's steps to an edge.
pub(super) const EDGE_STEPS: u32 = 6;

/// A launch as seen from the edge of capture.
#[derive(Clone, Copy, Debug)]
struct Polar {
    /// Its azimuth: a unit vector across the inward direction.
    across: DVec3,
    /// Its angle beyond the edge (rad).
    from: f64,
    /// The angle of the edge from the inward direction (rad), its derivative across the azimuth, and 1/r of the light there that winds for ever.
    edge: f64,
    slope: f64,
    u: f64,
}

impl Polar {
    fn launch(&self, inward: DVec3) -> DVec3 {
        let (sin, cos) = (self.edge + self.from).sine_cosine();
        inward * cos + self.across * sin
    }
}

/// A search underway.
struct Hunt<'a> {
    search: &'a Search,
    /// Its place among the answers.
    number: usize,
    /// The hole.
    spin: Spin<f64>,
    /// The spin grows in so many stages; the present one, and the spin in it.
    stages: u32,
    stage: u32,
    a: f64,
    /// 1/r and the unit vector of the angles of the target, and [`Found::scale`].
    end: (f64, DVec3),
    scale: (f64, f64),
    /// The best ray and the trial as seen from the edge of capture, if launches are measured from that; and what they were before.
    polar: Option<[Polar; 2]>,
    last_polar: Option<Polar>,
    /// The best ray yet, and its error.
    best: Option<(Reached, f64)>,
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
    fn new(spin: Spin<f64>, search: &'a Search, number: usize, trial: Option<Guess>) -> Self {
        let mut hunt = Self {
            search,
            number,
            spin,
            stages: 1,
            stage: 1,
            a: spin.a,
            end: (0.0, DVec3::ZERO),
            scale: (1.0, 1.0),
            polar: None,
            last_polar: None,
            best: None,
            change: DVec3::ZERO,
            share: 1.0,
            trial: search.guess,
            halvings: 0,
            follows: 0,
            is_fine: false,
            is_coarser: false,
        };
        hunt.begin(1);
        if let Some(trial) = trial {
            (hunt.trial, hunt.polar, hunt.is_fine) = (trial, None, true);
            hunt.stages = STAGES;
            hunt.stage = STAGES;
        }
        hunt
    }

    /// Begins with the guess, and with the spin divided by `stages`.
    fn begin(&mut self, stages: u32) {
        let Search { image, guess, inward, edge, .. } = *self.search;
        (self.stage, self.stages, self.trial) = (1, stages, guess);
        let across = self.search.across(guess.launch);
        let from = guess.launch.dot(across).arctangent2(guess.launch.dot(inward)) - edge;
        let polar = Polar { across, from, edge, slope: 0.0, u: 1.0 / 3.0 };
        self.polar = (image == Image::Round).then_some([polar; 2]);
        self.begin_stage();
    }

    fn begin_stage(&mut self) {
        (self.best, self.halvings, self.follows, self.is_fine, self.is_coarser) = (None, 0, 0, false, false);
        self.a = self.spin.a * f64::from(self.stage) / f64::from(self.stages);
        (self.end, self.scale) = match self.search.target {
            Target::Point(y) => {
                let oblate = Spin { a: self.a, ..self.spin }.oblate(y.into());
                ((1.0 / oblate.r, oblate.n.into()), (oblate.r, oblate.r / (y - self.search.x).length()))
            }
            Target::Sky(sky) => ((0.0, sky), (self.search.x.length(), 1.0)),
        };
    }

    /// Goes on to the next stage from the best ray.
    fn next_stage(&mut self) -> Option<()> {
        self.stage += 1;
        self.trial = self.next(1.0)?;
        if let Some(last) = &mut self.last_polar {
            let (inward, d) = (self.search.inward, self.trial.launch);
            let across = self.search.across(d);
            last.edge += last.slope * (across - last.across).dot(inward.cross(last.across)) * d.dot(across);
            last.from = d.dot(across).arctangent2(d.dot(inward)) - last.edge;
            last.across = across;
            self.polar = Some([*last; 2]);
        }
        self.begin_stage();
        Some(())
    }

    /// Goes on by continuation, if that has not been tried.
    fn give_up(&mut self) -> Option<Option<Found>> {
        if self.stages > 1 {
            return Some(None);
        }
        self.begin(STAGES);
        None
    }

    /// How far a ray is from the end: across, and in 1/r.
    fn off(&self, at: &Reached) -> (DVec3, f64) {
        let (u, n) = self.end;
        let axis = at.n.cross(n);
        let sin = axis.length();
        let aside = if sin > 0.0 { axis.cross(at.n) * (sin.arctangent2(at.n.dot(n)) / sin) } else { DVec3::ZERO };
        (aside, u - at.u)
    }

    /// Begins anew with the twist of the ray that was followed first, as seen from the edge of capture.
    fn twist(&mut self, end: &Reached) -> bool {
        let (Some([_, trial]), Some(guess)) = (&mut self.polar, self.search.twisted(end.twist)) else { return false };
        let Search { inward, edge, .. } = *self.search;
        trial.across = self.search.across(guess.launch);
        let angle = guess.launch.dot(trial.across).arctangent2(guess.launch.dot(inward));
        trial.from = (angle - edge) * (PI - trial.edge) / (PI - edge);
        self.trial = guess;
        true
    }

    /// What becomes of the search now that its trial has led to `end`: the answer, if it is over.
    fn judge(&mut self, end: Option<Reached>) -> Option<Option<Found>> {
        self.follows += 1;
        if let Some(end) = &end
            && self.follows == 1
            && self.stages == 1
            && self.twist(end)
        {
            return None;
        }
        let before = self.best.map_or(f64::INFINITY, |(_, error)| if self.is_coarser { COARSER * NEAR } else { error });
        let judged = end.map(|end| {
            let (aside, rise) = self.off(&end);
            (end, aside, rise, aside.length().hypotenuse(rise * self.scale.0) * self.scale.1)
        });
        match judged.filter(|(.., error)| *error < before) {
            Some((end, aside, rise, error)) => {
                if let Some([best, trial]) = &mut self.polar {
                    *best = *trial;
                }
                (self.best, self.change, self.halvings) = (Some((end, error)), end.change(aside, rise), 0);
                if self.is_fine && error <= FOUND {
                    if self.stage < self.stages {
                        return if self.next_stage().is_some() { None } else { Some(None) };
                    }
                    return match self.found() {
                        None => self.give_up(),
                        found => Some(found),
                    };
                }
                self.is_coarser = !self.is_fine && error <= NEAR;
                self.is_fine |= error <= NEAR;
                if self.is_fine {
                    self.last_polar = self.polar.take().map(|p| p[0]).or(self.last_polar);
                }
                self.share = self.longest(end.guess.tau);
            }
            None => {
                self.halvings += 1;
                self.share *= 0.5;
            }
        }
        match self.next(self.share).filter(|_| self.halvings <= HALVINGS && self.follows < FOLLOWS) {
            Some(next) => {
                self.trial = next;
                None
            }
            None => self.give_up(),
        }
    }

    /// The share of the change that a step may be, of a ray of the time `tau`.
    fn longest(&self, tau: f64) -> f64 {
        let change = self.change;
        let turned = match self.polar {
            Some([Polar { from, slope, .. }, _]) => {
                (MOST_LOG / ((change.x - slope * change.y) / from).abs()).min(MOST_TURNED / change.y.abs())
            }
            None => MOST_TURNED / change.truncate().length(),
        };
        turned.min(MOST_LONGER * tau / change.z.abs()).min(1.0)
    }

    /// The ray that is changed by the share `share` of what Newton's step asks for.
    fn next(&mut self, share: f64) -> Option<Guess> {
        let (best, _) = self.best?;
        let change = self.change * share;
        if !change.is_finite() {
            return None;
        }
        let Some([old, new]) = &mut self.polar else { return Some(best.turned(change)) };
        let inward = self.search.inward;
        let turn = change.y / best.guess.launch.dot(old.across);
        new.edge = old.edge + old.slope * change.y;
        new.from = old.from * ((change.x - old.slope * change.y) / old.from).exponential();
        new.across = old.across * turn.cosine() + inward.cross(old.across) * turn.sine();
        Some(Guess { launch: new.launch(inward), tau: best.guess.tau + change.z })
    }

    /// The answer, if that is the image which is looked for.
    fn found(&mut self) -> Option<Found> {
        let guess = self.next(1.0)?;
        let (end, _) = self.best?;
        let is_direct = end.determinant() > 0.0;
        (is_direct == (self.search.image == Image::Direct)).then_some(Found {
            guess,
            end,
            scale: self.scale,
            follows: self.follows,
        })
    }

    /// The ray to be followed next.
    fn trial(&self) -> Trial {
        let Search { x, image, inward, turns, .. } = *self.search;
        let d = self.trial.launch;
        let e1 = match self.polar {
            Some([_, Polar { across, .. }]) => across * d.dot(inward) - inward * d.dot(across),
            None => d.any_orthonormal_vector(),
        };
        // Light that goes round mostly arrives outwards: where it passes the radius of the end tells more than where it is after a guessed time.
        let leaves = turns && image == Image::Round && !self.is_fine;
        let (exit, longer) = if leaves { (self.end.0, MOST_TAU) } else { (f64::NEG_INFINITY, 1.0) };
        let guess = Guess { launch: d, tau: longer * self.trial.tau };
        Trial { a: self.a, x, guess, aside: [e1, d.cross(e1)], exit }
    }
}

/// The rays that are looked for around the hole; `None` for those that are not found. What becomes of one does not depend on the others.
pub fn run_all(spin: Spin<f64>, searches: &[Search]) -> Vec<Option<Found>> {
    run(spin, searches.len(), (0..).zip(searches).map(|(number, search)| Hunt::new(spin, search, number, None)))
}

/// The ray next to `traced`, which ends about where `search` is to end.
pub fn sharpened(spin: Spin<f64>, search: &Search, traced: Guess) -> Option<Found> {
    run(spin, 1, std::iter::once(Hunt::new(spin, search, 0, Some(traced))))[0]
}

fn run<'a>(spin: Spin<f64>, count: usize, mut waiting: impl Iterator<Item = Hunt<'a>>) -> Vec<Option<Found>> {
    let mut found = vec![None; count];
    let mut rough: Vec<Hunt<'_>> = Vec::with_capacity(LANES);
    let mut fine: Vec<Hunt<'_>> = Vec::new();
    loop {
        while rough.len() < LANES {
            let Some(hunt) = waiting.next() else { break };
            if hunt.is_fine { &mut fine } else { &mut rough }.push(hunt);
        }
        // Fine rays take more time: they go together.
        let is_fine = fine.len() >= LANES || rough.is_empty();
        let at_once = if is_fine { &mut fine } else { &mut rough };
        if at_once.is_empty() {
            return found;
        }
        let mut hunts: Vec<Hunt<'_>> = at_once.drain(..at_once.len().min(LANES)).collect();
        if !is_fine {
            see_edges(spin, &mut hunts);
        }
        let trials: arrayvec::ArrayVec<Trial, LANES> = hunts.iter().map(Hunt::trial).collect();
        let ends = follow_all(spin.charge_squared, &trials, is_fine);
        for (mut hunt, end) in hunts.drain(..).zip(ends) {
            match hunt.judge(end) {
                Some(answer) => found[hunt.number] = answer,
                None if hunt.is_fine => fine.push(hunt),
                None => rough.push(hunt),
            }
        }
    }
}

/// Brings the edges from which the trials are measured to where they are.
fn see_edges(spin: Spin<f64>, hunts: &mut [Hunt<'_>]) {
    let Some(any) = hunts.iter().position(|hunt| hunt.polar.is_some()) else { return };
    let with_edge = |i: usize| hunts.get(i).filter(|hunt| hunt.polar.is_some()).unwrap_or(&hunts[any]);
    let polar = |i: usize| with_edge(i).polar.map(|[_, trial]| trial);
    let number = |of: fn(Polar) -> f64| <Lanes as Real>::from_fn(|i| polar(i).map_or(1.0, of));
    let inward = Vector::from_fn(|i| with_edge(i).search.inward);
    let azimuth = Azimuth { inward, across: Vector::from_fn(|i| polar(i).map_or(DVec3::ZERO, |p| p.across)) };
    let spins = Spin { a: <Lanes as Real>::from_fn(|i| with_edge(i).a), charge_squared: Lanes::splat(spin.charge_squared) };
    let x = Vector::from_fn(|i| with_edge(i).search.x);
    let (Edge { angle, slope, u }, is_one) = azimuth.edge(&spins, x, (number(|p| p.edge), number(|p| p.u)), EDGE_STEPS);
    for i in set_bits(is_one.to_bitmask()) {
        if let Some(hunt) = hunts.get_mut(i)
            && let Some([_, trial]) = &mut hunt.polar
        {
            (trial.edge, trial.slope, trial.u) = (angle.lane(i), slope.lane(i), u.lane(i));
            hunt.trial.launch = trial.launch(hunt.search.inward);
        }
    }
}
