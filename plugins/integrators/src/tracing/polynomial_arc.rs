//! Curves that are polynomials: the dense output of one step.

use crate::tracing::arc::Arc;
use crate::tracing::parts::{BETWEEN, PARTS, longest, touched};
use bhs_core::real::{Real, Vector};

/// Number of coefficients.
pub const TERMS: usize = 9;

/// `c[0] + c[1] t + c[2] t^2 + ...`, with t from 0 to 1 over the whole step.
#[derive(Clone, Copy, Debug)]
pub struct PolynomialArc<F: Real> {
    c: [Vector<F>; TERMS],
    start: F,
    end: F,
    /// 1 over the length of the step; 0 of a step of no length.
    per_length: F,
    /// Of each part, the largest curvature (1 / scene unit) and the largest square of the speed per t (scene units^2).
    curvature: [F; PARTS],
    speed: [F; PARTS],
}

impl<F: Real> PolynomialArc<F> {
    /// The curve with the coefficients `c` over a step from the parameter `start` on of the length `length`, not below 0.
    #[inline(always)]
    pub fn new(c: [Vector<F>; TERMS], start: F, length: F) -> Self {
        let zero = F::splat(0.0);
        let per_length = F::select(length.gt(zero), F::splat(1.0) / length, zero);
        let mut arc = Self { c, start, end: start + length, per_length, curvature: [zero; PARTS], speed: [zero; PARTS] };
        let (mut curvature, mut speed) = arc.bend(zero);
        for i in 0..PARTS {
            let (next_curvature, next_speed) = arc.bend(F::splat((i + 1) as f64 / PARTS as f64));
            arc.curvature[i] = curvature.max(next_curvature) * F::splat(BETWEEN);
            arc.speed[i] = speed.max(next_speed) * F::splat(BETWEEN);
            (curvature, speed) = (next_curvature, next_speed);
        }
        arc
    }

    /// The same curve, cut short at the parameter `end`.
    #[inline(always)]
    #[must_use]
    pub fn until(self, end: F) -> Self {
        Self { end, ..self }
    }

    /// Curvature and square of the speed at `t`.
    #[inline(always)]
    fn bend(&self, t: F) -> (F, F) {
        let (v, a) = (self.first(t), self.second(t));
        let speed = v.length_squared().max(F::splat(f64::MIN_POSITIVE));
        (v.cross(a).length() / (speed * speed.sqrt()), speed)
    }

    #[inline(always)]
    fn share(&self, s: F) -> F {
        (s - self.start) * self.per_length
    }

    #[inline(always)]
    fn value(&self, t: F) -> Vector<F> {
        let mut sum = self.c[TERMS - 1];
        for c in self.c[..TERMS - 1].iter().rev() {
            sum = c.plus(sum, t);
        }
        sum
    }

    /// First derivative by t.
    #[inline(always)]
    fn first(&self, t: F) -> Vector<F> {
        let mut sum = self.c[TERMS - 1] * F::splat((TERMS - 1) as f64);
        for k in (1..TERMS - 1).rev() {
            sum = (self.c[k] * F::splat(k as f64)).plus(sum, t);
        }
        sum
    }

    /// Second derivative by t.
    #[inline(always)]
    fn second(&self, t: F) -> Vector<F> {
        let factor = |k: usize| F::splat((k * (k - 1)) as f64);
        let mut sum = self.c[TERMS - 1] * factor(TERMS - 1);
        for k in (2..TERMS - 1).rev() {
            sum = (self.c[k] * factor(k)).plus(sum, t);
        }
        sum
    }

    /// Largest curvature times square of the speed between the shares `a` and `b` of the step.
    #[inline(always)]
    fn largest_bend(&self, a: F, b: F) -> F {
        let (mut curvature, mut speed) = (F::splat(0.0), F::splat(0.0));
        for i in 0..PARTS {
            let touched = touched(i, a, b);
            curvature = F::select(touched, curvature.max(self.curvature[i]), curvature);
            speed = F::select(touched, speed.max(self.speed[i]), speed);
        }
        (curvature * speed).max(F::splat(f64::MIN_POSITIVE))
    }
}

impl<F: Real> Arc<F> for PolynomialArc<F> {
    type One = PolynomialArc<f64>;

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
        self.value(self.share(s))
    }

    #[inline(always)]
    fn tangent(&self, s: F) -> Vector<F> {
        self.first(self.share(s)) * self.per_length
    }

    type Plane = [Vector<F>; 2];

    #[inline(always)]
    fn plane(&self, normal: Vector<F>, point: Vector<F>) -> [Vector<F>; 2] {
        [normal, point]
    }

    #[inline(always)]
    fn height(&self, [normal, point]: &[Vector<F>; 2], s: F) -> [F; 3] {
        let t = self.share(s);
        let per_length = self.per_length;
        let slope = self.first(t).dot(*normal) * per_length;
        [(self.value(t) - *point).dot(*normal), slope, self.second(t).dot(*normal) * per_length * per_length]
    }

    #[inline(always)]
    fn gap(&self, a: F, b: F) -> F {
        let (a, b) = (self.share(a), self.share(b));
        let swept = b - a;
        // A circle's: an eighth of curvature times length squared.
        F::splat(0.125) * swept * swept * self.largest_bend(a, b)
    }

    #[inline(always)]
    fn stride(&self, from: F, gap: F) -> F {
        let a = self.share(from);
        let eight = F::splat(8.0) * gap;
        let stride = longest(eight, |h| self.largest_bend(a, a + h));
        // No more than rounding of the step's length if it has none.
        stride / self.per_length.max(F::splat(f64::MIN_POSITIVE))
    }

    fn lane(&self, i: usize) -> PolynomialArc<f64> {
        PolynomialArc {
            c: self.c.map(|c| c.lane(i).into()),
            start: self.start.lane(i),
            end: self.end.lane(i),
            per_length: self.per_length.lane(i),
            curvature: self.curvature.map(|x| x.lane(i)),
            speed: self.speed.map(|x| x.lane(i)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracing::arc::tests::check;
    use bhs_core::lanes::Lanes;
    use glam::DVec3;

    /// A curve that bends more and more.
    fn hook<F: Real>() -> PolynomialArc<F> {
        let mut c = [DVec3::ZERO; TERMS];
        (c[0], c[1], c[2]) = (DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.2, 1.3, -0.4), DVec3::new(0.1, -0.05, 0.2));
        (c[4], c[6], c[8]) = (DVec3::new(0.4, 0.0, 0.1), DVec3::new(-0.1, 0.2, 0.0), DVec3::new(0.02, 0.0, -0.1));
        PolynomialArc::new(c.map(Vector::all), F::splat(1.0), F::splat(2.5))
    }

    #[test]
    fn polynomials_are_arcs() {
        for chords in [1, 3, 8] {
            check(&hook::<f64>(), chords, 1e-6, 0.1);
            check(&hook::<Lanes>(), chords, 1e-6, 0.1);
        }
    }

    #[test]
    fn steps_of_no_length_and_straight_ones_are_arcs() {
        let arc = PolynomialArc { per_length: 0.0, end: 1.0, ..hook::<f64>() };
        assert_eq!((arc.point(1.0), arc.gap(1.0, 1.0)), (hook::<f64>().point(1.0), 0.0));
        let mut c = [Vector::all(DVec3::ZERO); TERMS];
        c[1] = Vector::all(DVec3::X);
        let straight = PolynomialArc::<f64>::new(c, 0.0, 1.0);
        assert!(straight.gap(0.0, 1.0) < 1e-300 && straight.stride(0.0, 1e-3) > 1.0);
    }
}
