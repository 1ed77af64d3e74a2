//! Orbits as curves: what intersection sees of one step in a plane, with the swept angle as parameter.

use crate::spherical::Attraction;
use crate::spherical::plane::{Planes, Polars};
use crate::spherical::steps::Stretch;
use crate::tracing::arc::Arc;
use bhs_core::real::{Real, Vector};
use glam::DVec3;

/// Longest chord (rad), however much it may stray.
pub const LONGEST_CHORD: f64 = 1.5;

/// Shortest chord (rad), however little it may stray: below that is rounding.
const SHORTEST_CHORD: f64 = 1e-5;

/// `1/cos - 1` of half of the longest chord, at most.
const MOST_BEYOND: f64 = 0.36;

/// Longest leap through free space (rad).
const LONGEST_LEAP: f64 = 0.8;

/// Less than the cosine of half of that.
const LONGEST_LEAP_COS: f64 = 0.92;

/// A stretch of an orbit, or of several around the same hole.
///
/// It has to end this side of infinity.
#[derive(Clone, Copy)]
pub struct PlanarArc<F: Real, S> {
    /// What it goes around.
    pub hole: Attraction,
    /// Where it lies.
    pub planes: Planes<F>,
    /// Its states.
    pub stretch: S,
    /// The angle at which it ends, not beyond that of the stretch (rad).
    pub end: F,
}

impl<F: Real, S: Stretch<F>> PlanarArc<F, S> {
    /// 1/r at the angle `s`.
    #[inline(always)]
    pub fn inverse_radius(&self, s: F) -> F {
        self.stretch.inverse_radius(s)
    }

    /// The derivative of the point by the angle: `r' e_r + r e_phi`.
    #[inline(always)]
    fn tangent_of(&self, p: &Polars<F>) -> Vector<F> {
        let r = F::splat(1.0) / p.u;
        let slope = -p.du * r * r;
        (self.planes.e1 * (slope * p.cos - r * p.sin)).plus(self.planes.e2, slope.times_plus(p.sin, r * p.cos))
    }
}

/// `1/cos(x) - 1` for angles of at most half of [`LONGEST_CHORD`], or a little more (its power series, with the last term made larger).
#[inline(always)]
fn beyond<F: Real>(x: F) -> F {
    let c = F::splat;
    let xx = x * x;
    c(0.5) * xx * xx.times_plus(xx.times_plus(c(0.226), c(5.0 / 12.0)), c(1.0))
}

/// The gap of a chord of the angle `angle` (rad) around a hole with the Schwarzschild radius `rs` (scene units).
pub fn gap_of_angle(rs: f64, angle: f64) -> f64 {
    1.5 * rs * beyond(0.5 * angle.min(LONGEST_CHORD))
}

impl<F: Real, S: Stretch<F>> Arc<F> for PlanarArc<F, S> {
    type One = PlanarArc<f64, S::One>;

    #[inline(always)]
    fn start(&self) -> F {
        self.stretch.start().phi
    }

    #[inline(always)]
    fn end(&self) -> F {
        self.end
    }

    #[inline(always)]
    fn point(&self, s: F) -> Vector<F> {
        let (u, cos, sin) = self.stretch.place(s);
        self.planes.points(u, cos, sin)
    }

    #[inline(always)]
    fn tangent(&self, s: F) -> Vector<F> {
        self.tangent_of(&self.stretch.polar(s))
    }

    #[inline(always)]
    fn point_and_tangent(&self, s: F) -> (Vector<F>, Vector<F>) {
        let at = self.stretch.polar(s);
        (self.planes.points(at.u, at.cos, at.sin), self.tangent_of(&at))
    }

    /// A chord solves `u'' + u = 0`, so that its gap in u grows by `(3/2) rs u^2` at most: to `(3/2) rs u^2 (1/cos(dphi/2) - 1)` in its middle where
    /// r does not change much, which is `(3/2) rs (1/cos(dphi/2) - 1)` in r; and where r does change, the gap across the ray is less. A charge
    /// makes it less, too.
    #[inline(always)]
    fn gap(&self, a: F, b: F) -> F {
        let half = ((b - a) * F::splat(0.5)).min(F::splat(0.5 * LONGEST_CHORD));
        F::splat(1.5 * self.hole.rs) * beyond(half)
    }

    const HAS_EQUAL_STRIDES: bool = true;

