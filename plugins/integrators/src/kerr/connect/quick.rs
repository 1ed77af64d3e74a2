//! Rays from point to point around a hole that spins, most of them: eight side by side from the guess to the end.
//!
//! One rough ray with its neighbours tells how the end moves with the launch. Plain rays, each a fifth of that, use and mend this (Broyden 1965) until
//! they come near; a fine ray with its neighbours ends the search and has the spread. Those that are not found so are left to `newton`.

use crate::kerr::connect::bundle::{Factors, Spin};
use crate::kerr::connect::newton::{FOUND, Found, NEAR};
use crate::kerr::connect::packet::{Moves, Numbers, Packet, Start, number};
use crate::kerr::connect::reached::{FINE, ROUGH, Trial, reached};
use crate::kerr::connect::search::{Guess, Image, Search};
use crate::kerr::connect::series::Followed;
use bhs_core::lanes::{LANES, Lanes, set_bits};
use bhs_core::real::{Mask, Real};
use glam::DVec3;
use std::f64::consts::PI;

/// Error and terms of plain rays.
const PLAIN: (f64, usize) = (1e-7, 10);

/// Terms of the neighbours of fine rays.
const FINE_ASIDE: usize = 11;

/// Error, over the distance, beyond which all rays have neighbours.
const FAR: f64 = 0.1;

/// Rough rays of one search after the first, and plain ones, for either image.
const MOST_ROUGH: [u32; 2] = [4, 10];
const MOST_PLAIN: [u32; 2] = [4, 8];

/// Fine rays of one search.
const MOST_FINE: u32 = 3;

/// Share of the angle beyond the edge of capture that a launch keeps where that edge is farther out.
const LEAST_BEYOND: f64 = 0.2;

/// What a step leaves of an error at the least, as far as is counted on.
const LEAST_RATE: f64 = 5e-3;
const FIRST_RATE: f64 = 0.02;

