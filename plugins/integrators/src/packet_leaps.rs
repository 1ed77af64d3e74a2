//! Leaps through free space, side by side.

use crate::chords::{ROUNDING, WORTHWHILE};
use crate::packet::Packet;
use crate::spherical::packet_orbit::Steps;
use bhs_core::lanes::{Lanes, none, pick};
use crate::log::TraceLog;

/// Longest leap through free space, in radians: the gap between it and its chord is not to be large beside free space.
const LONGEST_LEAP: f64 = 0.8;

/// Less than the cosine of half of that.
const LONGEST_LEAP_COS: f64 = 0.92;

/// Chords of this angle (rad) are long.
const LONG: f64 = 0.5;

/// Where a leap ends, as a share of the free way.
const SHORT_OF: f64 = 0.98;

/// Free space that is worth a look, in cells of the grid.
const ENOUGH: f64 = 0.5;

impl Packet<'_> {
    /// Takes those rays that are `going` through free space as far as it reaches. Which of them have to go on by chords.
    #[inline(always)]
    pub(crate) fn leaps(&mut self, steps: &Steps, going: &mut Lanes, log: &mut TraceLog) -> Lanes {
        let mut chords = none();
        loop {
            *going = *going & self.last.phi.simd_lt(steps.end.phi) & self.last.u.simd_gt(none());
            let leaping = *going & !chords;
            if leaping.none() {
                return *going;
            }
            chords |= leaping & !self.leap(steps, leaping, log);
        }
    }

    /// Takes those of `rays` that can through free space, as far as it reaches but no farther than a long chord. Which of them got on by
    /// more than a share of a chord.
    ///
    /// From ball to ball of free space along the long chord, as the light goes through the middles of the balls but for the gap between chord
    /// and orbit (sphere tracing; Hart 1996): each ball is known from one look at the grid, and the orbit's place only at the end.
    #[inline(always)]
    fn leap(&mut self, steps: &Steps, rays: Lanes, log: &mut TraceLog) -> Lanes {
        let c = Lanes::splat;
        let Some(clearance) = self.world.clearance.as_ref() else { return none() };
        let end = steps.end.phi;
        // A long chord takes no longer than a look around.
        let rays = rays & (self.angle.simd_lt(c(LONG)) | (end - self.last.phi).simd_gt(self.angle));
        if rays.none() {
            return rays;
        }
        let around = clearance.at_each(self.last.points);
        let mut trying = rays & around.simd_gt(c(0.0));
        if trying.none() {
            return trying;
        }
        let least = c(WORTHWHILE) * self.angle.fast_min(end - self.last.phi);
        let phi = (self.last.phi + c(LONGEST_LEAP)).fast_min(end);
        let to = self.places(steps, phi);
        trying &= to.u.simd_gt(c(0.0));
        let (way, swept) = (to.points - self.last.points, phi - self.last.phi);
        let length = way.length_squared().sqrt();
        let per_length = c(1.0) / length;
        // Twice what the gap is expected to be.
        let gap = c(3.0 / 8.0 * self.rs) * swept * swept;
        let enough = c(ENOUGH * clearance.cell());
        // The gap grows no faster than with four times the share of the angle, which is no more than that of the way if all of it were as near to
        // the hole as the nearer end (the middle of a chord is nearer by the cosine of half the angle).
        let nearer = to.u.fast_max(self.last.u);
        let growth = c(4.0) * gap * per_length.fast_max(nearer / (c(LONGEST_LEAP_COS) * swept));
        // How far along the chord the ball around a point of it reaches.
        let reach = |covered: Lanes, free: Lanes| c(1.0 - ROUNDING) * free - (growth * (covered + free)).fast_min(gap);
        let (mut covered, mut ahead) = (c(0.0), reach(c(0.0), around));
        let mut marching = trying;
        loop {
            marching = marching & ahead.simd_gt(enough) & covered.simd_lt(length);
            if marching.none() {
                break;
            }
            covered = pick(marching, covered + ahead, covered);
            ahead = reach(covered, clearance.at_each(self.last.points.plus(way, covered * per_length)));
        }
        // Where the orbit is there, by the angle of a point of the chord a little before; of an orbit that runs along the radius that place may be far
        // beyond, and then the chord has to be looked along.
        let stretch = trying & covered.simd_lt(length);
        let mut to = to;
        if stretch.any() {
            let got = self.last.points.plus(way, c(SHORT_OF) * covered * per_length);
            let turned = self.planes.angles(self.last.points, got).fast_min(swept);
            let part = self.places(steps, self.last.phi + turned);
            let beyond = (part.points - self.last.points).dot(way).simd_gt(covered * length);
            trying &= !(stretch & beyond);
            to = part.or(&to, stretch);
        }
        let leaped = trying & (to.phi - self.last.phi).simd_ge(least);
        let chord = to.points - self.last.points;
        self.before = chord.or(self.before, leaped);
        self.last = to.or(&self.last, leaped);
        self.has_before |= leaped;
        log.counters.leaps += leaped.to_bitmask().count_ones();
        leaped
    }
}
