//! From steps to curves: polynomials through what a step of `x'' = f(x)` knows at its ends, and at places in between that they lead to.

use crate::arithmetic::space::Space;
use crate::graded_index::nystroem::State;
use crate::tracing::polynomial_arc::TERMS;
use bhs_core::real::Real;

/// Of the second derivative at the ends and at the quarters, of the change of velocity and of what position does beyond velocity: what the
/// coefficients from the third on of the polynomial of degree 8 have of each.
const DEGREE_8: [[f64; 7]; 6] = [
    [-419.0 / 90.0, -128.0 / 15.0, -24.0 / 5.0, -128.0 / 45.0, -1.0 / 6.0, 0.0, 42.0],
    [1547.0 / 90.0, 2176.0 / 45.0, 104.0 / 5.0, 896.0 / 45.0, 101.0 / 45.0, -21.0, -175.0],
    [-971.0 / 30.0, -1664.0 / 15.0, -40.0, -896.0 / 15.0, -269.0 / 30.0, 105.0, 294.0],
    [1486.0 / 45.0, 128.0, 216.0 / 5.0, 3968.0 / 45.0, 78.0 / 5.0, -196.0, -224.0],
    [-784.0 / 45.0, -3328.0 / 45.0, -128.0 / 5.0, -2816.0 / 45.0, -112.0 / 9.0, 160.0, 64.0],
    [56.0 / 15.0, 256.0 / 15.0, 32.0 / 5.0, 256.0 / 15.0, 56.0 / 15.0, -48.0, 0.0],
];

/// The same of degree 5, of the second derivative at the ends, velocity and position.
const DEGREE_5: [[f64; 4]; 3] = [[-1.5, 0.5, -4.0, 10.0], [1.5, -1.0, 7.0, -15.0], [-0.5, 0.5, -3.0, 6.0]];

/// `h` times the change of velocity in a step, and what position does beyond `h v`.
#[inline(always)]
fn changes<F: Real, S: Space<F>>(from: &State<S>, to: &State<S>, h: F) -> (S, S) {
    let minus = F::splat(-1.0);
    (to.v.plus(from.v, minus).times(h), to.x.plus(from.x, minus).plus(from.v, -h))
}

#[inline(always)]
fn sum<F: Real, S: Space<F>, const N: usize>(of: &[S; N], weights: [f64; N]) -> S {
    let mut sum = of[0].times(F::splat(weights[0]));
    for i in 1..N {
        if weights[i] != 0.0 {
            sum = sum.plus(of[i], F::splat(weights[i]));
        }
    }
    sum
}

/// Coefficients of the polynomial of degree 8 (with t from 0 to 1) that leads from the one state to the other in the parameter `h`: four more
/// evaluations of `x'' = force(x)`. Its error is no larger than that of a step of order 8.
#[inline(always)]
pub fn degree_8<F: Real, S: Space<F>>(force: impl Fn(S) -> S, from: &State<S>, to: &State<S>, h: F) -> [S; TERMS] {
    let hh = h * h;
    let (v, x) = changes(from, to, h);
    let (first, last) = (from.a.times(hh), to.a.times(hh));
    let force_at = |share: f64, beyond: S| force(from.x.plus(from.v, h * F::splat(share)).plus(beyond, F::splat(1.0))).times(hh);
    // The middle of the polynomial of degree 5; with it the quarters of that of degree 6; with them the middle again, of that of degree 7.
    let middle = force_at(0.5, sum(&[first, last, v, x], [1.0 / 64.0, 1.0 / 64.0, -5.0 / 32.0, 0.5]));
    let of_6 = [first, middle, last, v, x];
    let quarter = force_at(0.25, sum(&of_6, [9.0 / 1024.0, -9.0 / 512.0, 0.0, -3.0 / 256.0, 53.0 / 512.0]));
    let three = force_at(0.75, sum(&of_6, [0.0, -9.0 / 512.0, 9.0 / 1024.0, -81.0 / 512.0, 459.0 / 512.0]));
    let of_7 = [first, quarter, three, last, v, x];
    let middle = force_at(0.5, sum(&of_7, [17.0 / 576.0, 1.0 / 9.0, 1.0 / 9.0, 17.0 / 576.0, -13.0 / 32.0, 0.5]));
    let known = [first, quarter, middle, three, last, v, x];
    let [c3, c4, c5, c6, c7, c8] = DEGREE_8.map(|weights| sum(&known, weights));
    [from.x, from.v.times(h), first.times(F::splat(0.5)), c3, c4, c5, c6, c7, c8]
}

/// Coefficients of the polynomial of degree 5 that has position, velocity and acceleration of both states.
#[inline(always)]
pub fn degree_5<F: Real, S: Space<F>>(from: &State<S>, to: &State<S>, h: F) -> [S; TERMS] {
    let hh = h * h;
    let (v, x) = changes(from, to, h);
    let known = [from.a.times(hh), to.a.times(hh), v, x];
    let [c3, c4, c5] = DEGREE_5.map(|weights| sum(&known, weights));
    let zero = known[0].times(F::splat(0.0));
    [from.x, from.v.times(h), known[0].times(F::splat(0.5)), c3, c4, c5, zero, zero, zero]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graded_index::nystroem::step;
    use crate::tracing::arc::Arc;
    use crate::tracing::polynomial_arc::PolynomialArc;
    use bhs_core::real::Vector;
    use glam::DVec3;

    fn force(x: Vector<f64>) -> Vector<f64> {
        x * (-1.0 / (x.length_squared() * x.length()))
    }

    /// Largest errors within a step of the length `h` of a circle of radius 1 that is followed with speed 1.
    fn errors(h: f64) -> [f64; 2] {
        let x = Vector { x: 1.0, y: 0.0, z: 0.0 };
        let from = State { x, v: Vector { x: 0.0, y: 1.0, z: 0.0 }, a: force(x) };
        let at = |s: f64| {
            let (sin, cos) = s.sin_cos();
            State {
                x: Vector { x: cos, y: sin, z: 0.0 },
                v: Vector { x: -sin, y: cos, z: 0.0 },
                a: Vector { x: -cos, y: -sin, z: 0.0 },
            }
        };
        let to = at(h);
        [degree_8(force, &from, &to, h), degree_5(&from, &to, h)].map(|c| {
            let arc = PolynomialArc::new(c, 0.0, h);
            (0..=20)
                .map(|k| {
                    let s = h * f64::from(k) / 20.0;
                    let (x, v) = arc.point_and_tangent(s);
                    DVec3::from(x - at(s).x).length().max(h * DVec3::from(v - at(s).v).length())
                })
                .fold(0.0, f64::max)
        })
    }

    #[test]
    fn orders_are_nine_and_six() {
        let ([a8, a5], [b8, b5]) = (errors(0.8), errors(0.4));
        assert!((a8 / b8).log2() > 8.7 && (a5 / b5).log2() > 5.7, "{a8:e} {b8:e} {a5:e} {b5:e}");
        // Within a step there is no more error than at its end.
        let x = Vector { x: 1.0, y: 0.0, z: 0.0 };
        let start = State { x, v: Vector { x: 0.0, y: 1.0, z: 0.0 }, a: force(x) };
        let end = step(force, &start, 0.8).end.x;
        let off = DVec3::from(end - Vector { x: 0.8f64.cos(), y: 0.8f64.sin(), z: 0.0 }).length();
        assert!(a8 < 2.0 * off, "{a8:e} {off:e}");
    }
}