    #[inline(always)]
    fn stride(&self, _: F, gap: F) -> F {
        let c = F::splat;
        // acos(1/(1 + x)) = sqrt(2 x) (1 - 5/12 x + ...), the terms of which alternate.
        let x = (gap / c((1.5 * self.hole.rs).max(f64::MIN_POSITIVE))).min(c(MOST_BEYOND));
        (c(2.0) * (x + x).sqrt() * x.times_plus(c(-5.0 / 12.0), c(1.0))).max(c(SHORTEST_CHORD))
    }

    const LONG: f64 = 0.5;

    #[inline(always)]
    fn farthest_leap(&self, from: F, end: F) -> F {
        (from + F::splat(LONGEST_LEAP)).min(end)
    }

    /// The gap grows no faster than with four times the share of the angle, which is no more than that of the way if all of it were as near to the
    /// hole as the nearer end (the middle of a chord is nearer by the cosine of half the angle).
    #[inline(always)]
    fn growth(&self, ends: [F; 2], points: [Vector<F>; 2], gap: F, per_length: F) -> F {
        let c = F::splat;
        let center = Vector::all(self.planes.center);
        let [a, b] = points.map(|p| (p - center).length_squared());
        let of_angle = c(LONGEST_LEAP_COS) * (ends[1] - ends[0]);
        let per_way = c(1.0) / (a.min(b) * of_angle * of_angle);
        c(4.0) * gap * (per_length * per_length).max(per_way).sqrt()
    }

    #[inline(always)]
    fn beside(&self, ends: [F; 2], points: [Vector<F>; 2], share: F) -> F {
        let on_chord = points[0].plus(points[1] - points[0], share);
        ends[0] + self.planes.angles(points[0], on_chord)
    }

    /// Components along `e1` and `e2`, and the distance from the centre.
    type Plane = [F; 3];

    #[inline(always)]
    fn plane(&self, normal: Vector<F>, point: Vector<F>) -> [F; 3] {
        let &Planes { center, e1, e2 } = &self.planes;
        [normal.dot(e1), normal.dot(e2), normal.dot(point - Vector::all(center))]
    }

    /// The distance from the plane times u, `n.e_r(phi) - u(phi) n.(a - center)`; the second derivative comes for nothing, by the orbit's equation.
    #[inline(always)]
    fn height(&self, &[n1, n2, d]: &[F; 3], s: F) -> [F; 3] {
        let c = F::splat;
        let Polars { u, du, cos, sin, .. } = self.stretch.polar(s);
        let value = n1 * cos + n2 * sin - d * u;
        let slope = n2 * cos - n1 * sin - d * du;
        let mut force = c(1.5 * self.hole.rs) * d * u * u;
        if self.hole.is_charged() {
            force -= c(2.0 * self.hole.charge_squared) * d * u * u * u;
        }
        [value, slope, -(value + force)]
    }

    fn is_nowhere(&self, point: DVec3) -> bool {
        (point - self.planes.center).length() * self.hole.horizon <= 1.0
    }

