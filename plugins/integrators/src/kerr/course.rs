//! Light around a hole that spins through a world of surfaces.

use crate::arithmetic::polynomial::{value, value_and_slope};
use crate::kerr::arc::TwistedArc;
use crate::kerr::orbit::{Hole, Light, Orbit, State};
use crate::kerr::series::{Series, room};
use crate::spherical::series::SAFETY;
use crate::tracing::driver::{Course, Next};
use crate::tracing::extent::{Extent, free_around};
use bhs_core::lanes::set_bits;
use bhs_core::real::{Mask, Real, Vector};
use bhs_core::spacetime::Kerr;
use bhs_engine::world::World;
use glam::DVec3;

/// How far outside of the sphere around all surfaces a curve may end that goes on to infinity: least 1/r over that of the sphere.
const NEARBY: f64 = 0.125;

/// Attempts at finding such an end.
const ATTEMPTS: u32 = 60;

/// Newton's corrections of where light reaches infinity.
const MOST_CORRECTIONS: u32 = 8;

/// Radius down to which light is followed that falls, over that of the horizon: what is nearer is too dark to be seen, and the twist grows
/// without limit.
const DEEPEST: f64 = 1.0 + 1e-3;

/// Beyond how many masses light that moves outwards never turns back (`docs/physics.md`, section 5).
const OUTSIDE: f64 = 4.0;

/// Longest fixed step of light that falls, as a share of what is left to the horizon.
const SHARE_OF_FALL: f64 = 0.25;

/// How light is stepped.
#[derive(Clone, Copy, Debug)]
pub enum Method<F> {
    /// By Taylor series, with errors of at most so much in a step.
    Taylor(F),
    /// By the classic Runge-Kutta method, in steps of this length (about an angle, rad).
    RungeKutta(f64),
}

/// What is told once of a hole that many rays go around.
#[derive(Clone, Copy, Debug)]
pub struct KerrSetup {
    /// The hole.
    pub hole: Hole,
    /// Radius of the horizon (scene units).
    horizon: f64,
    /// Radius within which nothing stands that light which falls could meet (scene units), not below [`DEEPEST`].
    deepest: f64,
    /// 1/r of a sphere that holds all surfaces (1 / scene unit); infinite where there are none.
    bound: f64,
    /// 1/r of a sphere outside of which no light that moves outwards turns back or meets anything.
    outside: f64,
}

impl KerrSetup {
    /// The hole `kerr` among the surfaces of `world`, whose size is `extent`; light is followed backward.
    pub fn new(world: &World, kerr: &Kerr, extent: &Extent) -> Self {
        let center = kerr.round().center;
        Self::around(kerr, true, extent.around(center), free_around(world, center))
    }

    /// The hole `kerr` among surfaces within the distance `around` from its centre (0: there are none), none of which is nearer than `free`; light
    /// is followed `backward`, or forward.
    pub fn around(kerr: &Kerr, backward: bool, around: f64, free: f64) -> Self {
        let bound = if around > 0.0 { 1.0 / around } else { f64::INFINITY };
        let horizon = kerr.horizon();
        // |x|^2 is at most r^2 + a^2.
        let empty = (free * free - kerr.a() * kerr.a()).max(0.0).sqrt();
        let outside = bound.min(1.0 / (OUTSIDE * 0.5 * kerr.round().rs));
        Self { hole: Hole::new(kerr, backward), horizon, deepest: empty.max(DEEPEST * horizon), bound, outside }
    }

    /// The light from the points `x` along the unit chart tangents `d`, in steps whose points stray from the true ones by about `error` times the
    /// distance from the hole.
    #[inline(always)]
    pub fn by_series<F: Real>(&self, x: Vector<F>, d: Vector<F>, error: F) -> Rays<F> {
        let mut rays = self.by_runge_kutta(x, d, 0.0);
        let least = F::splat(0.5 * f64::EPSILON);
        // What an error changes grows with nearness to the light that winds for ever.
        rays.method = Method::Taylor((F::splat(SAFETY) * error * rays.closeness).max(least));
        rays
    }

