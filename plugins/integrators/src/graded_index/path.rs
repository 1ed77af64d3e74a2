//! Rays of a refractive index, step by step: with error control, or with steps of fixed size.

use crate::arithmetic::root::root;
use crate::graded_index::dense::{degree_5, degree_8};
use crate::graded_index::escape;
use crate::graded_index::medium::{Medium, Refracted};
use crate::graded_index::nystroem::{State, Step, rk4, step};
use crate::tracing::arc::Arc;
use crate::tracing::polynomial_arc::PolynomialArc;
use bhs_core::real::{Mask, Vector};
use bhs_core::spacetime::{Ball, Side, Throat};
use bhs_elementary::Elementary;
use glam::DVec3;

/// Rays underway, each in its own parameter sigma, with `|dx/dsigma| = n`.
#[derive(Clone, Debug)]
pub struct Paths<'a, F: Refracted> {
    medium: &'a Medium<'a>,
    /// Where they are. The direction of the tangent is that of the ray, its length is n.
    pub state: State<Vector<F>>,
    /// The parameter.
    pub sigma: F,
    /// Bits of those that are on the far side.
    pub far_side: u32,
    /// Length of the next step, as a share of the distance from what is nearest.
    share: F,
    size: Size<F>,
    /// Errors asked for of the directions in which rays leave.
    tolerance: F,
    /// Distance from the middle of the medium beyond which nothing is.
    limit: f64,
    /// Steps, attempts of them.
    pub counts: [u32; 2],
}

/// What decides how long steps are.
#[derive(Clone, Copy, Debug)]
enum Size<F> {
    /// The largest estimated error over the distance from what is nearest; steps are of order 8.
    Error(F),
    /// The length over that distance; steps are of order 4.
    Share(f64),
}

/// What a step has led to.
#[derive(Clone, Copy, Debug)]
pub struct Advance<F: Refracted> {
    /// The curve of the step, in the chart of the side where it began. Of no length where there was no step.
    pub arc: PolynomialArc<F>,
    /// Rays that leave for ever: beyond everything, outwards. [`Paths::directions`] says where to.
    pub escaped: F::Mask,
    /// Rays that fall into a hole.
    pub captured: F::Mask,
    /// Rays that have come to the other side: the arc ends on the throat.
    pub crossed: F::Mask,
    /// Rays for which no step is short enough.
    pub lost: F::Mask,
}

/// How much larger than the error of a ray the estimated one of a step may be: it is that of a method of lower order. Measured.
const ERROR_FACTOR: f64 = 150.0;

/// Share of the length that should do, and what an attempt may change that of the next by.
const SAFETY: f64 = 0.85;
const LEAST_FACTOR: f64 = 0.2;
const MOST_FACTOR: f64 = 4.0;

/// Error of the directions (rad) in which rays leave that steps of fixed size have followed.
const RUNGE_KUTTA_SKY: f64 = 1e-9;

/// Attempts at one step.
const ATTEMPTS: u32 = 40;

/// Places of a step at which it is looked at for breaks.
const PROBES: u32 = 4;

/// How near to a break a ray is on it, relative to the distance from the centre.
const ON_BREAK: f64 = 1e-9;

impl<'a, F: Refracted> Paths<'a, F> {
    /// The rays from the points `x` of the sides `far_side` (bits) with the chart directions `d`, through which nothing can be met outside of the
    /// ball `reach`. Places stray from the true rays by about `tolerance` times the distance from the nearest hole.
    pub fn new(medium: &'a Medium<'a>, x: Vector<F>, d: Vector<F>, far_side: u32, tolerance: F, reach: Ball) -> Self {
        let (square, a) = medium.at(x);
        let n = square.sqrt();
        let v = d.normalize() * n;
        let ninth = F::from_fn(|i| tolerance.lane(i).power(1.0 / 9.0));
        let limit = medium.far.max((reach.center - medium.center).length() + reach.radius);
        let size = Size::Error(F::splat(ERROR_FACTOR) * tolerance);
        let state = State { x, v, a };
        Self { medium, state, sigma: F::splat(0.0), far_side, share: ninth, size, tolerance, limit, counts: [0; 2] }
    }