    fn lane(&self, i: usize) -> PlanarArc<f64, S::One> {
        PlanarArc { hole: self.hole, planes: self.planes.lane(i), stretch: self.stretch.lane(i), end: self.end.lane(i) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spherical::closed_form::ClosedForm;
    use crate::spherical::course::{Method, RungeKutta, SphericalSetup};
    use crate::spherical::exact::ClosedForms;
    use crate::spherical::plane::Planes;
    use crate::tracing::arc::tests::check;
    use crate::tracing::driver::Course;
    use bhs_core::lanes::{LANES, Lanes};
    use bhs_core::real::Mask;
    use bhs_core::spacetime::Spherical;

    const CENTER: DVec3 = DVec3::new(0.1, -0.2, 0.3);

    /// Surfaces reach as far as this, and curves no farther than 8 times that.
    const AROUND: f64 = 20.0;

    fn holes() -> [Spherical; 3] {
        [0.0, 0.12, 0.25].map(|charge_squared| Spherical { center: CENTER, rs: 1.0, charge_squared })
    }

    fn ray(i: usize) -> (DVec3, DVec3) {
        let angle = 0.3 + 0.31 * i as f64;
        (DVec3::new(3.0 + i as f64, -1.0, 2.0), DVec3::new(-angle.cos(), angle.sin(), 0.3).normalize())
    }

    /// Holds the curves of an orbit to what curves promise, until one of its rays has ended.
    fn arcs<F: Real>(mut course: impl Course<F>, chords: usize) {
        for _ in 0..20 {
            let next = course.advance(F::Mask::ALL);
            let piece = course.piece();
            if !(piece.end() - piece.start()).gt(F::splat(1e-3)).all() {
                break;
            }
            // A chord of the largest angle bends by more than its middle tells.
            check(piece, chords, 1e-4, 0.05);
            if (next.escapes | next.falls).any() {
                break;
            }
        }
    }

    #[test]
    fn orbits_are_arcs() {
        for hole in holes() {
            let setting = SphericalSetup::new(&hole, AROUND);
            for i in 0..LANES {
                let (x, d) = ray(i);
                let launch = setting.launch::<f64>(x.into(), d.into());
                arcs(launch.by_series(1e-9), 3);
                arcs(launch.by(RungeKutta(0.1)), 2);
                if hole.charge_squared == 0.0 {
                    let form = ClosedForm::new(1.0, launch.at.u, launch.at.du);
                    arcs(launch.by(ClosedForms(&[form])), 3);
                }
            }
            let (x, d) = (Vector::<Lanes>::from_fn(|i| ray(i).0), Vector::from_fn(|i| ray(i).1));
            arcs(setting.launch(x, d).by_series(Lanes::splat(1e-9)), 3);
            arcs(setting.launch(x, d).by(RungeKutta(0.1)), 2);
        }
    }

    #[test]
    fn places_beside_chords_are_found() {
        let setting = SphericalSetup::new(&holes()[1], AROUND);
        let (x, d) = ray(2);
        let mut course = setting.launch::<f64>(x.into(), d.into()).by_series(1e-9);
        course.advance(true);
        let arc = course.piece();
        let (a, b) = (arc.start(), arc.end());
        let ends = [a, b].map(|s| arc.point(s));
        for share in [0.0, 0.2, 0.7, 1.0] {
            let [p, q] = ends.map(|p| DVec3::from(p) - CENTER);
            let on_chord = p + (q - p) * share;
            let on_curve = DVec3::from(arc.point(arc.beside([a, b], ends, share))) - CENTER;
            assert!(on_chord.normalize().distance(on_curve.normalize()) < 1e-5, "{share}");
        }
    }

    #[test]
    fn curves_end_before_infinity() {
        let setting = SphericalSetup::new(&holes()[0], AROUND);
        for angle in [0.3_f64, 1.0, 1.5, 1e-9, 0.0] {
            let d = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let mut course = setting.launch::<f64>((CENTER + DVec3::X * 5.0).into(), d.into()).by_series(1e-9);
            let mut next = course.advance(true);
            while !next.escapes && course.piece().end() >= next.until {
                next = course.advance(true);
            }
            let piece = course.piece();
            let r = (DVec3::from(piece.point(piece.end())) - CENTER).length();
            assert!(r >= AROUND && r.is_finite() && piece.end() < next.until, "{angle}: {r} {} {next:?}", piece.end());
        }
    }

    #[test]
    fn gaps_of_angles_are_those_of_curves() {
        let hole = holes()[0];
        let planes = Planes::of_rays(CENTER, Vector::<f64>::from(CENTER + DVec3::X), DVec3::Y.into()).0;
        let at = SphericalSetup::new(&hole, AROUND).launch::<f64>((CENTER + DVec3::X * 4.0).into(), DVec3::Y.into()).at;
        let mut stretch = Method::<f64>::nowhere(&RungeKutta(0.5), &at);
        Method::<f64>::step(&RungeKutta(0.5), (&hole).into(), &at, &mut stretch);
        let arc = PlanarArc { hole: (&hole).into(), planes, stretch, end: 0.5 };
        for angle in [1e-4, 0.1, 0.7, LONGEST_CHORD] {
            assert_eq!(gap_of_angle(1.0, angle), arc.gap(0.0, angle));
            let half = 0.5 * angle;
            let right = 1.5 * (1.0 / half.cos() - 1.0);
            assert!(arc.gap(0.0, angle) >= right * (1.0 - 1e-6) && arc.gap(0.0, angle) <= right * 1.01, "{angle}");
            let stride = arc.stride(0.0, right);
            assert!(stride <= angle * (1.0 + 1e-6) && stride > 0.9 * angle, "{angle}: {stride}");
        }
    }
}
