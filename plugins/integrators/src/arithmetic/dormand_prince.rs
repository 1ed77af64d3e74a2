//! One step of `y' = f(y)`: the Runge-Kutta pair of order 8(5, 3) of Dormand and Prince with its dense output of order 7.
//!
//! Source: Hairer, Norsett and Wanner 1993, "Solving Ordinary Differential Equations I", sections II.5 and II.6 (the method DOP853, with the
//! coefficients of its appendix).

use crate::arithmetic::space::Space;
use bhs_core::real::Real;
use tableau::{DENSE, DENSE_STAGES, ERROR_3, ERROR_5, STAGES};

mod tableau;

/// A step.
#[derive(Clone, Copy, Debug)]
pub struct Step<S> {
    /// The stages; the last is the derivative at the end.
    k: [S; 13],
    start: S,
    /// Where it leads.
    pub end: S,
    /// Errors of methods of order 5 and 3.
    pub errors: [S; 2],
}

impl<S> Step<S> {
    /// The derivative at the end, which the next step begins with.
    pub fn slope(&self) -> S
    where
        S: Copy,
    {
        self.k[12]
    }
}

/// One step of `y' = f(y)` of length `h` from `start`, where `f` is `slope`: twelve evaluations.
#[inline(always)]
pub fn step<F: Real, S: Space<F>>(f: impl Fn(S) -> S, start: S, slope: S, h: F) -> Step<S> {
    let mut k = [slope; 13];
    for i in 0..12 {
        k[i + 1] = f(start.plus(sum(&k, STAGES[i]), h));
    }
    let last = sum(&k, STAGES[11]);
    let third = last.plus(sum(&k, &ERROR_3), F::splat(-1.0));
    Step { k, start, end: start.plus(last, h), errors: [sum(&k, &ERROR_5).times(h), third.times(h)] }
}

/// The norm of the error of a step from norms of those of order 5 and 3: of order 8.
#[inline(always)]
pub fn error<F: Real>([fifth, third]: [F; 2]) -> F {
    let squares = fifth * fifth;
    let norm = third.times_plus(third * F::splat(0.01), squares);
    squares / norm.sqrt().max(F::splat(f64::MIN_POSITIVE))
}

impl<S> Step<S> {
    /// Coefficients of the polynomial of degree 7, with t from 0 to 1, that is the dense output of order 7; `h` is the length. Three evaluations.
    #[inline(always)]
    pub fn dense<F: Real>(&self, f: impl Fn(S) -> S, h: F) -> [S; 8]
    where
        S: Space<F>,
    {
        let c = F::splat;
        let minus = c(-1.0);
        let mut k = [self.k[0]; 16];
        k[..13].copy_from_slice(&self.k);
        for i in 0..3 {
            k[13 + i] = f(self.start.plus(sum(&k, DENSE_STAGES[i]), h));
        }
        // y0 + t (r1 + (1-t) (r2 + t (r3 + (1-t) (r4 + t (r5 + (1-t) (r6 + t r7))))))
        let rise = self.end.plus(self.start, minus);
        let [first, last] = [0, 12].map(|i| k[i].times(h));
        let r2 = first.plus(rise, minus);
        let r3 = rise.times(c(2.0)).plus(last.plus(first, c(1.0)), minus);
        let [r4, r5, r6, r7] = DENSE.map(|weights| sum(&k, weights).times(h));
        let zero = rise.times(c(0.0));
        let mut p = [zero; 8];
        p[0] = r7;
        for (n, r) in [r6, r5, r4, r3, r2, rise, self.start].into_iter().enumerate() {
            // Times t or 1 - t in turn, of degree n so far.
            if n % 2 == 0 {
                for i in (0..=n).rev() {
                    p[i + 1] = p[i];
                }
                p[0] = r;
            } else {
                for i in (0..=n).rev() {
                    p[i + 1] = p[i + 1].plus(p[i], minus);
                }
                p[0] = p[0].plus(r, c(1.0));
            }
        }
        p
    }
}