    /// The same rays, by the classic Runge-Kutta method with steps whose length is the share `step` of the distance from the nearest hole: of
    /// about so many rad as seen from there.
    #[must_use]
    pub fn by_runge_kutta(self, step: f64) -> Self {
        Self { size: Size::Share(step), tolerance: F::splat(RUNGE_KUTTA_SKY), ..self }
    }

    /// Which of the rays leave for ever: beyond everything, outwards.
    #[inline(always)]
    pub fn leaving(&self) -> F::Mask {
        let from_center = self.state.x - Vector::all(self.medium.center);
        let square = from_center.length_squared();
        let outwards = from_center.dot(self.state.v).gt(F::splat(0.0));
        // The square of the distance grows, and so does its derivative.
        let freely = (self.state.v.length_squared() + from_center.dot(self.state.a)).gt(F::splat(0.0));
        square.gt(F::splat(self.limit * self.limit)) & outwards & freely
    }

    /// The directions in which the rays `which`, which leave for ever, go, and of which of them they are right.
    ///
    /// They stay where they are, and all of them together cost no more than one, as much as some three steps: best asked for at the end.
    pub fn directions(&self, which: F::Mask) -> (Vector<F>, F::Mask) {
        escape::directions(self.medium, self.state.x, self.state.v, self.tolerance, which)
    }

    /// The side on which ray number `i` is.
    pub fn side(&self, i: usize) -> Side {
        if self.far_side >> i & 1 == 1 { Side::Far } else { Side::Near }
    }

    /// One step of the rays `which`.
    pub fn advance(&mut self, which: F::Mask) -> Advance<F> {
        let escaped = which & self.leaving();
        let moving = which & !escaped;
        let start = self.state;
        let (taken, end, lost) = self.attempt(moving);
        let c = match self.size {
            Size::Error(_) => degree_8(|x| self.medium.at(x).1, &start, &end, taken),
            Size::Share(_) => degree_5(&start, &end, taken),
        };
        let mut advance = Advance {
            arc: PolynomialArc::new(c, self.sigma, taken),
            escaped,
            captured: F::Mask::NONE,
            crossed: F::Mask::NONE,
            lost,
        };
        self.state = end;
        self.cross(&start, moving, &mut advance);
        advance.captured = moving & self.falling();
        self.sigma = advance.arc.end();
        advance
    }

    /// Steps of the rays `moving` whose errors are small enough: lengths, ends, and which rays have none. Others stay.
    #[inline(always)]
    fn attempt(&mut self, moving: F::Mask) -> (F, State<Vector<F>>, F::Mask) {
        let c = F::splat;
        let medium = self.medium;
        let start = self.state;
        let scale = medium.scale(start.x);
        let per_share = scale / start.v.length();
        if let Size::Share(share) = self.size {
            self.share = c(share);
        }
        let (mut taken, mut end, mut h) = (c(0.0), start, self.share * per_share);
        let (mut todo, mut cut) = (moving, F::Mask::NONE);
        self.counts[0] += moving.bits().count_ones();
        for _ in 0..ATTEMPTS {
            if !todo.any() {
                break;
            }
            self.counts[1] += todo.bits().count_ones();
            let force = |x| medium.at(x).1;
            let (to, good, factor) = match self.size {
                Size::Error(error) => {
                    let tried = step(force, &start, h);
                    let (good, factor) = judge(&tried, c(1.0) / (error * scale));
                    (tried.end, todo & good, factor)
                }
                Size::Share(_) => (rk4(force, &start, h), todo, c(1.0)),
            };
            // A step that a break has cut short says nothing of the next.
            let next = h / per_share * factor;
            self.share = F::select(todo & !(cut & good), next, self.share);
            let broken = if medium.breaks.is_empty() { F::Mask::NONE } else { self.shorten(&to, &mut h, good) };
            cut = cut | broken;
            let good = good & !broken;
            taken = F::select(good, h, taken);
            end = to.or(&end, good);
            todo = todo & !good;
            h = F::select(broken, h, self.share * per_share);
        }
        (taken, end, todo)
    }

