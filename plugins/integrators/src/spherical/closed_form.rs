//! The orbit of light around a Schwarzschild hole in closed form: u(phi) from u(0) and u'(0), at any angle, at once.
//!
//! With `w = rs u` and `delta = w - 2/3`, measured from the photon sphere, the orbit equation reads
//!
//! `delta'' = delta + (3/2) delta^2`,  `delta'^2 = delta^3 + delta^2 + epsilon`,  `epsilon = (rs/b)^2 - 4/27`
//!
//! and one number, epsilon, tells the orbits apart: at 0 they wind around the photon sphere for ever, below it they turn back,
//! above it they pass through. All orbits with the same epsilon are one function p(phi) at shifted (maybe complex) angles: p is
//! the one with its pole at 0, `p = 4 wp - 1/3` in terms of the Weierstrass function. The addition theorem shifts it to where
//! the orbit begins: (p, p'), (delta0, delta0') and the orbit's (delta, -delta') lie on a line of slope lambda, hence
//!
//! `delta - delta0 = 2 (delta0'' - delta0' lambda) / (p - delta0)`,  `delta' = -(delta0' + lambda (delta - delta0))`
//!
//! with `lambda = (p' - delta0') / (p - delta0)`. This is the formula of Biermann and Weierstrass, arranged so that nothing
//! cancels but what cancels in the orbit itself. No case split by kind of orbit, no turning points, no steps.
//!
//! Precision: epsilon is computed in double-double, and p without subtracting nearly equal numbers, so that the error of u
//! is some rounding errors of u itself and of `u' phi`, however close to b_crit the orbit is and however often it winds.
//!
//! Sources: Whittaker and Watson 1927, chapter 20 (20.3: addition; 20.6: Biermann's formula); Cieslik and Mach 2022, "Revisiting
//! timelike and null geodesics in the Schwarzschild spacetime", Class. Quantum Grav. 39 225003; DLMF 23.9 (Laurent series);
//! Coquereaux, Grossmann and Lautrup 1990, "Iterative method for calculation of the Weierstrass elliptic function", IMA J.
//! Numer. Anal. 10 (series near the pole, then duplication).

use crate::arithmetic::double::Double;
use crate::arithmetic::polynomial::{self, value_and_slope};
use crate::spherical::orbit::{Dense, Fate, State, Stepper, room};
use crate::spherical::plane::Polars;
use crate::spherical::steps::Stretch;
use bhs_elementary::Elementary;

/// Coefficients of the Laurent series of p that are kept.
const TERMS: usize = 14;

/// Largest angle at which the series is used, in units of `min(1, (b/rs)^(1/3))`: about a quarter of the distance to the
/// nearest other pole, so that the first term left out is below rounding.
const SERIES_REACH: f64 = 1.2;

/// One orbit, ready to be evaluated.
#[derive(Clone, Copy, Debug)]
pub struct ClosedForm {
    rs: f64,
    /// `rs u(0)`.
    w0: f64,
    /// `rs u(0) - 2/3`.
    delta0: f64,
    /// `rs u'(0)`.
    slope0: f64,
    /// `rs u''(0)`.
    force0: f64,
    epsilon: f64,
    /// `p = 4/z^2 - 1/3 + series[0] z^2 + series[1] z^4 + ...`
    series: [f64; polynomial::TERMS],
    reach: f64,
}

impl ClosedForm {
    /// The orbit with u(0) = `u` and u'(0) = `du`.
    pub fn new(rs: f64, u: f64, du: f64) -> Self {
        let w = Double::product(rs, u);
        let slope = Double::product(rs, du);
        let delta = w - TWO_THIRDS;
        let epsilon = slope * slope - delta * delta * (delta + Double::new(1.0, 0.0));
        let inverse_b_squared = (epsilon + FOUR_TWENTY_SEVENTHS).value();
        let epsilon = epsilon.value();
        let (w0, delta0) = (w.value(), delta.value());
        let reach = SERIES_REACH * inverse_b_squared.max(1.0).cube_root().sqrt().recip();
        let mut series = [0.0; polynomial::TERMS];
        series[..TERMS].copy_from_slice(&laurent_series(epsilon));
        Self { rs, w0, delta0, slope0: slope.value(), force0: 1.5 * w0 * delta0, epsilon, series, reach }
    }

    /// `(rs/b)^2 - 4/27`, b the impact parameter: positive for what comes from far away and falls in.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// (u, u') at the angle `phi` >= 0, which lies before the orbit's pole (behind the horizon).
    pub fn at(&self, phi: f64) -> (f64, f64) {
        if phi == 0.0 {
            return (self.w0 / self.rs, self.slope0 / self.rs);
        }
        let (p, dp) = self.pole_solution(phi);
        let Self { delta0, slope0, force0, .. } = *self;
        // Slope of the line, and change of delta. Where p' - delta0' and p - delta0 vanish together (the orbit runs along p
        // itself), both are multiplied through by p' + delta0'; which way loses fewer digits, their sizes tell.
        let (gap, sum) = (p - delta0, dp + slope0);
        let (lambda, change) = if sum * sum > gap.abs() * (p * p + p.abs() + delta0 * delta0 + delta0.abs()) {
            let lambda = (p * p + p * delta0 + delta0 * delta0 + p + delta0) / sum;
            (lambda, 2.0 * (force0 * lambda - slope0 * (1.0 + 2.0 * delta0 + p)) / sum)
        } else {
            let lambda = (dp - slope0) / gap;
            (lambda, 2.0 * (force0 - slope0 * lambda) / gap)
        };
        ((self.w0 + change) / self.rs, -(slope0 + lambda * change) / self.rs)
    }

