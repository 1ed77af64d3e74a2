//! One step of `x'' = f(x)`: the Runge-Kutta-Nystroem pair of order 8(6) with nine stages of Dormand, El-Mikkawy and Prince, and the classic
//! method of order 4.
//!
//! Sources: Dormand, El-Mikkawy and Prince 1987, "High-order embedded Runge-Kutta-Nystrom formulae", IMA J. Numer. Anal. 7 (RKN8(6)9FM);
//! Hairer, Norsett and Wanner 1993, "Solving Ordinary Differential Equations I", section II.14 (order 4).

use crate::arithmetic::space::Space;
use bhs_core::real::Real;

// Measured against Taylor series of 17 terms for two extremal holes (which tables do not have): those take as many steps at a tolerance of 1e-7 and
// half as many at 1e-12, but 3.3 and 1.6 times the time.

/// Position, velocity and acceleration.
#[derive(Clone, Copy, Debug)]
pub struct State<S> {
    /// Position.
    pub x: S,
    /// Its derivative.
    pub v: S,
    /// Its second derivative.
    pub a: S,
}

impl<S> State<S> {
    /// Where `which` says so, this, elsewhere `o`.
    #[inline(always)]
    pub fn or<F: Real>(&self, o: &Self, which: F::Mask) -> Self
    where
        S: Space<F>,
    {
        Self { x: self.x.or(o.x, which), v: self.v.or(o.v, which), a: self.a.or(o.a, which) }
    }
}

/// Where a step leads, and by how much the method of order 6 would have it elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct Step<S> {
    /// The end.
    pub end: State<S>,
    /// The error of the lower order: position, and velocity times the step.
    pub error: [S; 2],
}

/// Times of the stages.
const C: [f64; 9] = [0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0, 1.0];

/// What each stage has of those before it.
const A: [&[f64]; 9] = [
    &[],
    &[1.0 / 800.0],
    &[1.0 / 600.0, 1.0 / 300.0],
    &[9.0 / 200.0, -9.0 / 100.0, 9.0 / 100.0],
    &[-66_701.0 / 197_352.0, 28_325.0 / 32_892.0, -2_665.0 / 5_482.0, 2_170.0 / 24_669.0],
    &[
        227_015_747.0 / 304_251_000.0,
        -54_897_451.0 / 30_425_100.0,
        12_942_349.0 / 10_141_700.0,
        -9_499.0 / 304_251.0,
        539.0 / 9_250.0,
    ],
    &[
        -1_131_891_597.0 / 901_789_000.0,
        41_964_921.0 / 12_882_700.0,
        -6_663_147.0 / 3_220_675.0,
        270_954.0 / 644_135.0,
        -108.0 / 5_875.0,
        114.0 / 1_645.0,
    ],
    &[
        13_836_959.0 / 3_667_458.0,
        -17_731_450.0 / 1_833_729.0,
        1_063_919_505.0 / 156_478_208.0,
        -33_213_845.0 / 39_119_552.0,
        13_335.0 / 28_544.0,
        -705.0 / 14_272.0,
        1_645.0 / 57_088.0,
    ],
    &[223.0 / 7_938.0, 0.0, 1_175.0 / 8_064.0, 925.0 / 6_048.0, 41.0 / 448.0, 925.0 / 14_112.0, 1_175.0 / 72_576.0, 0.0],
];

/// Weights of the velocity, order 8.
const B: [f64; 8] = [
    223.0 / 7_938.0,
    0.0,
    5_875.0 / 36_288.0,
    4_625.0 / 21_168.0,
    41.0 / 224.0,
    4_625.0 / 21_168.0,
    5_875.0 / 36_288.0,
    223.0 / 7_938.0,
];

/// Weights of the position less those of order 6.
const ERROR_X: [f64; 7] = [
    223.0 / 7_938.0 - 7_987_313.0 / 109_941_300.0,
    0.0,
    1_175.0 / 8_064.0 - 1_610_737.0 / 44_674_560.0,
    925.0 / 6_048.0 - 10_023_263.0 / 33_505_920.0,
    41.0 / 448.0 + 497_221.0 / 12_409_600.0,
    925.0 / 14_112.0 - 10_023_263.0 / 78_180_480.0,
    1_175.0 / 72_576.0 - 1_610_737.0 / 402_071_040.0,
];

/// Weights of the velocity less those of order 6.
const ERROR_V: [f64; 9] = [
    223.0 / 7_938.0 - 7_987_313.0 / 109_941_300.0,
    0.0,
    5_875.0 / 36_288.0 - 1_610_737.0 / 40_207_104.0,
    4_625.0 / 21_168.0 - 10_023_263.0 / 23_454_144.0,
    41.0 / 224.0 + 497_221.0 / 6_204_800.0,
    4_625.0 / 21_168.0 - 10_023_263.0 / 23_454_144.0,
    5_875.0 / 36_288.0 - 1_610_737.0 / 40_207_104.0,
    223.0 / 7_938.0 + 4_251_941.0 / 54_970_650.0,
    -3.0 / 20.0,
];

