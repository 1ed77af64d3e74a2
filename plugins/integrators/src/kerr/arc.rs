//! Light around a hole that spins as curves: what intersection sees of one step.

use crate::arithmetic::polynomial::value;
use crate::kerr::orbit::{Hole, Orbit, turned, turning};
use crate::kerr::series::Series;
use crate::tracing::arc::Arc;
use crate::tracing::parts::{BETWEEN, PARTS, longest, touched};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::Oblate;
use glam::DVec3;

/// Longest leap through free space, in the parameter: about an angle (rad).
const LONGEST_LEAP: f64 = 0.8;

/// A step of light around a hole that spins, or of several rays around the same hole. It has to end this side of infinity.
#[derive(Clone, Copy, Debug)]
pub struct TwistedArc<F: Real> {
    /// What it goes around.
    pub hole: Hole,
    /// Its constants.
    pub orbit: Orbit<F>,
    /// The step.
    pub series: Series<F>,
    start: F,
    end: F,
    /// Of each part, how far a chord may stray over the square of its length of parameter (scene units).
    bend: [F; PARTS],
    /// 1 over the length; 0 of a step of no length.
    per_length: F,
}

impl<F: Real> TwistedArc<F> {
    /// The curve of the step `series` from the parameter `start` on, of the length `length` up to where it is to end.
    #[inline(always)]
    pub fn new(hole: &Hole, orbit: &Orbit<F>, series: Series<F>, (start, length): (F, F)) -> Self {
        let c = F::splat;
        let zero = c(0.0);
        let per_length = F::select(length.gt(zero), c(1.0) / length, zero);
        let mut arc = Self { hole: *hole, orbit: *orbit, series, start, end: start + length, bend: [zero; PARTS], per_length };
        let mut before = arc.bend_at(zero);
        for (i, bend) in arc.bend.iter_mut().enumerate() {
            let next = strays(hole, orbit, value(&arc.series.u, length * c((i + 1) as f64 / PARTS as f64)));
            *bend = before.max(next) * c(BETWEEN);
            before = next;
        }
        arc
    }

    /// Largest gap over the square of the parameter where u is that after `t`.
    #[inline(always)]
    fn bend_at(&self, t: F) -> F {
        strays(&self.hole, &self.orbit, value(&self.series.u, t))
    }

    /// The largest of it between the parameters `a` and `b`.
    #[inline(always)]
    fn largest_bend(&self, a: F, b: F) -> F {
        let (a, b) = ((a - self.start) * self.per_length, (b - self.start) * self.per_length);
        let mut largest = F::splat(f64::MIN_POSITIVE);
        for (i, bend) in self.bend.iter().enumerate() {
            let touched = touched(i, a, b);
            largest = F::select(touched, largest.max(*bend), largest);
        }
        largest
    }
}

/// How far a chord may stray, over the square of its length of parameter, where u is this: `3/8 M (kappa + 2 |a| r / F^2)` in Mino's time
/// (`docs/physics.md`, section 5), `F = 1 - (2 M r - q^2)/(r^2 + a^2)`.
#[inline(always)]
fn strays<F: Real>(hole: &Hole, orbit: &Orbit<F>, u: F) -> F {
    let c = F::splat;
    let a2 = orbit.a * orbit.a;
    let flat = (a2 * u).times_plus(u, c(1.0));
    let falling = c(1.0) - u * (c(2.0) * orbit.mass - orbit.charge_squared * u) / flat;
    let dragging = c(2.0) * orbit.a.abs() / (u * falling * falling);
    // Lengths come back into scene units.
    c(0.375 * 0.5 * hole.kerr.round().rs) * (orbit.kappa + dragging)
}

impl<F: Real> Arc<F> for TwistedArc<F> {
    type One = TwistedArc<f64>;

    #[inline(always)]
    fn start(&self) -> F {
        self.start
    }

    #[inline(always)]
    fn end(&self) -> F {
        self.end
    }

    #[inline(always)]
    fn point(&self, s: F) -> Vector<F> {
        let (state, turn) = self.series.place(s - self.start);
        Vector::all(self.hole.kerr.round().center) + self.hole.chart(self.orbit.point(&state, turn))
    }

    #[inline(always)]
    fn tangent(&self, s: F) -> Vector<F> {
        self.point_and_tangent(s).1
    }

    #[inline(always)]
    fn point_and_tangent(&self, s: F) -> (Vector<F>, Vector<F>) {
        let (state, turn, twist) = self.series.at(s - self.start);
        let (point, tangent) = self.orbit.point_and_tangent(&state, turn, twist);
        (Vector::all(self.hole.kerr.round().center) + self.hole.chart(point), self.hole.chart(tangent))
    }

    #[inline(always)]
    fn gap(&self, a: F, b: F) -> F {
        (b - a) * (b - a) * self.largest_bend(a, b)
    }

    #[inline(always)]
    fn stride(&self, from: F, gap: F) -> F {
        longest(gap, |h| self.largest_bend(from, from + h))
    }

    const LONG: f64 = 0.5;

    #[inline(always)]
    fn farthest_leap(&self, from: F, end: F) -> F {
        (from + F::splat(LONGEST_LEAP)).min(end)
    }

    /// Components of the normal along the axes of the hole, and the distance from the centre in units of the ray.
    type Plane = (Vector<F>, F);

    #[inline(always)]
    fn plane(&self, normal: Vector<F>, point: Vector<F>) -> (Vector<F>, F) {
        let distance = normal.dot(point - Vector::all(self.hole.kerr.round().center));
        (self.hole.components(normal), distance / self.orbit.scale)
    }

