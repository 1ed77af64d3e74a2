//! Taylor series of light orbits around a round hole.
//!
//! `u'' = (3/2) rs u^2 - u` gives the Taylor coefficients of u one after the other, each by one short sum over the former:
//!
//! `(n+1)(n+2) c[n+2] = (3/2) rs (c[0] c[n] + c[1] c[n-1] + ... + c[n] c[0]) - c[n]`
//!
//! and with a charge `- 2 q^2 (c c c)[n]`, by one more sum over those of u^2. They are the dense output as well. A step is as long as the last coefficients allow (Jorba and Zou 2005, "A software
//! package for the numerical integration of ODEs by means of high-order Taylor methods", Experimental Mathematics 14).

use crate::arithmetic::polynomial::{LARGEST_ANGLE, TERMS};
use crate::spherical::Attraction;
use bhs_core::real::{Real, times_plus};

// Number of coefficients: measured on rays through a room with a hole, at relative errors of 1e-4 to 1e-10: with 14 to 18 a
// geodesic takes the least time, 2 to 4 steps. (The pair of Dormand and Prince, order 5(4), with PI control took 1.4 times as
// long at 1e-6, in 7 steps; 2.4 times at 1e-8, in 18; 6 times at 1e-10, in 43.)

/// Longest step, in radians. A straight line sweeps 180 degrees; half of it keeps the ends of an orbit apart.
pub(crate) const LONGEST: f64 = 1.5;

const _: () = assert!(LONGEST < LARGEST_ANGLE);

/// `LONGEST` to the power TERMS - 2.
pub(crate) const LONGEST_POWER: f64 = {
    let (mut power, mut n) = (1.0, 0);
    while n < TERMS - 2 {
        power *= LONGEST;
        n += 1;
    }
    power
};

/// Share of the error that one step may make: the last coefficients overestimate its error, later steps magnify it.
pub(crate) const SAFETY: f64 = 0.4;

/// The Taylor coefficients of the orbit through (u, u').
#[inline]
pub(crate) fn coefficients<F: Real>(hole: &Attraction, u: F, du: F) -> [F; TERMS] {
    if hole.is_charged() { charged(hole, u, du) } else { uncharged(hole.rs, u, du) }
}

/// The same without charge.
#[inline(always)]
fn uncharged<F: Real>(rs: f64, u: F, du: F) -> [F; TERMS] {
    let mut c = [F::splat(0.0); TERMS];
    (c[0], c[1]) = (u, du);
    let bend = 3.0 * rs;
    let first = times_plus(F::splat(bend), u, F::splat(-1.0));
    // Spelled out, the sums have fixed lengths.
    macro_rules! next {
        ($($n:literal)*) => { $( c[$n + 2] = next::<F, $n>(&c, bend, first); )* };
    }
    c[2] = u * times_plus(F::splat(0.5 * bend), u, F::splat(-1.0)) * F::splat(0.5);
    next!(1 2 3 4 5 6 7 8 9 10 11 12 13);
    c
}

/// The same with a charge: those of u^2 are found along with them.
#[inline(always)]
fn charged<F: Real>(hole: &Attraction, u: F, du: F) -> [F; TERMS] {
    let mut c = [F::splat(0.0); TERMS];
    let mut squares = [F::splat(0.0); TERMS - 2];
    (c[0], c[1]) = (u, du);
    for n in 0..TERMS - 2 {
        squares[n] = product(&c, &c, n);
        let cubes = product(&squares, &c, n);
        let force =
            times_plus(F::splat(1.5 * hole.rs), squares[n], times_plus(F::splat(-2.0 * hole.charge_squared), cubes, -c[n]));
        c[n + 2] = force * F::splat(1.0 / ((n + 1) * (n + 2)) as f64);
    }
    c
}

/// Coefficient number n of the product of two series.
#[inline(always)]
fn product<F: Real>(a: &[F], b: &[F], n: usize) -> F {
    let mut sum = a[0] * b[n];
    for i in 1..=n {
        sum = times_plus(a[i], b[n - i], sum);
    }
    sum
}

/// Coefficient N + 2 from those before it, N > 0; `bend` is 3 rs, `first` is `bend c[0] - 1`. The newest of them, c[N], comes in last, so that
/// nothing else waits for it.
#[inline(always)]
fn next<F: Real, const N: usize>(c: &[F; TERMS], bend: f64, first: F) -> F {
    let mut pairs = if N.is_multiple_of(2) { F::splat(0.5) * c[N / 2] * c[N / 2] } else { F::splat(0.0) };
    for i in (1..N.div_ceil(2)).rev() {
        pairs = times_plus(c[i], c[N - i], pairs);
    }
    let inverse = 1.0 / ((N + 1) * (N + 2)) as f64;
    times_plus(first * F::splat(inverse), c[N], F::splat(bend * inverse) * pairs)
}

/// The root of `share`, between 1e-300 and [`LONGEST_POWER`], that belongs to the last coefficients: to 3 %, and rather too small.
///
/// A logarithm is the bits of a number, nearly; Newton's method does the rest.
#[inline]
pub(crate) fn root(share: f64) -> f64 {
    const N: i64 = TERMS as i64 - 2;
    const ONE: i64 = 1.0f64.to_bits() as i64;
    let guess = f64::from_bits(((share.to_bits() as i64 - ONE) / N + ONE) as u64);
    let square = guess * guess;
    let fourth = square * square;
    let power = fourth * fourth * fourth * square;
    0.975 * (guess + guess * (share / power - 1.0) / N as f64)
}