    /// (p, p') at the angle `phi` > 0.
    fn pole_solution(&self, phi: f64) -> (f64, f64) {
        let mut doublings = 0;
        let mut z = phi;
        while z > self.reach {
            z *= 0.5;
            doublings += 1;
        }
        let zz = z * z;
        let (sum, slope) = value_and_slope(&self.series, zz);
        let inverse = zz.recip();
        let mut p = 4.0 * inverse - 1.0 / 3.0 + zz * sum;
        let mut dp = 2.0 * z * (sum + zz * slope - 4.0 * inverse * inverse);

        // p(2z) = (p^4/4 - epsilon (1 + 2p)) / p'^2, and its derivative.
        let e = self.epsilon;
        for _ in 0..doublings {
            let (pp, q) = (p * p, dp * dp);
            let scale = (q * dp).recip();
            let next = (0.25 * pp * pp - e * (1.0 + 2.0 * p)) * dp * scale;
            let rise = pp * pp * (0.25 * pp + 0.5 * p) + e * (5.0 * p * pp + 5.0 * pp + 2.0 * p - 2.0 * e);
            dp = 0.5 * rise * scale;
            p = next;
        }
        (p, dp)
    }
}

/// 2/3 and 4/27 to 32 digits.
const TWO_THIRDS: Double = Double::new(2.0 / 3.0, 3.700_743_415_417_188e-17);
const FOUR_TWENTY_SEVENTHS: Double = Double::new(4.0 / 27.0, 8.223_874_256_482_64e-18);

/// DLMF 23.9.5 for p = 4 wp - 1/3, with g2 = 1/12 and g3 = -1/216 - epsilon/16.
fn laurent_series(epsilon: f64) -> [f64; TERMS] {
    let mut c = [0.0; TERMS];
    c[0] = 1.0 / 60.0;
    c[1] = (-1.0 / 216.0 - epsilon / 16.0) / 7.0;
    // c[i] belongs to z^(2 (i + 1)); in DLMF's numbering k = i + 2.
    for i in 2..TERMS {
        let sum: f64 = (0..=i - 2).map(|m| c[m] * c[i - 2 - m]).sum();
        c[i] = sum * (0.75 / ((2 * i + 5) * (i - 1)) as f64);
    }
    c
}

/// Angle after which the closed form is asked whether the orbit has ended, in radians. Any would do that is below the extent of the
/// orbit's continuations behind the horizon and beyond infinity, some 3 rad each.
pub(crate) const STRETCH: f64 = 1.0;

/// An orbit given by its closed form, in stretches.
#[derive(Clone, Copy, Debug)]
pub struct ExactOrbit<'a> {
    form: &'a ClosedForm,
    state: State,
}

impl<'a> ExactOrbit<'a> {
    /// The orbit from its beginning.
    pub fn new(form: &'a ClosedForm) -> Self {
        let (u, du) = form.at(0.0);
        Self { form, state: State { phi: 0.0, u, du } }
    }
}

/// A stretch of an orbit in closed form.
#[derive(Clone, Copy, Debug)]
pub struct ExactStep<'a> {
    form: &'a ClosedForm,
    start: Polars<f64>,
    end: Polars<f64>,
}

impl<'a> ExactStep<'a> {
    /// That between two states of the orbit `form`.
    pub fn new(form: &'a ClosedForm, start: Polars<f64>, end: Polars<f64>) -> Self {
        Self { form, start, end }
    }
}

fn polars(state: State) -> Polars<f64> {
    let State { phi, u, du } = state;
    Polars { phi, u, du, cos: phi.cosine(), sin: phi.sine() }
}

fn state(p: &Polars<f64>) -> State {
    State { phi: p.phi, u: p.u, du: p.du }
}

impl Dense for ExactStep<'_> {
    fn start(&self) -> State {
        state(&self.start)
    }

    fn end(&self) -> State {
        state(&self.end)
    }

    fn at(&self, phi: f64) -> State {
        let (u, du) = self.form.at(phi);
        State { phi, u, du }
    }

    fn until(self, end: State) -> Self {
        Self { end: polars(end), ..self }
    }
}

impl Stretch<f64> for ExactStep<'_> {
    type One = Self;

    fn start(&self) -> &Polars<f64> {
        &self.start
    }

    fn end(&self) -> &Polars<f64> {
        &self.end
    }

    fn polar(&self, phi: f64) -> Polars<f64> {
        polars(self.at(phi))
    }

    fn lane(&self, _: usize) -> Self {
        *self
    }
}

impl<'a> Stepper for ExactOrbit<'a> {
    type Step = ExactStep<'a>;

    fn advance(&mut self) -> (ExactStep<'a>, Fate) {
        let phi = self.state.phi + room(self.form.rs, &self.state, STRETCH);
        let start = polars(self.state);
        let (u, du) = self.form.at(phi);
        self.state = State { phi, u, du };
        let step = ExactStep { form: self.form, start, end: polars(self.state) };
        (step, step.fate(self.form.rs))
    }
}
