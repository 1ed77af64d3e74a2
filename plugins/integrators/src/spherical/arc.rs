//! Orbits as curves: what intersection sees of one step in a plane, with the swept angle as parameter.

use crate::arithmetic::polynomial::{TERMS, cos_sin, small_arc_tangent, value, value_and_slope};
use crate::spherical::Attraction;
use crate::spherical::orbit::{OrbitPlane, Step};
use crate::spherical::packet_orbit::{Planes, Steps};
use crate::spherical::taylor::TaylorStep;
use crate::tracing::arc::Arc;
use bhs_core::lanes::Lanes;
use bhs_core::real::{Mask, Real, Vector};
use glam::DVec3;

/// Longest chord (rad), however much it may stray.
pub const LONGEST_CHORD: f64 = 1.5;

/// 1/cos - 1 of half of that, at most.
const MOST_BEYOND: f64 = 0.36;

/// Steps at most to where an orbit passes a radius.
const CORRECTIONS: u32 = 60;

/// A step of an orbit, or of several around the same hole: u is a polynomial in the angle since its start.
///
/// It has to end this side of infinity: see [`PlanarArc::before`].
#[derive(Clone, Copy, Debug)]
pub struct PlanarArc<F: Real> {
    hole: Attraction,
    center: DVec3,
    e1: Vector<F>,
    e2: Vector<F>,
    c: [F; TERMS],
    start: F,
    /// Cosine and sine of the angle at the start.
    cos: F,
    sin: F,
    end: F,
}

impl PlanarArc<f64> {
    /// The curve of a Taylor step.
    pub fn of_taylor(hole: Attraction, plane: &OrbitPlane, step: &TaylorStep) -> Self {
        let (c, start, end) = step.parts();
        Self { start: start.state.phi, cos: start.cos, sin: start.sin, end: end.phi, ..Self::in_plane(hole, plane, c) }
    }

    /// The curve of a Runge-Kutta step, in its dense output.
    pub fn of_runge_kutta(plane: &OrbitPlane, step: &Step) -> Self {
        let (sin, cos) = step.start.phi.sin_cos();
        let arc = Self::in_plane(step.hole, plane, step.coefficients());
        Self { start: step.start.phi, cos, sin, end: step.end.phi, ..arc }
    }

    fn in_plane(hole: Attraction, plane: &OrbitPlane, c: [f64; TERMS]) -> Self {
        let &OrbitPlane { center, e1, e2 } = plane;
        Self { hole, center, e1: e1.into(), e2: e2.into(), c, start: 0.0, cos: 1.0, sin: 0.0, end: 0.0 }
    }
}

impl PlanarArc<Lanes> {
    /// The curves of Taylor steps.
    #[inline(always)]
    pub fn of_steps(hole: Attraction, planes: &Planes, steps: &Steps) -> Self {
        let &Planes { center, e1, e2 } = planes;
        let from = &steps.start;
        Self { hole, center, e1, e2, c: *steps.coefficients(), start: from.phi, cos: from.cos, sin: from.sin, end: steps.end.phi }
    }
}

impl<F: Real> PlanarArc<F> {
    /// 1/r and its derivative at the angle `s`.
    #[inline(always)]
    pub fn inverse_radius(&self, s: F) -> (F, F) {
        value_and_slope(&self.c, s - self.start)
    }

    /// The same curves, but of those which pass 1/r = `least` > 0 outwards the part before that: where steps go on to infinity and beyond.
    pub fn before(self, least: f64) -> Self {
        let c = F::splat;
        let over = |t: F| value(&self.c, t) - c(least);
        let width = self.end - self.start;
        let passing = over(width).lt(c(0.0)) & over(c(0.0)).gt(c(0.0));
        if !passing.any() {
            return self;
        }
        // Newton's method, kept between the ends by bisection.
        let (mut low, mut high) = (c(0.0), width);
        let mut t = width * c(0.5);
        for _ in 0..CORRECTIONS {
            let (u, slope) = value_and_slope(&self.c, t);
            let off = u - c(least);
            let outside = off.lt(c(0.0));
            high = F::select(outside, t, high);
            low = F::select(outside, low, t);
            let newton = t - off / slope;
            let inside = newton.ge(low) & newton.le(high);
            let next = F::select(inside, newton, (low + high) * c(0.5));
            let settled = (next - t).abs().le(c(1e-12) * width);
            t = next;
            if (settled | !passing).all() {
                break;
            }
        }
        Self { end: F::select(passing, self.start + t, self.end), ..self }
    }