    /// Shortens those of the steps `which` to `ends` of the lengths `h` that lead over a break, to where it is; says which.
    #[cold]
    fn shorten(&self, ends: &State<Vector<F>>, h: &mut F, which: F::Mask) -> F::Mask {
        let mut shortened = 0;
        let lengths = F::from_fn(|i| {
            let length = h.lane(i);
            let cut = (which.bits() >> i & 1 == 1).then(|| self.first_break(i, ends, length)).flatten();
            shortened |= u32::from(cut.is_some()) << i;
            cut.unwrap_or(length)
        });
        *h = lengths;
        F::Mask::of_bits(shortened)
    }

    /// Length of the step of ray number `i` to the first break on its way, if there is one.
    fn first_break(&self, i: usize, ends: &State<Vector<F>>, h: f64) -> Option<f64> {
        let one = |s: &State<Vector<F>>| State { x: s.x.lane(i).into(), v: s.v.lane(i).into(), a: s.a.lane(i).into() };
        let (from, to): (State<Vector<f64>>, _) = (one(&self.state), one(ends));
        let arc = PolynomialArc::new(degree_5(&from, &to, h), 0.0, h);
        let center = Vector::from(self.medium.center);
        let radius = |s: f64| (arc.point(s) - center).length();
        let rising = |s: f64| {
            let (x, v) = arc.point_and_tangent(s);
            (x - center).dot(v)
        };
        // Where it is looked at: some places in turn, and the nearest one if the ray comes in and goes out again.
        let mut probes: Vec<f64> = (0..=PROBES).map(|k| h * f64::from(k) / f64::from(PROBES)).collect();
        if let Some(k) = (1..probes.len()).find(|k| rising(probes[k - 1]) < 0.0 && rising(probes[*k]) > 0.0) {
            probes.insert(k, root(rising, probes[k - 1], probes[k], true));
        }
        let mut first = None;
        for b in &self.medium.breaks {
            let off = |s: f64| radius(s) - b;
            let mut before = off(0.0);
            if before.abs() <= ON_BREAK * b {
                before = if rising(0.0) > 0.0 { ON_BREAK * b } else { -ON_BREAK * b };
            }
            for pair in probes.windows(2) {
                let here = off(pair[1]);
                let lands = pair[1] == h && here.abs() <= ON_BREAK * b;
                if here * before < 0.0 && !lands {
                    let at = root(off, pair[0], pair[1], before < 0.0);
                    first = Some(first.map_or(at, |other: f64| other.min(at)));
                    break;
                }
                before = here;
            }
        }
        first
    }

    /// Ends those of the steps from `start` that lead through the throat there, and turns the rays to the other side.
    fn cross(&mut self, start: &State<Vector<F>>, moving: F::Mask, advance: &mut Advance<F>) {
        let Some(throat) = self.medium.throat else { return };
        let center = Vector::all(throat.center);
        let inside = |x: Vector<F>| (x - center).length_squared().lt(F::splat(throat.radius * throat.radius));
        let inwards = (start.x - center).dot(start.v).lt(F::splat(0.0));
        let crossing = moving & inside(self.state.x) & (inwards | !inside(start.x));
        if crossing.any() {
            self.turn(&throat, crossing, advance);
        }
    }

    #[cold]
    fn turn(&mut self, throat: &Throat, crossing: F::Mask, advance: &mut Advance<F>) {
        let bits = crossing.bits();
        let each: Vec<(f64, DVec3, DVec3)> = (0..F::COUNT)
            .map(|i| {
                let arc = advance.arc.lane(i);
                if bits >> i & 1 == 0 {
                    return (arc.end(), self.state.x.lane(i), self.state.v.lane(i));
                }
                let off = |s: f64| (DVec3::from(arc.point(s)) - throat.center).length() - throat.radius;
                let s = if off(arc.start()) <= 0.0 { arc.start() } else { root(off, arc.start(), arc.end(), false) };
                let (x, v) = arc.point_and_tangent(s);
                let x = throat.center + (DVec3::from(x) - throat.center).normalize() * throat.radius;
                (s, x, throat.turned(x, v.into()))
            })
            .collect();
        let (x, v) = (Vector::<F>::from_fn(|i| each[i].1), Vector::from_fn(|i| each[i].2));
        let (square, a) = self.medium.at(x);
        // The length is known, all but the rounding.
        let v = (v.normalize() * square.sqrt()).or(self.state.v, crossing);
        self.state = State { x, v, a };
        self.far_side ^= bits;
        advance.arc = advance.arc.until(F::from_fn(|i| each[i].0));
        advance.crossed = crossing;
    }

