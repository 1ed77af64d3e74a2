//! Rays from their starts to where they end, one or eight side by side, piece by piece, whatever bends them.

use crate::tracing::arc::Arc;
use crate::tracing::packet::Packet;
use crate::tracing::packet::hits::Hits;
use crate::tracing::places::{Start, side};
use bhs_core::lanes::set_bits;
use bhs_core::ray::{Arrival, Cost, RayEnd};
use bhs_core::real::{Mask, Real, Vector};
use bhs_core::spacetime::Place;
use bhs_engine::way::{CurvePart, Watch};
use bhs_engine::world::World;
use glam::DVec3;

/// Rays that can be followed side by side: their pieces, one after the other.
pub trait Course<F: Real> {
    /// The curves of one piece of each, in the charts of the sides that the rays are on.
    type Piece: Arc<F>;

    /// Which of the rays begin where no light comes from, and which cannot be followed at all.
    fn begin(&self) -> (F::Mask, F::Mask) {
        (F::Mask::NONE, F::Mask::NONE)
    }

    /// Makes the next piece of the rays `which`, and says how they go on behind it. The piece of a ray may have no length, and then no points.
    ///
    /// The parameters of a piece go on where those of the piece before end.
    fn advance(&mut self, which: F::Mask) -> Next<F>;

    /// The piece that was made last.
    fn piece(&self) -> &Self::Piece;

    /// Tells `found`, of each of the rays `which`, which have just escaped: its number, its direction far away (unit vector of the chart; `None` if it
    /// cannot be told), and the parameter that stands for the whole ray.
    fn directions(&mut self, which: F::Mask, found: impl FnMut(usize, Option<DVec3>, f64));
}

/// How rays go on behind a piece: those of no mask have another piece.
#[derive(Clone, Copy, Debug)]
pub struct Next<F: Real> {
    /// The parameters of the rays behind the piece, which may end before that where it leaves all that can be met.
    pub until: F,
    /// The piece ends on the throat; the next one begins in the chart of the other side.
    pub crosses: F::Mask,
    /// They meet nothing any more.
    pub escapes: F::Mask,
    /// They end where no light comes from.
    pub falls: F::Mask,
    /// They cannot be followed further.
    pub lost: F::Mask,
}

/// Rays that have come to the parameters at which they were to end: [`RayEnd::arrival`] says nothing of them.
#[derive(Clone, Copy, Debug)]
pub struct Reached<F> {
    /// Their bits.
    pub bits: u32,
    /// Where their last chords ended.
    pub last: Vector<F>,
    /// Bits of those that are on the far side.
    far: u32,
}

impl<F: Real> Reached<F> {
    /// Where ray number `i` is, if it is one of them.
    pub fn place(&self, i: usize) -> Option<Place> {
        (self.bits >> i & 1 == 1).then(|| Place { x: self.last.lane(i), side: side(self.far, i) })
    }
}

/// Follows the rays of `start`, as many as there are of `course` or fewer, through `world`, each for at most `max_steps` pieces: what becomes of
/// them is written to `ends`, one a ray, and which have come to their limits is returned. `watch` sees the way of the first one, if there is somebody.
pub fn follow<F: Real, C: Course<F>>(
    world: &World,
    start: &Start<'_, F>,
    course: &mut C,
    max_steps: u64,
    watch: Option<&mut dyn Watch>,
    ends: &mut [RayEnd],
) -> Reached<F> {
    let present = F::Mask::of_bits((1_u32 << ends.len()) - 1);
    // Where they end is written for each of them.
    for end in &mut *ends {
        end.cost = Cost::default();
    }
    // For as long as the packet lives.
    let watch = watch.map(|watch| -> &mut dyn Watch { watch });
    let mut packet = Packet::<F>::new(world, start, watch, ends);
    let (falls, lost) = course.begin();
    packet.end(present & lost, Arrival::OutOfSteps);
    packet.end(present & falls, Arrival::Captured);
    packet.go(course, present & !(falls | lost), max_steps);
    let Packet { reached, last, far, steps, leaps, .. } = packet;
    for (i, end) in ends.iter_mut().enumerate() {
        (end.cost.steps, end.cost.leaps) = (steps.lane(i) as u32, leaps.lane(i) as u32);
    }
    Reached { bits: reached, last, far }
}

impl<F: Real> Packet<'_, F> {
    /// Follows the rays `underway` to their ends.
    ///
    /// Not copied into its callers, or the loop over steps is as large as all that it calls.
    #[inline(never)]
    fn go<C: Course<F>>(&mut self, course: &mut C, mut underway: F::Mask, max_steps: u64) {
        let mut hits = Hits::new();
        for _ in 0..max_steps {
            if !underway.any() {
                return;
            }
            self.steps = Self::count(self.steps, underway);
            let next = course.advance(underway);
            let piece = course.piece();
            let there = underway & next.until.ge(self.limit);
            let end = piece.end().min(self.limit);
            self.parameter = F::select(underway, next.until.min(self.limit), self.parameter);
            self.crossing = next.crosses & !there;
            let goes = underway & end.gt(piece.start());
            let met = self.meet(piece, end, goes, &mut hits);
            self.show(piece, end, goes, met);
            underway = underway & !met;
            self.finish(course, &next, underway, there);
            let crossing = underway & self.crossing;
            if crossing.any() {
                self.cross(crossing);
            }
            underway = underway & !(there | next.escapes | next.falls | next.lost);
        }
        self.end(underway, Arrival::OutOfSteps);
    }

    /// Shows somebody who watches the curve of the first of `rays` along `piece`: to the parameter `end`, or to where it `met` something.
    #[inline(always)]
    fn show<A: Arc<F>>(&mut self, piece: &A, end: F, rays: F::Mask, met: F::Mask) {
        if self.watch.is_some() && rays.bits() & 1 == 1 {
            let end = if met.bits() & 1 == 1 { self.ends[0].swept } else { end.lane(0) };
            self.show_part(&piece.lane(0), end);
        }
    }

    #[cold]
    fn show_part<A: Arc<f64>>(&mut self, piece: &A, end: f64) {
        let side = side(self.far, 0);
        if let Some(watch) = &mut self.watch {
            let curve = |s: f64| {
                let (point, tangent) = piece.point_and_tangent(s);
                [point.into(), tangent.into()]
            };
            watch.part(&CurvePart { ends: [piece.start(), end], side, curve: &curve });
        }
    }

    /// Notes the ends of those of `rays` that end behind a piece; `there`: where they were to end.
    #[inline(always)]
    fn finish<C: Course<F>>(&mut self, course: &mut C, next: &Next<F>, rays: F::Mask, there: F::Mask) {
        if !(rays & (there | next.escapes | next.falls | next.lost)).any() {
            return;
        }
        self.end(rays & there, Arrival::OutOfSteps);
        self.reached |= (rays & there).bits();
        let rays = rays & !there;
        self.end(rays & next.lost, Arrival::OutOfSteps);
        self.end(rays & next.falls, Arrival::Captured);
        let escaped = rays & next.escapes & !next.falls;
        if escaped.any() {
            let far = self.far;
            course.directions(escaped, |i, direction, parameter| {
                self.ends[i].swept = parameter;
                self.ends[i].arrival = direction.map_or(Arrival::OutOfSteps, |d| Arrival::Sky(d, side(far, i)));
            });
        }
    }

    /// Notes the ends of `rays`.
    #[inline(always)]
    fn end(&mut self, rays: F::Mask, arrival: Arrival) {
        for i in set_bits(rays.bits()) {
            self.ends[i].arrival = arrival;
            self.ends[i].swept = self.parameter.lane(i);
        }
    }
}