impl Packet<'_> {
    /// How they begin; and which of them can.
    fn begin(&self) -> (Start, Numbers) {
        let guess = |i: usize| self.search(i).displaced.unwrap_or(self.search(i).guess);
        let start = self.guesses(guess);
        if !self.is_round {
            return (start, Numbers::ALL);
        }
        let displaced = (0..LANES).filter(|i| self.search(*i).displaced.is_some()).fold(0, |bits, i| bits | 1 << i);
        let displaced = <Numbers as Mask>::of_bits(displaced);
        let plain_edge = <Lanes as Real>::from_fn(|i| self.search(i).edge);
        let angle = self.angle(&start);
        let (start, u, is_one) = self.seen_from_edge(start, (plain_edge, number(1.0 / 3.0)), |_| angle - plain_edge);
        // How far space drags a ray along is known after one; where the hole only seems to be displaced, that says as much.
        let (first, _) = self.follow::<{ ROUGH.1 }, 0, 0>(&start, (start.tau * self.longer, self.exit), ROUGH.0);
        let twist = first.twist.to_array();
        let twisted = |i: usize| match self.search(i).displaced {
            Some(displaced) => displaced,
            None => self.search(i).twisted(twist[i]).unwrap_or(self.search(i).guess),
        };
        let again = self.guesses(twisted);
        let angle = self.angle(&again);
        let pi = number(PI);
        let (again, _, is_one_again) = self.seen_from_edge(again, (start.edge, u), |edge| {
            let beyond = angle - plain_edge;
            let as_seen = (angle - edge).max(number(LEAST_BEYOND) * beyond);
            <Lanes as Real>::select(displaced, as_seen, beyond * (pi - edge) / (pi - plain_edge))
        });
        (again, is_one & is_one_again & (displaced | !first.lost))
    }

    fn run(&self) -> [Option<Found>; LANES] {
        let (mut start, mut underway) = self.begin();
        let pick = <Lanes as Real>::select;
        let rough =
            |start: &Start| self.follow::<{ ROUGH.1 }, 2, { ROUGH.1 }>(start, (start.tau * self.longer, self.exit), ROUGH.0).0;
        let first = rough(&start);
        underway &= !first.lost;
        let mut moves = self.moves(&start, &first);
        let (mut off, mut error, mut tau) = (first.off, first.error, first.tau);
        // ---- Rough rays, as long as the end is far away.
        let mut share = number(1.0);
        for _ in 0..MOST_ROUGH[usize::from(self.is_round)] {
            let going = underway & !error.lt(number(FAR));
            if !Mask::any(going) {
                break;
            }
            let change = self.limited(moves.change(off), tau).map(|change| change * share);
            let next = self.changed(&start, change, tau);
            let ray = rough(&next);
            let better = going & ray.error.lt(error);
            let all = self.moves(&next, &ray);
            for i in 0..3 {
                moves.0[i] = all.0[i].or(moves.0[i], better);
            }
            start = next.or(&start, better);
            off = ray.off.or(off, better);
            error = pick(better, ray.error, error);
            tau = pick(better, ray.tau, tau);
            share = pick(better, number(1.0), share * number(0.5));
        }
        underway &= error.lt(number(FAR));
        // ---- Plain rays.
        let (mut ready, mut share) = (Numbers::NONE, number(1.0));
        for k in 0..MOST_PLAIN[usize::from(self.is_round)] {
            let going = underway & !ready;
            if !Mask::any(going) {
                break;
            }
            let change = self.limited(moves.change(off), tau).map(|change| change * share);
            let next = self.changed(&start, change, tau);
            let (plain, _) = self.follow::<{ PLAIN.1 }, 0, 0>(&next, (next.tau * self.longer, self.exit), PLAIN.0);
            // What the step did beyond what was expected of it.
            let [a, b, _] = change;
            let expected = moves.of([a, b, plain.tau - tau]);
            let square = a * a + b * b;
            let per = pick(square.gt(number(0.0)), number(1.0) / square, number(0.0));
            let beyond = (off - plain.off - expected) * per;
            let mended = Moves([moves.0[0].plus(beyond, a), moves.0[1].plus(beyond, b), plain.by_tau]);
            // A rough ray may only seem to be near.
            let before = if k == 0 { error.max(number(NEAR)) } else { error };
            let better = going & plain.error.lt(before);
            let rate = if k == 0 { number(FIRST_RATE) } else { (plain.error / error).max(number(LEAST_RATE)) };
            ready |= better & (plain.error * rate).le(number(FOUND));
            for i in 0..2 {
                moves.0[i] = mended.0[i].or(moves.0[i], going & !plain.lost);
            }
            moves.0[2] = plain.by_tau.or(moves.0[2], better);
            start = next.or(&start, better);
            off = plain.off.or(off, better);
            error = pick(better, plain.error, error);
            tau = pick(better, plain.tau, tau);
            share = pick(better, number(1.0), share * number(0.5));
        }
        underway &= error.lt(number(NEAR));
        // ---- Fine ones.
        let mut found = [None; LANES];
        let mut change = self.limited(moves.change(off), tau);
        let real = (1_u32 << self.searches.len()) - 1;
        for k in 0..MOST_FINE {
            let going = underway.bits() & real;
            if going == 0 {
                break;
            }
            start = self.changed(&start, change, tau).or(&start, underway);
            let (fine, followed) =
                self.follow::<{ FINE.1 }, 2, FINE_ASIDE>(&start, (start.tau, number(f64::NEG_INFINITY)), FINE.0);
            let is_found = fine.error.le(number(FOUND));
            let all = self.moves(&start, &fine);
            change = self.limited(all.change(fine.off), fine.tau);
            tau = fine.tau;
            let rates = Factors::new(&self.spin, &followed.end).twist(followed.end.u[0].v);
            let last = Moves([fine.by[0], fine.by[1], fine.by_tau]).change(fine.off);
            for i in set_bits(going & is_found.bits()) {
                found[i] = self.found(i, (&start, last), (&followed, rates.lane(i)), k + 1);
            }
            underway = underway & !is_found & !fine.lost & fine.error.lt(number(NEAR));
        }
        found
    }

    /// Ray number `i`, if that is the image which is looked for.
    fn found(
        &self,
        i: usize,
        (start, last): (&Start, [Numbers; 3]),
        (followed, rate): (&Followed<Lanes, 2>, f64),
        follows: u32,
    ) -> Option<Found> {
        let trial = Trial {
            a: self.spin.a.lane(i),
            x: self.search(i).x,
            guess: Guess { launch: start.d.lane(i), tau: start.tau.lane(i) },
            aside: start.aside.map(|e| e.lane(i)),
            exit: f64::NEG_INFINITY,
        };
        let end = reached(followed, &trial, i, rate);
        let guess = end.turned(DVec3::from_array(last.map(|c| c.lane(i))));
        let is_direct = end.determinant() > 0.0;
        let is_wanted = is_direct != self.is_round && guess.launch.is_finite() && guess.tau.is_finite();
        is_wanted.then_some(Found { guess, end, scale: (self.scale.0.lane(i), self.scale.1.lane(i)), follows })
    }
}

/// The rays that are looked for, all of them of the same `image`, at most [`LANES`]; `None` for those that are not found so. What becomes of one
/// does not depend on the others.
pub fn run_side_by_side(spin: Spin<f64>, image: Image, searches: &[&Search]) -> [Option<Found>; LANES] {
    Packet::new(spin, image, searches).run()
}
