//! Leaps through free space.

use crate::tracing::arc::Arc;
use crate::tracing::packet::Packet;
use crate::tracing::surfaces::Surfaces;
use bhs_core::real::{Mask, Real, Vector};

/// Free space is passed over if that gets on by as much as this share of a chord.
const WORTHWHILE: f64 = 0.5;

/// Far more than the rounding of a length, relative to it.
const ROUNDING: f64 = 1e-6;

/// Where a leap ends, as a share of the free way.
const SHORT_OF: f64 = 0.98;

/// Free space that is worth a look, in cells of the grid.
const ENOUGH: f64 = 0.5;

/// What counts as a cell where there is no grid, as a share of the diagonal of the box around the surfaces.
const CELL_OF_BOX: f64 = 1.0 / 64.0;

/// How often a way through free space may be looked along.
const MOST_LOOKS: u32 = 1000;

impl Surfaces<'_> {
    /// Distances from `points` within which there is no surface; 0 where nothing is known.
    #[inline(always)]
    fn free<F: Real>(&self, points: Vector<F>) -> F {
        match self.half.clearance {
            Some(clearance) => clearance.at_each(points),
            None => self.outside(points),
        }
    }

    /// Distances from the box around the surfaces.
    #[cold]
    fn outside<F: Real>(&self, points: Vector<F>) -> F {
        let nearest = Vector::from_fn(|i| points.lane(i).clamp(self.bounds.min, self.bounds.max));
        let away = (points - nearest).length();
        F::select(away.is_finite(), away, F::splat(0.0))
    }

    /// What free space is measured by.
    #[inline(always)]
    fn cell(&self) -> f64 {
        match self.half.clearance {
            Some(clearance) => clearance.cell(),
            None => CELL_OF_BOX * (self.bounds.max - self.bounds.min).length(),
        }
    }
}

impl<F: Real> Packet<'_, F> {
    /// Takes those rays that are `going` along `piece` to the parameters `end` through free space as far as it reaches. Which of them have to go on by
    /// chords.
    #[inline(always)]
    pub fn leaps<A: Arc<F>>(&mut self, piece: &A, end: F, going: &mut F::Mask) -> F::Mask {
        let mut chords = F::Mask::NONE;
        loop {
            *going = *going & self.from().s.lt(end);
            let leaping = *going & !chords;
            if !leaping.any() {
                return *going;
            }
            let leaped = match self.surfaces {
                [Some(surfaces), _] if self.far == 0 => self.leap(piece, end, surfaces, leaping),
                _ => self.leap_on_both_sides(piece, end, leaping),
            };
            chords = chords | (leaping & !leaped);
        }
    }

    /// The same where some of the rays are on the far side.
    #[cold]
    #[inline(never)]
    fn leap_on_both_sides<A: Arc<F>>(&mut self, piece: &A, end: F, rays: F::Mask) -> F::Mask {
        let far = F::Mask::of_bits(self.far);
        let [near_side, far_side] = self.surfaces;
        let mut leap = |surfaces: Option<&Surfaces<'_>>, rays: F::Mask| {
            surfaces.map_or(F::Mask::NONE, |surfaces| self.leap(piece, end, surfaces, rays))
        };
        leap(near_side, rays & !far) | leap(far_side, rays & far)
    }

    /// Takes those of `rays`, all among `surfaces`, that can through free space, as far as it reaches but no farther than a long chord. Which of them
    /// got on by more than a share of a chord.
    ///
    /// From ball to ball of free space along the long chord, as the light goes through the middles of the balls but for the gap between chord
    /// and curve (sphere tracing; Hart 1996): each ball is known from one look at the grid, and the curve's place only at the end.
    #[inline(always)]
    fn leap<A: Arc<F>>(&mut self, piece: &A, end: F, surfaces: &Surfaces<'_>, rays: F::Mask) -> F::Mask {
        let c = F::splat;
        let from = self.from();
        let stride = self.strides(piece);
        // A long chord takes no longer than a look around.
        let rays = rays & (stride.lt(c(A::LONG)) | (end - from.s).gt(stride));
        if !rays.any() {
            return rays;
        }
        let around = surfaces.free(from.points);
        let mut trying = rays & around.gt(c(0.0));
        if !trying.any() {
            return trying;
        }
        let least = c(WORTHWHILE) * stride.min(end - from.s);
        let s = piece.farthest_leap(from.s, end);
        let to = self.places(piece, s);
        let way = to.points - from.points;
        let length = way.length();
        let per_length = c(1.0) / length;
        // Twice what the gap is expected to be.
        let gap = c(2.0) * piece.gap(from.s, s);
        let enough = c(ENOUGH * surfaces.cell());
        let growth = piece.growth([from.s, s], [from.points, to.points], gap, per_length);
        // How far along the chord the ball around a point of it reaches.
        let reach = |covered: F, free: F| c(1.0 - ROUNDING) * free - (growth * (covered + free)).min(gap);
        let (mut covered, mut ahead) = (c(0.0), reach(c(0.0), around));
        let mut marching = trying;
        for _ in 0..MOST_LOOKS {
            marching = marching & ahead.gt(enough);
            covered = F::select(marching, covered + ahead, covered);
            // Those that have come to the end need no look around there.
            marching = marching & covered.lt(length);
            if !marching.any() {
                break;
            }
            ahead = reach(covered, surfaces.free(from.points.plus(way, covered * per_length)));
        }
        // Where the curve is there, by a point of the chord a little before; that place may be far beyond where the parameter says little of the way,
        // and then the chord has to be looked along.
        let stretch = trying & covered.lt(length);
        let mut to = to;
        if stretch.any() {
            let share = c(SHORT_OF) * covered * per_length;
            let part = self.places(piece, piece.beside([from.s, s], [from.points, to.points], share).min(s));
            let beyond = (part.points - from.points).dot(way).gt(covered * length);
            trying = trying & !(stretch & beyond);
            to = part.or(&to, stretch);
        }
        let leaped = trying & (to.s - from.s).ge(least);
        self.go_to(&to, leaped);
        if self.departing != 0 {
            self.departing &= !leaped.bits();
        }
        self.leaps = Self::count(self.leaps, leaped);
        self.draw(piece, &from, leaped, true);
        leaped
    }
}