    /// Cosines and sines of the angles `s`.
    #[inline(always)]
    fn cos_sin(&self, s: F) -> (F, F) {
        let (cos, sin) = cos_sin(s - self.start);
        (self.cos * cos - self.sin * sin, self.sin.fma(cos, self.cos * sin))
    }

    /// `x e_r + y e_phi` where cosine and sine of the angle are these.
    #[inline(always)]
    fn combine(&self, (x, y): (F, F), (cos, sin): (F, F)) -> Vector<F> {
        (self.e1 * (x * cos - y * sin)).plus(self.e2, x.fma(sin, y * cos))
    }
}

impl<F: Real> Arc<F> for PlanarArc<F> {
    type One = PlanarArc<f64>;

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
        let r = F::splat(1.0) / value(&self.c, s - self.start);
        let (cos, sin) = self.cos_sin(s);
        Vector::all(self.center).plus(self.e1, cos * r).plus(self.e2, sin * r)
    }

    #[inline(always)]
    fn tangent(&self, s: F) -> Vector<F> {
        self.point_and_tangent(s).1
    }

    #[inline(always)]
    fn point_and_tangent(&self, s: F) -> (Vector<F>, Vector<F>) {
        let (u, du) = self.inverse_radius(s);
        let (cos, sin) = self.cos_sin(s);
        let r = F::splat(1.0) / u;
        let point = Vector::all(self.center).plus(self.e1, cos * r).plus(self.e2, sin * r);
        (point, self.combine((-du * r * r, r), (cos, sin)))
    }

    #[inline(always)]
    fn curvature(&self, s: F) -> Vector<F> {
        let c = F::splat;
        let (u, du) = self.inverse_radius(s);
        let r = c(1.0) / u;
        let slope = -du * r * r;
        // r'' - r with the orbit's equation for u''.
        let bend = c(2.0 * self.hole.charge_squared) * u - c(1.5 * self.hole.rs);
        let radial = (c(2.0) * slope * slope).fma(u, bend);
        self.combine((radial, c(2.0) * slope), self.cos_sin(s))
    }

    /// A chord solves `u'' + u = 0`, so that its gap in u grows by `(3/2) rs u^2` at most: to `(3/2) rs u^2 (1/cos(dphi/2) - 1)` in its middle where
    /// r does not change much, which is `(3/2) rs (1/cos(dphi/2) - 1)` in r; and where r does change, the gap across the ray is less. A charge
    /// makes it less, too.
    #[inline(always)]
    fn gap(&self, a: F, b: F) -> F {
        let half = ((b - a) * F::splat(0.5)).min(F::splat(0.5 * LONGEST_CHORD));
        let (cos, sin) = cos_sin(half);
        // 1/cos - 1, with its digits for small angles.
        F::splat(1.5 * self.hole.rs) * sin * sin / (cos * (F::splat(1.0) + cos))
    }

    #[inline(always)]
    fn stride(&self, _: F, gap: F) -> F {
        let c = F::splat;
        // acos(1/(1 + x)) = sqrt(2 x) (1 - 5/12 x + ...), the terms of which alternate.
        let x = (gap / c((1.5 * self.hole.rs).max(f64::MIN_POSITIVE))).min(c(MOST_BEYOND));
        c(2.0) * (x + x).sqrt() * x.fma(c(-5.0 / 12.0), c(1.0))
    }

    #[inline(always)]
    fn beside(&self, a: F, b: F, share: F) -> F {
        let u = [a, b].map(|s| value(&self.c, s - self.start));
        let (cos, sin) = cos_sin((b - a).min(F::splat(LONGEST_CHORD)));
        let part = share * u[0];
        let (along, across) = (part.fma(cos, (F::splat(1.0) - share) * u[1]), part * sin);
        // Twice the angle whose tangent is that of half the angle.
        let half = across / (along + along.fma(along, across * across).sqrt());
        F::splat(2.0).fma(small_arc_tangent(half), a)
    }

    #[inline(always)]
    fn until(self, end: F) -> Self {
        Self { end, ..self }
    }

    fn lane(&self, i: usize) -> PlanarArc<f64> {
        PlanarArc {
            hole: self.hole,
            center: self.center,
            e1: self.e1.lane(i).into(),
            e2: self.e2.lane(i).into(),
            c: self.c.map(|c| c.lane(i)),
            start: self.start.lane(i),
            cos: self.cos.lane(i),
            sin: self.sin.lane(i),
            end: self.end.lane(i),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spherical::orbit::{Fate, Rk4Orbit, Stepper};
    use crate::spherical::packet_orbit::errors;
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
