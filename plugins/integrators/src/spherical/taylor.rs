//! Light orbits around a round hole by long Taylor steps.
//!
//! `u'' = (3/2) rs u^2 - u` gives the Taylor coefficients of u one after the other, each by one short sum over the former:
//!
//! `(n+1)(n+2) c[n+2] = (3/2) rs (c[0] c[n] + c[1] c[n-1] + ... + c[n] c[0]) - c[n]`
//!
//! and with a charge `- 2 q^2 (c c c)[n]`, by one more sum over those of u^2. They are the dense output as well. A step is as long as the last coefficients allow (Jorba and Zou 2005, "A software
//! package for the numerical integration of ODEs by means of high-order Taylor methods", Experimental Mathematics 14).

use crate::arithmetic::polynomial::{LARGEST_ANGLE, TERMS, cos_sin, value, value_and_slope};
use crate::spherical::Attraction;
use crate::spherical::orbit::{Dense, Fate, Polar, State, Stepper, room};
use bhs_core::real::{Real, fma};

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

/// An orbit stepped by Taylor series.
#[derive(Clone, Copy, Debug)]
pub struct TaylorOrbit {
    hole: Attraction,
    state: Polar,
    /// Largest error of u in a step.
    error: f64,
}

impl TaylorOrbit {
    /// The orbit from `start`. Its points stray from the true orbit by about `error` times the distance from the hole, as far as
    /// double precision goes.
    ///
    /// An error of u moves a point across the ray by its ratio to 1/b times r. Near the critical impact parameter more is
    /// asked of a step: there an error on the way in changes `epsilon = (rs/b)^2 - 4/27`, and the angle at which the ray
    /// leaves by the relative change of epsilon. What cannot be asked for is an epsilon better than rounding: the angle is
    /// uncertain by some 1e-15/|epsilon|.
    pub fn new(hole: impl Into<Attraction>, start: State, error: f64) -> Self {
        let hole = hole.into();
        let (inverse_b_squared, closeness) = if hole.is_charged() {
            let inverse_b_squared = start.du * start.du + hole.barrier(start.u);
            (inverse_b_squared, ((inverse_b_squared - hole.critical).abs() / inverse_b_squared).min(1.0))
        } else {
            let rs = hole.rs;
            let inverse_b_squared = start.du * start.du + start.u * start.u * (1.0 - rs * start.u);
            let epsilon = inverse_b_squared * rs * rs - 4.0 / 27.0;
            (inverse_b_squared, (epsilon.abs() / (inverse_b_squared * rs * rs)).min(1.0))
        };
        let error = inverse_b_squared.sqrt() * (SAFETY * error * closeness).max(0.5 * f64::EPSILON);
        Self { hole, state: Polar { state: start, cos: start.phi.cos(), sin: start.phi.sin() }, error }
    }
}

/// Share of the error that one step may make: the last coefficients overestimate its error, later steps magnify it.
pub(crate) const SAFETY: f64 = 0.4;

/// A Taylor step: a polynomial in the angle since its start.
#[derive(Clone, Copy, Debug)]
pub struct TaylorStep {
    c: [f64; TERMS],
    start: Polar,
    end: State,
}

impl TaylorStep {
    /// Cosine and sine of the angle `t` after the start.
    #[inline(always)]
    fn cos_sin(&self, t: f64) -> (f64, f64) {
        let (cos, sin) = cos_sin(t);
        let Polar { cos: c0, sin: s0, .. } = self.start;
        (fma(c0, cos, -s0 * sin), fma(s0, cos, c0 * sin))
    }
}

impl TaylorStep {
    /// Coefficients of u, start and end.
    pub(crate) fn parts(&self) -> ([f64; TERMS], Polar, State) {
        (self.c, self.start, self.end)
    }

    /// The step with the coefficients `c` from `start` to `end`.
    pub(crate) fn from_parts(c: [f64; TERMS], start: Polar, end: State) -> Self {
        Self { c, start, end }
    }
}