/// One step of order 8 of length `h` of `x'' = force(x)`: eight evaluations.
#[inline(always)]
pub fn step<F: Real, S: Space<F>>(force: impl Fn(S) -> S, start: &State<S>, h: F) -> Step<S> {
    let c = F::splat;
    let hh = h * h;
    let State { x, v, a } = *start;
    let mut k = [a; 9];
    macro_rules! stage {
        ($($i:literal)*) => { $(
            k[$i] = force(combined(x.plus(v, h * c(C[$i])), &k, A[$i], hh));
        )* };
    }
    stage!(1 2 3 4 5 6 7);
    let x = combined(x.plus(v, h), &k, A[8], hh);
    let v = combined(v, &k, &B, h);
    k[8] = force(x);
    let error = |weights: &[f64]| {
        let mut sum = k[0].times(c(weights[0]));
        for (k, w) in k.iter().zip(weights).skip(2) {
            sum = sum.plus(*k, c(*w));
        }
        sum.times(hh)
    };
    Step { end: State { x, v, a: k[8] }, error: [error(&ERROR_X), error(&ERROR_V)] }
}

/// `from + scale (weights[0] k[0] + weights[1] k[1] + ...)`
#[inline(always)]
fn combined<F: Real, S: Space<F>>(from: S, k: &[S; 9], weights: &[f64], scale: F) -> S {
    let mut sum = k[0].times(F::splat(weights[0]));
    for (k, w) in k.iter().zip(weights).skip(1) {
        if *w != 0.0 {
            sum = sum.plus(*k, F::splat(*w));
        }
    }
    from.plus(sum, scale)
}

/// One step of order 4 of length `h` of `x'' = force(x)`: three evaluations.
#[inline(always)]
pub fn rk4<F: Real, S: Space<F>>(force: impl Fn(S) -> S, start: &State<S>, h: F) -> State<S> {
    let c = F::splat;
    let hh = h * h;
    let State { x, v, a } = *start;
    let middle = force(x.plus(v, h * c(0.5)).plus(a, hh * c(0.125)));
    let last = force(x.plus(v, h).plus(middle, hh * c(0.5)));
    let x = x.plus(v, h).plus(a.plus(middle, c(2.0)), hh * c(1.0 / 6.0));
    let v = v.plus(a.plus(middle, c(4.0)).plus(last, c(1.0)), h * c(1.0 / 6.0));
    State { x, v, a: force(x) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::real::Vector;
    use glam::DVec3;

    /// Kepler's motion with eccentricity 0.5, from the nearest point on, after once around in `n` steps.
    fn once_around<F: Real>(n: u32, order_8: bool) -> f64 {
        let force = |x: Vector<F>| x * (F::splat(-1.0) / (x.length_squared() * x.length()));
        let x = Vector::all(DVec3::new(0.5, 0.0, 0.0));
        let v = Vector::all(DVec3::new(0.0, 3f64.sqrt(), 0.0));
        let mut state = State { x, v, a: force(x) };
        let h = F::splat(2.0 * std::f64::consts::PI / f64::from(n));
        for _ in 0..n {
            state = if order_8 { step(force, &state, h).end } else { rk4(force, &state, h) };
        }
        (state.x - x).lane(0).length()
    }

    #[test]
    fn orders_are_eight_and_four() {
        let order = |n, eight| (once_around::<f64>(n, eight) / once_around::<f64>(2 * n, eight)).log2();
        assert!((order(60, true) - 8.0).abs() < 0.6, "{}", order(60, true));
        assert!((order(400, false) - 4.0).abs() < 0.3, "{}", order(400, false));
        assert_eq!(once_around::<f64>(60, true), once_around::<bhs_core::lanes::Lanes>(60, true));
    }

    #[test]
    fn weights_are_those_of_quadratures() {
        for k in 0..8 {
            let sum = |weights: &[f64]| weights.iter().zip(C).map(|(w, c)| w * f64::powi(c, k)).sum::<f64>();
            let n = f64::from(k);
            assert!((sum(&B) - 1.0 / (n + 1.0)).abs() < 1e-15, "{k}");
            assert!(k == 7 || (sum(A[8]) - 1.0 / ((n + 1.0) * (n + 2.0))).abs() < 1e-15, "{k}");
            // The embedded method is of order 6.
            assert!((sum(&ERROR_V).abs() < 1e-15) == (k < 6), "{k}: {}", sum(&ERROR_V));
            assert!((sum(&ERROR_X).abs() < 1e-15) == (k < 5), "{k}: {}", sum(&ERROR_X));
        }
    }
}