    /// The same in fixed steps of the length `step` (about an angle, rad).
    #[inline(always)]
    pub fn by_runge_kutta<F: Real>(&self, x: Vector<F>, d: Vector<F>, step: f64) -> Rays<F> {
        let c = F::splat;
        let Light { orbit, state, norm } = self.hole.light(x, d);
        let horizon = orbit.scale * c(1.0 / self.horizon);
        let deepest = orbit.scale * c(1.0 / self.deepest);
        let (captured, closeness) = orbit.fate(&state, horizon);
        let dark = !norm.gt(c(0.0)) | !state.u.lt(horizon);
        let falls = dark | (captured & state.du.gt(c(0.0)) & state.u.ge(deepest));
        let lost = !falls & !(state.u.gt(c(0.0)) & state.du.is_finite() & orbit.scale.is_finite());
        let series = Series::nowhere(&state);
        let piece = TwistedArc::new(&self.hole, &orbit, series, (c(0.0), c(0.0)));
        let limits = Limits { horizon, deepest, bound: orbit.scale * c(self.bound), outside: orbit.scale * c(self.outside) };
        Rays {
            hole: self.hole,
            method: Method::RungeKutta(step),
            captured,
            closeness,
            limits,
            state,
            s: c(0.0),
            piece,
            begin: (falls, lost),
        }
    }
}

/// What [`KerrSetup`] has, as u of the rays.
#[derive(Clone, Copy, Debug)]
struct Limits<F> {
    horizon: F,
    deepest: F,
    bound: F,
    outside: F,
}

/// Light underway.
#[derive(Clone, Copy, Debug)]
pub struct Rays<F: Real> {
    hole: Hole,
    method: Method<F>,
    /// Which fall into the hole.
    captured: F::Mask,
    /// How near it is to the light that winds for ever, 0 to 1.
    closeness: F,
    limits: Limits<F>,
    /// Where it is, without the turns so far: those are in n.
    state: State<F>,
    s: F,
    piece: TwistedArc<F>,
    begin: (F::Mask, F::Mask),
}

impl<F: Real> Rays<F> {
    /// The next step: its series, its length, and the state at its end.
    #[inline(always)]
    fn step(&self) -> (Series<F>, F, State<F>) {
        let orbit = &self.piece.orbit;
        match self.method {
            Method::Taylor(error) => {
                let series = Series::taylor(orbit, &self.state);
                let h = room(&self.state, self.limits.horizon, series.length(error));
                let (state, turn, _) = series.at(h);
                (series, h, state.turned(turn))
            }
            Method::RungeKutta(step) => {
                let h = self.fixed(step);
                let (series, state) = Series::runge_kutta(orbit, &self.state, h);
                (series, h, state.turned(series.at(h).1))
            }
        }
    }

    /// The step of about the angle `step`, turns about the axis included; next to the horizon, where those grow without limit, no more than a share of
    /// what is left to it.
    #[inline(always)]
    fn fixed(&self, step: f64) -> F {
        let c = F::splat;
        let State { u, du, .. } = self.state;
        let h = c(step) / (c(1.0) + self.piece.orbit.twist(u).abs());
        let left = c(SHARE_OF_FALL) * (self.limits.horizon - u) / du;
        let h = F::select(du.gt(c(0.0)) & left.gt(c(0.0)), h.min(left), h);
        room(&self.state, self.limits.horizon, h)
    }

    /// Lengths of the steps `series` of those of the rays `leaving` for infinity up to where they may end: outside of all surfaces, but not far.
    #[cold]
    fn ends(&self, series: &Series<F>, h: F, end: &State<F>, leaving: F::Mask) -> F {
        let c = F::splat;
        let (bound, near) = (self.limits.bound, c(NEARBY) * self.limits.bound);
        // Where a straight line would have it.
        let wanted = c(0.5 * (1.0 + NEARBY)) * bound;
        let share = ((self.state.u - wanted) / (self.state.u - end.u)).max(c(0.01)).min(c(0.99));
        let guess = share * h;
        let u = value(&series.u, guess);
        let all = F::select(leaving, guess, h);
        let rest = (leaving & !(u.le(bound) & u.ge(near))).bits();
        if rest == 0 {
            return all;
        }
        F::from_fn(|i| {
            if rest >> i & 1 == 0 {
                return all.lane(i);
            }
            let series = series.lane(i);
            let (mut inside, mut outside) = (0.0, h.lane(i));
            for _ in 0..ATTEMPTS {
                let middle = 0.5 * (inside + outside);
                let u = value(&series.u, middle);
                if u > bound.lane(i) {
                    inside = middle;
                } else if u < near.lane(i) {
                    outside = middle;
                } else {
                    return middle;
                }
            }
            inside
        })
    }
}