    /// Rays that fall into a hole.
    #[inline(always)]
    fn falling(&self) -> F::Mask {
        let mut falling = F::Mask::NONE;
        for hole in &self.medium.captures {
            let from_center = self.state.x - Vector::all(hole.center);
            let inside = from_center.length_squared().lt(F::splat(hole.radius * hole.radius));
            falling = falling | (inside & from_center.dot(self.state.v).lt(F::splat(0.0)));
        }
        falling
    }
}

/// Whether the errors of a step, times `per_error`, are small enough, and what the length of the next should be multiplied by.
#[inline(always)]
fn judge<F: Refracted>(step: &Step<Vector<F>>, per_error: F) -> (F::Mask, F) {
    let c = F::splat;
    let [in_x, in_v] = step.error.map(Vector::length);
    let share = in_x.max(in_v) * per_error;
    // (1/share)^(1/8), within bounds.
    let factor = c(SAFETY) / share.max(c(1e-6)).sqrt().sqrt().sqrt();
    (share.le(c(1.0)), F::select(factor.gt(c(LEAST_FACTOR)), factor.min(c(MOST_FACTOR)), c(LEAST_FACTOR)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracing::arc::tests::check;
    use bhs_core::lanes::Lanes;
    use bhs_core::spacetime::{Class, Spacetime};
    use bhs_spacetimes::{Ellis, Hole, MajumdarPapapetrou};

    const REACH: Ball = Ball { center: DVec3::ZERO, radius: 8.0 };

    /// Holds the curves of some rays, near to what bends them and past it, to what curves promise.
    fn arcs<F: Refracted>(spacetime: &dyn Spacetime, tolerance: f64, share: Option<f64>) {
        let Class::Index(index) = spacetime.class() else { panic!("{spacetime:?}") };
        let medium = Medium::new(index, spacetime.captures());
        for shift in [0.0, 0.37, 1.1] {
            let place = |i: usize| DVec3::new(5.0, 0.4 * i as f64 - 1.0 + shift, 0.5 - 0.2 * i as f64);
            let x = Vector::<F>::from_fn(place);
            let d = Vector::from_fn(|i| -place(i) + DVec3::new(0.0, 0.3 * i as f64 - shift, 0.8));
            let mut paths = Paths::new(&medium, x, d, 0, F::splat(tolerance), REACH);
            if let Some(share) = share {
                paths = paths.by_runge_kutta(share);
            }
            let mut going = F::Mask::ALL;
            for _ in 0..200 {
                let advance = paths.advance(going);
                going = going & !(advance.escaped | advance.captured);
                if !going.any() || going.bits() != F::Mask::ALL.bits() {
                    break;
                }
                // A chord may be no shorter than rounding; on the throat a step may end where it begins.
                if (advance.arc.end() - advance.arc.start()).gt(F::splat(1e-3)).all() {
                    check(&advance.arc, 3, 1e-4, 0.05);
                }
            }
        }
    }

    #[test]
    fn steps_are_arcs() {
        let holes = MajumdarPapapetrou::new(&[1.0, -1.0].map(|z| Hole { center: DVec3::Z * z, mass: 0.5 }));
        let ellis = Ellis { center: DVec3::ZERO, throat: 1.0 };
        for spacetime in [&holes as &dyn Spacetime, &ellis] {
            for tolerance in [1e-4, 1e-6, 1e-9] {
                arcs::<f64>(spacetime, tolerance, None);
                arcs::<Lanes>(spacetime, tolerance, None);
            }
            arcs::<f64>(spacetime, 1e-6, Some(0.2));
        }
    }
}