    /// The distance from the plane times u, which is regular far away; the second derivative follows from the equations.
    #[inline(always)]
    fn height(&self, &(normal, distance): &(Vector<F>, F), s: F) -> [F; 3] {
        let c = F::splat;
        let orbit = &self.orbit;
        let (state, turn, twist) = self.series.at(s - self.start);
        let (pull, force) = orbit.forces(&state);
        let bend = orbit.twist_slope(&state);
        let across = |v: Vector<F>| {
            let v = turned(v, turn);
            normal.x.times_plus(v.x, normal.y * v.y)
        };
        let first = turning(state.n, state.dn, twist);
        // n'' + 2 twist z x n' + twist' z x n - twist^2 n, across the axis.
        let second = turning(state.dn, force, c(2.0) * twist);
        let second = turning(state.n, second, bend) - state.n * (twist * twist);
        let (p, dp, ddp) = (across(state.n), across(first), across(second));
        let a2 = orbit.a * orbit.a;
        let stretch = (a2 * state.u).times_plus(state.u, c(1.0)).sqrt();
        let slope = a2 * state.u * state.du / stretch;
        let curve = (a2 * (state.du * state.du + state.u * pull) - slope * slope) / stretch;
        [
            stretch * p + normal.z * state.n.z - distance * state.u,
            slope * p + stretch * dp + normal.z * state.dn.z - distance * state.du,
            curve * p + c(2.0) * slope * dp + stretch * ddp + normal.z * force.z - distance * pull,
        ]
    }

    fn is_nowhere(&self, point: DVec3) -> bool {
        let Oblate { r, .. } = self.hole.kerr.oblate::<f64>(point.into());
        r <= self.hole.kerr.horizon()
    }

    fn lane(&self, i: usize) -> TwistedArc<f64> {
        TwistedArc {
            hole: self.hole,
            orbit: self.orbit.lane(i),
            series: self.series.lane(i),
            start: self.start.lane(i),
            end: self.end.lane(i),
            bend: self.bend.map(|x| x.lane(i)),
            per_length: self.per_length.lane(i),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kerr::course::KerrSetup;
    use crate::tracing::arc::tests::check;
    use crate::tracing::driver::Course;
    use bhs_core::lanes::{LANES, Lanes};
    use bhs_core::real::Mask;
    use bhs_core::spacetime::{Kerr, Spherical};

    const CENTER: DVec3 = DVec3::new(0.1, -0.2, 0.3);

    /// Surfaces reach as far as this.
    const AROUND: f64 = 20.0;

    fn holes() -> [Kerr; 4] {
        [(0.5, 0.0), (0.9, 0.0), (-0.998, 0.0), (0.6, 0.5)].map(|(spin, charge)| {
            let round = Spherical { center: CENTER, rs: 2.0, charge_squared: charge * charge };
            Kerr::new(round, DVec3::new(0.6, 0.0, 0.8), spin)
        })
    }

    fn ray(i: usize) -> (DVec3, DVec3) {
        let angle = 0.3 + 0.31 * i as f64;
        (DVec3::new(5.0 + i as f64, -1.0, 2.0), DVec3::new(-angle.cos(), angle.sin(), 0.3).normalize())
    }

    /// Holds the curves of rays to what curves promise, until one of the rays has ended.
    fn arcs<F: Real>(mut course: impl Course<F>, chords: usize, precision: f64) {
        for _ in 0..40 {
            let next = course.advance(F::Mask::ALL);
            let piece = course.piece();
            if !(piece.end() - piece.start()).gt(F::splat(1e-3)).all() {
                break;
            }
            check(piece, chords, precision, 0.05);
            if (next.escapes | next.falls | next.lost).any() {
                break;
            }
        }
    }

    #[test]
    fn rays_are_arcs() {
        for kerr in holes() {
            let setting = KerrSetup::around(&kerr, true, AROUND, 0.0);
            for i in 0..LANES {
                let (x, d) = ray(i);
                arcs(setting.by_series::<f64>(x.into(), d.into(), 1e-9), 4, 1e-4);
                arcs(setting.by_runge_kutta::<f64>(x.into(), d.into(), 0.02), 2, 1e-4);
            }
            let (x, d) = (Vector::<Lanes>::from_fn(|i| ray(i).0), Vector::from_fn(|i| ray(i).1));
            arcs(setting.by_series(x, d, Lanes::splat(1e-9)), 4, 1e-4);
        }
    }

    #[test]
    fn curves_end_before_infinity() {
        for kerr in holes() {
            let setting = KerrSetup::around(&kerr, true, AROUND, 0.0);
            for angle in [0.3_f64, 1.0, 1.5, 1e-9, 0.0] {
                let d = DVec3::new(angle.cos(), angle.sin(), 0.0);
                let mut course = setting.by_series::<f64>((CENTER + DVec3::X * 5.0).into(), d.into(), 1e-9);
                let (mut next, mut farthest) = (course.advance(true), 0.0_f64);
                while !next.escapes {
                    let piece = course.piece();
                    farthest = farthest.max((DVec3::from(piece.point(piece.end())) - CENTER).length());
                    next = course.advance(true);
                }
                let piece = course.piece();
                farthest = farthest.max((DVec3::from(piece.point(piece.end())) - CENTER).length());
                assert!(farthest >= AROUND && farthest.is_finite(), "{angle}: {farthest} {next:?}");
            }
        }
    }
}