/// Where u passes `target` between the start and `h` of a step.
fn crossing(series: &Series<f64>, target: f64, h: f64) -> f64 {
    let (mut low, mut high) = (0.0, h);
    let rises = series.u[0] < target;
    let mut t = h;
    for _ in 0..ATTEMPTS {
        let (u, slope) = value_and_slope(&series.u, t);
        if (u < target) == rises {
            low = t;
        } else {
            high = t;
        }
        let newton = t - (u - target) / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= 1e-16 * h {
            return next;
        }
        t = next;
    }
    t
}

impl<F: Real> Course<F> for Rays<F> {
    type Piece = TwistedArc<F>;

    #[inline(always)]
    fn begin(&self) -> (F::Mask, F::Mask) {
        self.begin
    }

    #[inline(always)]
    fn advance(&mut self, which: F::Mask) -> Next<F> {
        let c = F::splat;
        let Limits { horizon, deepest, bound, outside } = self.limits;
        let begin = self.state;
        let (series, h, end) = self.step();
        let falls = which & self.captured & end.du.gt(c(0.0)) & end.u.ge(deepest);
        let escapes = which & end.u.le(c(0.0)) & !falls;
        let gone = begin.u.le(outside) & begin.du.le(c(0.0));
        let mut length = F::select(gone, c(0.0), h);
        let leaving = which & !gone & end.u.lt(c(NEARBY) * bound) & end.du.lt(c(0.0));
        if leaving.any() {
            length = F::select(leaving, self.ends(&series, h, &end, leaving), length);
        }
        let through = falls & end.u.ge(horizon);
        if through.any() {
            let bits = through.bits();
            let last = F::from_fn(|i| {
                if bits >> i & 1 == 0 {
                    return 0.0;
                }
                let target = horizon.lane(i) / DEEPEST;
                if begin.u.lane(i) < target { crossing(&series.lane(i), target, h.lane(i)) } else { 0.0 }
            });
            length = F::select(through, last, length);
        }
        let lost = which & !falls & !(end.u.is_finite() & end.du.is_finite() & h.gt(c(0.0)));
        self.piece = TwistedArc::new(&self.hole, &self.piece.orbit, series, (self.s, length));
        self.state = end;
        self.s += h;
        Next { until: self.s, crosses: F::Mask::NONE, escapes, falls, lost }
    }

    #[inline(always)]
    fn piece(&self) -> &TwistedArc<F> {
        &self.piece
    }

    fn directions(&mut self, which: F::Mask, mut found: impl FnMut(usize, Option<DVec3>, f64)) {
        let c = F::splat;
        let series = &self.piece.series;
        let (u, slope) = value_and_slope(&series.u, c(0.0));
        let start = crate::tracing::arc::Arc::start(&self.piece);
        let h = self.s - start;
        let mut t = (-(u / slope)).max(c(0.0)).min(h);
        let mut right = F::Mask::NONE;
        for _ in 0..MOST_CORRECTIONS {
            let (u, slope) = value_and_slope(&series.u, t);
            let change = u / slope;
            t = F::select(right, t, t - change);
            right = right | (change.abs().le(c(1e-8) * h) & t.ge(c(0.0)) & t.le(h));
            if (right | !which).all() {
                break;
            }
        }
        let bits = right.bits();
        let t = F::from_fn(|i| {
            let is_right = bits >> i & 1 == 1 || which.bits() >> i & 1 == 0;
            if is_right { t.lane(i) } else { crossing(&series.lane(i), 0.0, h.lane(i)) }
        });
        let (state, turn) = series.place(t);
        let directions = self.hole.chart(state.turned(turn).n);
        let parameters = start + t;
        for i in set_bits(which.bits()) {
            let direction = directions.lane(i);
            found(i, direction.is_finite().then_some(direction), parameters.lane(i));
        }
    }
}

impl<F: Real> Rays<F> {
    /// The constants of the light.
    pub fn orbit(&self) -> &Orbit<F> {
        &self.piece.orbit
    }
}