impl Dense for TaylorStep {
    #[inline]
    fn start(&self) -> State {
        self.start.state
    }

    #[inline]
    fn end(&self) -> State {
        self.end
    }

    #[inline]
    fn at(&self, phi: f64) -> State {
        let (u, du) = value_and_slope(&self.c, phi - self.start.state.phi);
        State { phi, u, du }
    }

    #[inline]
    fn place(&self, phi: f64) -> (f64, f64, f64) {
        let t = phi - self.start.state.phi;
        let (cos, sin) = self.cos_sin(t);
        (value(&self.c, t), cos, sin)
    }

    #[inline]
    fn polar(&self, phi: f64) -> Polar {
        let (cos, sin) = self.cos_sin(phi - self.start.state.phi);
        Polar { state: self.at(phi), cos, sin }
    }

    fn until(self, end: State) -> Self {
        Self { end, ..self }
    }
}

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
    let first = fma(F::splat(bend), u, F::splat(-1.0));
    // Spelled out, the sums have fixed lengths.
    macro_rules! next {
        ($($n:literal)*) => { $( c[$n + 2] = next::<F, $n>(&c, bend, first); )* };
    }
    c[2] = u * fma(F::splat(0.5 * bend), u, F::splat(-1.0)) * F::splat(0.5);
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
        let force = fma(F::splat(1.5 * hole.rs), squares[n], fma(F::splat(-2.0 * hole.charge_squared), cubes, -c[n]));
        c[n + 2] = force * F::splat(1.0 / ((n + 1) * (n + 2)) as f64);
    }
    c
}

/// Coefficient number n of the product of two series.
#[inline(always)]
fn product<F: Real>(a: &[F], b: &[F], n: usize) -> F {
    let mut sum = a[0] * b[n];
    for i in 1..=n {
        sum = fma(a[i], b[n - i], sum);
    }
    sum
}

/// Coefficient N + 2 from those before it, N > 0; `bend` is 3 rs, `first` is `bend c[0] - 1`. The newest of them, c[N], comes in last, so that
/// nothing else waits for it.
#[inline(always)]
fn next<F: Real, const N: usize>(c: &[F; TERMS], bend: f64, first: F) -> F {
    let mut pairs = if N.is_multiple_of(2) { F::splat(0.5) * c[N / 2] * c[N / 2] } else { F::splat(0.0) };
    for i in (1..N.div_ceil(2)).rev() {
        pairs = fma(c[i], c[N - i], pairs);
    }
    let inverse = 1.0 / ((N + 1) * (N + 2)) as f64;
    fma(first * F::splat(inverse), c[N], F::splat(bend * inverse) * pairs)
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

impl Stepper for TaylorOrbit {
    type Step = TaylorStep;

    fn advance(&mut self) -> (TaylorStep, Fate) {
        let start = self.state.state;
        let c = coefficients(&self.hole, start.u, start.du);
        // The last two coefficients, for one of them is zero where the orbit is symmetric; as no step is longer than LONGEST,
        // the very last counts for no more than so many times the one before. And two more, for coefficients change sign and
        // may be small by chance: these would shrink by 8 or so if the nearest pole were some 3 rad away, as it is near the hole.
        let pair = |n: usize| c[n].abs() + LONGEST * c[n + 1].abs();
        let last = pair(TERMS - 2) + 0.125 * pair(TERMS - 4);
        // Most steps may be the longest: the root, which costs as much as a fifth of the step, is not needed for that.
        let share = self.error / last;
        let longest = if share >= LONGEST_POWER { LONGEST } else { root(share) };
        let h = room(self.hole, &start, longest);
        let whole = TaylorStep { c, start: self.state, end: start };
        self.state = whole.polar(start.phi + h);
        let step = whole.until(self.state.state);
        (step, step.fate(self.hole))
    }
}
