//! Orbits as curves: what intersection sees of one step in a plane, with the swept angle as parameter.

use crate::spherical::Attraction;
use crate::spherical::steps::{Planes, Polars, Stretch};
use crate::tracing::arc::Arc;
use bhs_core::real::{Real, Vector};
use glam::DVec3;

/// Longest chord (rad), however much it may stray.
pub const LONGEST_CHORD: f64 = 1.5;

/// `1/cos - 1` of half of that, at most.
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
        (self.planes.e1 * (slope * p.cos - r * p.sin)).plus(self.planes.e2, slope.fma(p.sin, r * p.cos))
    }
}

/// `1/cos(x) - 1` for angles of at most half of [`LONGEST_CHORD`], or a little more (its power series, with the last term made larger).
#[inline(always)]
fn beyond<F: Real>(x: F) -> F {
    let c = F::splat;
    let xx = x * x;
    c(0.5) * xx * xx.fma(xx.fma(c(0.226), c(5.0 / 12.0)), c(1.0))
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
        c(2.0) * (x + x).sqrt() * x.fma(c(-5.0 / 12.0), c(1.0))
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
        let nearer = c(1.0) / a.min(b).sqrt();
        c(4.0) * gap * per_length.max(nearer / (c(LONGEST_LEAP_COS) * (ends[1] - ends[0])))
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
    use crate::spherical::orbit::{Fate, Rk4Orbit, Stepper};
    use crate::spherical::steps::errors;
    use crate::spherical::taylor::TaylorOrbit;
    use crate::tracing::arc::tests::check;
    use bhs_core::lanes::LANES;
    use bhs_core::spacetime::Spherical;

    fn holes() -> [Attraction; 3] {
        [0.0, 0.12, 0.25].map(|charge_squared| (&Spherical { center: DVec3::ZERO, rs: 1.0, charge_squared }).into())
    }

    fn ray(i: usize) -> (DVec3, DVec3) {
        let angle = 0.3 + 0.31 * i as f64;
        (DVec3::new(3.0 + i as f64, -1.0, 2.0), DVec3::new(-angle.cos(), angle.sin(), 0.3).normalize())
    }

    const CENTER: DVec3 = DVec3::new(0.1, -0.2, 0.3);

    #[test]
    fn orbits_are_arcs() {
        for hole in holes() {
            for i in 0..LANES {
                let (x, d) = ray(i);
                let (plane, state) = OrbitPlane::of_ray(CENTER, x, d);
                let mut orbit = TaylorOrbit::new(hole, state, 1e-9);
                let mut coarse = Rk4Orbit { hole, step: 0.1, state };
                for _ in 0..20 {
                    let (step, fate) = orbit.advance();
                    // A chord of the largest angle bends by more than its middle tells: two or more.
                    check(&PlanarArc::of_taylor(hole, &plane, &step).before(0.02), 3, 1e-4, 0.05);
                    if fate != Fate::Underway {
                        break;
                    }
                }
                for _ in 0..20 {
                    let (step, fate) = coarse.advance();
                    check(&PlanarArc::of_runge_kutta(&plane, &step).before(0.02), 2, 1e-4, 0.05);
                    if fate != Fate::Underway {
                        break;
                    }
                }
            }
            let (planes, start, right) = Planes::of_rays(CENTER, Vector::from_fn(|i| ray(i).0), Vector::from_fn(|i| ray(i).1));
            assert!(Mask::all(right));
            let steps = Steps::from(hole, &start, errors(hole, &start, Lanes::splat(1e-9)));
            check(&PlanarArc::of_steps(hole, &planes, &steps).before(0.02), 3, 1e-4, 0.05);
        }
    }

    #[test]
    fn places_beside_chords_are_found() {
        let hole = holes()[1];
        let (x, d) = ray(2);
        let (plane, state) = OrbitPlane::of_ray(CENTER, x, d);
        let arc = PlanarArc::of_taylor(hole, &plane, &TaylorOrbit::new(hole, state, 1e-9).advance().0).before(0.02);
        let (a, b) = (arc.start(), arc.end());
        for share in [0.0, 0.2, 0.7, 1.0] {
            let [p, q] = [a, b].map(|s| DVec3::from(arc.point(s)) - CENTER);
            let on_chord = p + (q - p) * share;
            let on_curve = DVec3::from(arc.point(arc.beside(a, b, share))) - CENTER;
            assert!(on_chord.normalize().distance(on_curve.normalize()) < 1e-5, "{share}");
        }
    }

    #[test]
    fn curves_end_before_infinity() {
        let hole = holes()[0];
        let (plane, state) = OrbitPlane::of_ray(CENTER, CENTER + DVec3::X * 5.0, DVec3::new(0.96, 0.28, 0.0));
        let (step, fate) = TaylorOrbit::new(hole, state, 1e-9).advance();
        assert_eq!(fate, Fate::Escaped);
        let arc = PlanarArc::of_taylor(hole, &plane, &step).before(0.01);
        assert!((arc.inverse_radius(arc.end()).0 - 0.01).abs() < 1e-12 && arc.end() < step.parts().2.phi);
    }
}