/// `of[i] weight + ...`
#[inline(always)]
fn sum<F: Real, S: Space<F>>(of: &[S], weights: &[(usize, f64)]) -> S {
    let (i, weight) = weights[0];
    let mut sum = of[i].times(F::splat(weight));
    for (i, weight) in &weights[1..] {
        sum = sum.plus(of[*i], F::splat(*weight));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::real::Vector;

    /// A pendulum that also turns.
    fn f(y: [Vector<f64>; 2]) -> [Vector<f64>; 2] {
        let [a, b] = y;
        [Vector { x: b.x, y: b.y, z: 1.0 + a.y * b.x }, Vector { x: -a.x.sin(), y: -a.y + a.x * a.z, z: a.y }]
    }

    const START: [Vector<f64>; 2] = [Vector { x: 0.5, y: -0.2, z: 0.1 }, Vector { x: 1.1, y: 0.3, z: 0.4 }];

    fn after(n: u32) -> [Vector<f64>; 2] {
        let (mut y, h) = (START, 2.0 / f64::from(n));
        for _ in 0..n {
            y = step(f, y, f(y), h).end;
        }
        y
    }

    fn off(a: [Vector<f64>; 2], b: [Vector<f64>; 2]) -> f64 {
        a.plus(b, -1.0).iter().map(|v| v.largest()).fold(0.0, f64::max)
    }

    #[test]
    fn order_is_eight() {
        let right = after(64);
        let (a, b) = (off(after(4), right), off(after(8), right));
        assert!(((a / b).log2() - 8.0).abs() < 0.7, "{a:e} {b:e}");
    }

    #[test]
    fn dense_output_is_of_order_seven_and_meets_both_ends() {
        let largest = |h: f64| {
            let one = step(f, START, f(START), h);
            let p = one.dense(f, h);
            let at = |t: f64| p.iter().rev().copied().reduce(|sum, c| c.plus(sum, t)).unwrap();
            assert!(off(at(0.0), START) == 0.0 && off(at(1.0), one.end) < 1e-14);
            let slope = p.iter().enumerate().map(|(k, c)| c.times(k as f64)).reduce(|a, b| a.plus(b, 1.0)).unwrap();
            assert!(off(slope.times(1.0 / h), one.slope()) < 1e-12);
            let errors = [0.2, 0.4, 0.6, 0.8].map(|t| off(at(t), step(f, START, f(START), t * h).end));
            errors.into_iter().fold(0.0, f64::max)
        };
        let (a, b) = (largest(0.8), largest(0.4));
        assert!((a / b).log2() > 7.3, "{a:e} {b:e}");
    }

    #[test]
    fn weights_are_those_of_quadratures() {
        let c: Vec<f64> = std::iter::once(0.0)
            .chain(STAGES.iter().chain(&DENSE_STAGES).map(|row| row.iter().map(|(_, weight)| weight).sum()))
            .collect();
        let expected = [1.0 / 3.0, 0.25, 4.0 / 13.0, 127.0 / 195.0, 0.6, 6.0 / 7.0, 1.0, 1.0, 0.1, 0.2, 7.0 / 9.0];
        for (found, expected) in c[5..].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
        for k in 0..8 {
            let sum = |weights: &[(usize, f64)]| weights.iter().map(|(i, w)| w * c[*i].powi(k)).sum::<f64>();
            assert!((sum(STAGES[11]) - 1.0 / f64::from(k + 1)).abs() < 1e-14, "{k}");
            assert!((sum(&ERROR_5).abs() < 1e-14) == (k < 5), "{k}: {}", sum(&ERROR_5));
            assert!(((sum(&ERROR_3) - 1.0 / f64::from(k + 1)).abs() < 1e-14) == (k < 3), "{k}: {}", sum(&ERROR_3));
            // Along a power of t the dense output is exact, so the sum of its last coefficients is that of its parts.
            if k < 7 {
                let at = |t: f64| {
                    let rise = 1.0 / f64::from(k + 1);
                    let (first, last) = (if k == 0 { 1.0 } else { 0.0 }, 1.0);
                    let r = [
                        rise,
                        first - rise,
                        2.0 * rise - last - first,
                        sum(DENSE[0]),
                        sum(DENSE[1]),
                        sum(DENSE[2]),
                        sum(DENSE[3]),
                    ];
                    let s = 1.0 - t;
                    t * (r[0] + s * (r[1] + t * (r[2] + s * (r[3] + t * (r[4] + s * (r[5] + t * r[6]))))))
                };
                for t in [0.2, 0.5, 0.9] {
                    assert!((at(t) - t.powi(k + 1) / f64::from(k + 1)).abs() < 1e-13, "{k} {t}: {}", at(t));
                }
            }
        }
    }

    #[test]
    fn errors_are_estimated() {
        let one = step(f, START, f(START), 0.8);
        let right = (0..8).fold(START, |y, _| step(f, y, f(y), 0.1).end);
        let estimate = error(one.errors.map(|e| e.map(|v| v.largest())).map(|[a, b]| a.max(b)));
        let real = off(one.end, right);
        assert!(estimate > 0.3 * real && estimate < 300.0 * real, "{estimate:e} {real:e}");
    }
}
